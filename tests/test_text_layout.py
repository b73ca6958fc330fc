"""How text is drawn: the same on every machine, and never wrong."""

from __future__ import annotations

import ast
import unicodedata
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFont, features

import vrcomfort
from vrcomfort import text_layout
from vrcomfort.api.rendering import describe_machine
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.texts import WORDS
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.respondent import InstructionContent
from vrcomfort.respondent.panel_layout import review_cells
from vrcomfort.respondent.panel_picture import Page, Painter, instruction_page
from vrcomfort.text_layout import TextCanvas, as_drawn, composed, font_for, undrawable, usual_font

ROOT = Path(vrcomfort.__file__).parent.parent
GERMAN_PAGE = Page("Größe – AVA", "Ich fühle mich fit, trifft vollständig zu", ())
WRITES = {"text", "multiline_text", "textlength", "textbbox", "multiline_textbbox"}
"""Methods of ImageDraw that lay text out."""


def drawn(page: Page) -> np.ndarray:
    return Painter().draw(page, None)


def width_of(text: str) -> float:
    return TextCanvas(Image.new("L", (1, 1))).width_px(text, 40)


@pytest.mark.parametrize("has_raqm", [False, True])
def test_the_layout_engine_does_not_depend_on_the_libraries_of_a_machine(monkeypatch, has_raqm):
    before = drawn(GERMAN_PAGE), drawn(Page("Back", "Nausea", ()))
    text_layout._face.cache_clear()
    monkeypatch.setattr(ImageFont.core, "HAVE_RAQM", has_raqm)
    assert features.check("raqm") is has_raqm
    for page, picture in zip((GERMAN_PAGE, Page("Back", "Nausea", ())), before, strict=True):
        assert page.font.face(38).layout_engine is ImageFont.Layout.BASIC
        assert np.array_equal(drawn(page), picture)
    text_layout._face.cache_clear()


def text_calls(source: str) -> set[str]:
    """Return the names with which a module lays text out by Pillow itself."""
    tree = ast.parse(source)
    imported = {
        alias.name.rpartition(".")[2]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    calls = {
        node.func.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    }
    return (imported & {"ImageFont", "ImageText"}) | (
        calls & WRITES if "ImageDraw" in imported else set()
    )


def test_text_is_laid_out_in_one_place():
    assert text_calls("from PIL import ImageDraw\nImageDraw.Draw(a).text((0, 0), 'b')") == {"text"}
    assert text_calls("import PIL.ImageFont") == {"ImageFont"}
    sources = {
        file.relative_to(ROOT).as_posix(): file.read_text("utf-8")
        for folder in ("vrcomfort", "scripts", "bench", "scenes")
        for file in (ROOT / folder).rglob("*.py")
    }
    draw = {name: source for name, source in sources.items() if "PIL" in source}
    assert len(draw) > 10
    assert [n for n, source in draw.items() if text_calls(source)] == ["vrcomfort/text_layout.py"]


def test_the_manifest_says_what_draws_text(ctx):
    nothing_shown = load_protocol("smoke").model_copy(update={"scenes": ()})
    machine = describe_machine(StereoRenderer(ctx, (16, 16)), nothing_shown)
    facts = dict(machine.text_layout)
    assert facts.pop("engine") == "Pillow basic"
    assert facts.pop("freetype") == features.version("freetype2")
    assert sorted(facts) == ["Aileron", "DejaVu Sans"]
    assert all(float(version) > 1 for version in facts.values())


@pytest.mark.parametrize(
    "text",
    [
        "Größe, été, Łódź, çà, ı İ, Ő, Ș ș",
        "Tiếng Việt: Bạn có buồn nôn không?",
        "Πόσο ναυτία; Ἀθῆναι",
        "Тошнота, йод, Ёж, їжак",
        "გულისრევა",
        "1 ½ · 20 °C – ‘a’ “b” … − × ≤ →",
        "deux\u00a0mots\u202f? ligne\nune\tdeux",
    ],
)
def test_letters_that_stand_alone_are_drawn(text):
    assert undrawable(text) == []
    assert undrawable(unicodedata.normalize("NFD", text)) == []
    assert as_drawn(unicodedata.normalize("NFD", text)) == composed(text)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("שלום", "ש U+05E9 (right to left)"),
        ("مرحبا", "م U+0645 (right to left)"),
        ("٣", "٣ U+0663 (right to left)"),
        ("ẹ́", "U+0301 (combining mark)"),
        ("ละ\u0e49", "ล U+0E25 (not in the font)"),
        ("ຂ\u0ec9", "U+0EC9 (combining mark)"),
        ("नमस्ते", "न U+0928 (not in the font)"),
        ("日本", "日 U+65E5 (not in the font)"),
        ("☺\ufe0f", "U+FE0F (combining mark)"),
        ("👩\u200d🔬", "U+200D (invisible)"),
        ("Wort\u00adteil", "U+00AD (invisible)"),
        ("\u202eabc", "U+202E (invisible)"),
        ("\ue000\uf400", "U+F400 (not in the font)"),
        ("a\x07", "U+0007 (control character)"),
        ("a\u2028b", "U+2028 (invisible)"),
    ],
)
def test_a_character_that_would_come_out_wrong_is_known(text, says):
    assert says in undrawable(text)


def test_what_cannot_be_drawn_is_replaced_and_no_page_fails():
    for text in ("شلام abc", "e\u0323\u0301", "日", "\ue000"):
        mark = as_drawn(text)
        assert "\ufffd" in mark
        assert np.array_equal(drawn(Page(text, text, ())), drawn(Page(mark, mark, ())))
    assert not np.array_equal(drawn(Page("", "日", ())), drawn(Page("", "", ())))


def test_a_letter_and_its_mark_are_drawn_as_the_one_letter_that_they_are():
    two, one = "Cafe\u0301 a\u0308", "Café ä"
    assert np.array_equal(drawn(Page(two, two, ())), drawn(Page(one, one, ())))
    assert width_of(two) == width_of(one)
    canvas = TextCanvas(Image.new("L", (1, 1)))
    assert canvas.fits(two, 40, width_of(one))


@pytest.mark.parametrize("length", range(4, 24))
def test_a_long_question_is_not_cut_between_a_letter_and_its_mark(length):
    ssq = shipped_instruments()["ssq"]
    item = replace(ssq.items[0], text="a" * length + "e\u0301" + "b" * 40)
    cell, *_ = review_cells(replace(ssq, items=(item,)), [1])
    assert "\u0301" not in cell.text
    assert "e" not in cell.text.partition("…")[0]


def test_lines_are_broken_at_spaces_but_not_at_those_that_forbid_it():
    canvas = TextCanvas(Image.new("L", (1, 1)))
    narrow = canvas.width_px("Avez-vous", 40)
    assert canvas.wrapped("Avez-vous mal ?", 40, narrow) == "Avez-vous\nmal ?"
    assert canvas.wrapped("vous mal\u202f?", 40, canvas.width_px("mal\u202f?", 40)) == (
        "vous\nmal\u202f?"
    )
    assert canvas.wrapped("Unwohlsein", 40, 1.0) == "Unwohlsein"  # wider than its room
    assert canvas.wrapped(" \n", 40, 100.0) == ""
    room = canvas.width_px("einver-", 40)
    assert (
        canvas.wrapped("ganz einverstanden", 40, room, hyphens=True) == "ganz\neinver-\nstand-\nen"
    )


def test_a_label_of_two_lines_is_as_wide_as_the_wider_one():
    assert width_of("a\nlonger") == width_of("longer")


def test_a_page_has_one_font_and_the_usual_one_where_it_has_all_letters():
    assert font_for("Nausea", "“none” …") is usual_font()
    assert font_for("Nausea", "keine Übelkeit").name == "DejaVu Sans"
    assert instruction_page(InstructionContent("a", "Grüße"), ready=True).font.name == "DejaVu Sans"


def test_all_shipped_words_are_drawn():
    texts = [text for words in WORDS.values() for text in words.model_dump().values()]
    for each in shipped_instruments().values():
        for language in (each.language, *each.translations):
            spoken = each.in_language(language) or each
            texts += [spoken.instruction, *spoken.labels, *(item.text for item in spoken.items)]
    assert len(texts) > 200
    assert undrawable("\n".join(texts)) == []
