"""Languages: what participants read, what is recorded of it, and what a language must not lack."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.support.session import run
from tests.support.study import PROTOCOL, AheadHeadset, LateFocus, Scripted, tiny_protocol
from vrcomfort.cli.app import app
from vrcomfort.errors import InputError
from vrcomfort.protocol import load_protocol
from vrcomfort.protocol.texts import ENGLISH, GERMAN, Words
from vrcomfort.questionnaire import find_instrument, score
from vrcomfort.records import session_folder
from vrcomfort.resources import data_folder
from vrcomfort.respondent.panel_layout import question_cells
from vrcomfort.respondent.panel_picture import Page, Painter

BOTH = 'languages = ["en", "de"]\n'
SSQ_ITEMS = [item.name for item in find_instrument("ssq").items]


def dutch(*, without: str = "", words: bool = True) -> str:
    """Return a file outside the package that adds Dutch to the tiny study."""
    said = [f'{key} = "F {value}"' for key, value in ENGLISH.model_dump().items()]
    items = [f'{name} = "F {name}"' for name in SSQ_ITEMS if name != without]
    return "\n".join(
        [
            '[text.nl]\nsource = "Jansen 2026"\n[text.nl.words]',
            *(said if words else []),
            '[text.nl.instruments.ssq]\ninstruction = "Quoi ?"',
            'labels = ["un", "deux", "trois", "quatre"]\n[text.nl.instruments.ssq.items]',
            *items,
            '[text.nl.instruments.fms]\ninstruction = "Mal ?"\nlabels = ["non", "oui"]',
            'items = { fms = "Mal" }',
        ]
    )


class Reading(Scripted):
    """Notes what it reads."""

    def __init__(self) -> None:
        super().__init__()
        self.read: list[tuple[str, str, tuple[str, ...]]] = []

    def ask(self, form, heard):
        first = form.instrument.items[0]
        self.read.append((form.instrument.instruction, first.text, first.answers.labels))
        super().ask(form, heard)

    def prompt(self, instrument, *rest):
        self.read.append((instrument.instruction, "", instrument.items[0].answers.labels))
        super().prompt(instrument, *rest)


def session(tmp_path, protocol, respondent, **more):
    run(
        protocol,
        "P01",
        study=tmp_path / "S",
        sessions=[1],
        load_scene=lambda _: None,
        headset_for=lambda *_: AheadHeadset(),
        renderer=LateFocus(),
        respondent=respondent,
        **more,
    )
    folder = session_folder(tmp_path / "S", "P01", 1)
    return json.loads((folder / "manifest.json").read_text(encoding="utf-8"))


def test_a_german_participant_reads_german_and_the_manifest_says_whose(tmp_path):
    respondent = Reading()
    protocol = tiny_protocol(tmp_path, f"{BOTH}{PROTOCOL}").spoken("de")
    manifest = session(tmp_path, protocol, respondent)
    questionnaire, rating = respondent.read[0], respondent.read[1]
    assert questionnaire == (
        "Wie stark haben Sie die folgende Beschwerde im Augenblick?",
        "Allgemeines Unwohlsein",
        ("gar nicht", "leicht", "mittel", "stark"),
    )
    assert rating[0].startswith("Wie übel ist Ihnen")
    assert rating[2] == ("keine Übelkeit", "stärkste Übelkeit")
    assert manifest["language"] == "de"
    assert manifest["wordings"] == [
        {
            "instrument": "ssq",
            "language": "de",
            "source": "our own translation of the symptoms, not validated",
        },
        {
            "instrument": "fms",
            "language": "de",
            "source": "our own translation of our question; range and ends are the paper's",
        },
    ]


def test_without_languages_each_instrument_keeps_its_own(tmp_path):
    respondent = Reading()
    manifest = session(tmp_path, tiny_protocol(tmp_path).spoken(None), respondent)
    assert respondent.read[0][1] == "General discomfort"
    assert manifest["language"] is None
    with pytest.raises(InputError, match="is not asked in `de`; it has none: write `languages`"):
        tiny_protocol(tmp_path).spoken("de")


def test_the_first_language_is_the_usual_one(tmp_path):
    text = f'languages = ["de", "en"]\n{PROTOCOL}'
    assert tiny_protocol(tmp_path, text).spoken(None).language == "de"


@pytest.mark.parametrize("name", ["ssq", "fms", "misc"])
def test_shipped_german_is_whole_and_scores_as_the_english(name):
    english = find_instrument(name)
    german = english.in_language("de")
    assert german is not None
    assert english.wording_source("de")
    assert english.wording_source("en") == english.licence
    assert english.wording_source("nl") == ""
    assert [item.name for item in german.items] == [item.name for item in english.items]
    for here, there in zip(german.items, english.items, strict=True):
        assert here.text != there.text
        assert here.answers.asked == there.answers.asked
        assert len(here.answers.labels) == len(there.answers.labels)
    answers = {item.name: item.answers.asked[n % 3] for n, item in enumerate(english.items)}
    assert score(german, answers) == score(english, answers)


def test_a_new_language_comes_from_a_file_outside_the_package(tmp_path):
    (tmp_path / "dutch.toml").write_text(dutch(), encoding="utf-8")
    text = f'include = ["dutch.toml"]\nlanguages = ["en", "nl"]\n{PROTOCOL}'
    protocol = tiny_protocol(tmp_path, text).spoken("nl")
    respondent = Reading()
    manifest = session(tmp_path, protocol, respondent)
    assert respondent.read[0] == (
        "Quoi ?",
        "F general_discomfort",
        ("un", "deux", "trois", "quatre"),
    )
    assert protocol.words.back == "F Back"
    assert {each["source"] for each in manifest["wordings"]} == {"Jansen 2026"}


@pytest.mark.parametrize(
    ("more", "told", "line"),
    [
        (
            dutch(without="nausea"),
            "the SSQ lacks in `nl`: item nausea; write it into",
            "[text.nl]",
        ),
        (dutch(words=False), "`nl` lacks words of the panel: back, decline,", "[text.nl]"),
        ("", "the FMS lacks in `nl`: the instruction, the labels of its answers,", "languages = "),
        (
            dutch().replace('back = "F Back"', 'bakc = "x"\nback = "F Back"'),
            "the panel has no `bakc`; did you mean `back`?",
            "bakc",
        ),
        (
            dutch().replace("{minutes}", "{hours}"),
            "`rest_minutes` has braces that stand for nothing",
            "rest_minutes",
        ),
        (dutch().replace('"trois", ', ""), "3 labels, and the SSQ has 4", "labels"),
        (
            dutch().replace("burping =", "burp ="),
            "there is no item `burp`; did you mean `burping`?",
            "burp",
        ),
        (dutch().replace("text.nl", "text.it"), "`it` is not among `languages`", "[text.it]"),
    ],
)
def test_a_language_that_lacks_something_is_refused_with_place(tmp_path, more, told, line):
    text = f'languages = ["en", "nl"]\n{PROTOCOL}\n{more}\n'
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text)
    found = [each for each in (caught.value.alone, *caught.value.others) if told in str(each)]
    assert found, str(caught.value)
    assert text.splitlines()[found[0].line - 1].startswith(line)


def test_a_session_is_resumed_in_its_language(tmp_path):
    class Interrupting(Scripted):
        def ask(self, form, heard):
            if form.timepoint == "post":
                raise KeyboardInterrupt
            super().ask(form, heard)

    protocol = tiny_protocol(tmp_path, f"{BOTH}{PROTOCOL}")
    session(tmp_path, protocol.spoken("de"), Interrupting())
    with pytest.raises(InputError, match="begun with --language de; resume it with the same"):
        session(tmp_path, protocol.spoken("en"), Scripted(), resume=True)
    assert session(tmp_path, protocol.spoken("de"), Scripted(), resume=True)["language"] == "de"


def test_run_goes_on_in_the_language_of_the_last_session(tmp_path):
    from vrcomfort.cli.run import RunOptions

    protocol = tiny_protocol(tmp_path, f"{BOTH}{PROTOCOL}")
    options = RunOptions(protocol=str(protocol.file), participant="P01", out=tmp_path / "S")
    assert options.spoken_protocol().language == "en"
    session(tmp_path, protocol.spoken("de"), Scripted())
    assert options.spoken_protocol().language == "de"


def test_umlauts_and_sharp_s_have_glyphs_in_the_panel():
    painter, words = Painter(), GERMAN
    answers = find_instrument("ssq").in_language("de").answers

    def picture(question: str) -> np.ndarray:
        cells = question_cells(answers, first=False, words=words)
        return painter.draw(Page("", question, cells), None)

    boxes = {letter: picture(letter) for letter in "äöüÄÖÜßé"}
    missing = picture("\ue000")  # nobody's letter: what a font shows where it has none
    for letter, drawn in boxes.items():
        assert not np.array_equal(drawn, missing), letter
    pairs = [("ä", "a"), ("ö", "o"), ("ü", "u"), ("ß", "s")]
    for letter, plain in pairs:
        assert not np.array_equal(boxes[letter], picture(plain))


def test_a_study_without_the_language_is_refused_by_the_command(tmp_path):
    out = str(tmp_path / "S")
    arguments = ["simulate", "smoke", "-n", "1", "--out", out, "--language", "de"]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, InputError)
    assert "is not asked in `de`" in str(result.exception)
    assert not (tmp_path / "S").exists()


def test_every_word_of_the_panel_has_a_german_one():
    same = [key for key in Words.model_fields if getattr(GERMAN, key) == getattr(ENGLISH, key)]
    assert same == []
    assert load_protocol(data_folder("protocols") / "smoke.toml").words == ENGLISH


def test_a_language_that_is_there_twice_is_refused_in_one_sentence(tmp_path):
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, f'languages = ["en", "en"]\n{PROTOCOL}')
    assert "`en` is there twice" in str(caught.value)
    assert "\n" not in str(caught.value)
