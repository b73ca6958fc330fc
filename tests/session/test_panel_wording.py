"""Words that the panel cannot draw are refused before anybody comes, with place and remedy."""

from __future__ import annotations

import pytest
from PIL import Image

from tests.questionnaire.test_languages import BOTH, dutch
from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.api.study_setup import RespondentKind, require_wording
from vrcomfort.errors import InputError
from vrcomfort.resources import data_folder
from vrcomfort.session.panel_wording import undrawable_wording

TOLD = '\n[[instructions]]\nname = "hi"\nwhen = "session_start"\ntext = "{}"\n'
WRITTEN = '\n[[free_texts]]\nname = "seen"\nwhen = "session_end"\ntext = "{}"\n'
IN_DUTCH = 'languages = ["en", "nl"]\n'
NON = 'labels = ["non"'
ARABIC = "مرحبا"


def own_scale(folder, instruction="How?", item="Dizzy", label="very"):
    (folder / "mine.toml").write_text(
        f'name = "mine"\ntitle = "Mine"\ninstruction = "{instruction}"\n[answers]\nlow = 0\n'
        f'high = 3\nlabels = ["not", "{label}"]\n[[items]]\nname = "dizzy"\ntext = "{item}"\n'
        '[[items]]\nname = "tired"\ntext = "Tired"\n',
        encoding="utf-8",
    )
    return (
        '\n[[questionnaires]]\ninstrument = "mine.toml"\ntimepoint = "own"\nwhen = "session_end"\n'
    )


def faults(folder, text, language=None, **more):
    protocol = tiny_protocol(folder, text).spoken(language)
    return [str(each) for each in undrawable_wording(protocol, **more)]


def line_of(text, part):
    return text[: text.index(part)].count("\n") + 1


def test_what_all_have_is_not_refused(tmp_path):
    more = TOLD.format("Grüße – Cafe\u0301") + WRITTEN.format("Τι;") + own_scale(tmp_path)
    assert faults(tmp_path, PROTOCOL + more) == []
    assert faults(tmp_path, BOTH + PROTOCOL, "de") == []
    assert faults(tmp_path, IN_DUTCH + PROTOCOL + dutch(), "nl") == []


@pytest.mark.parametrize(
    ("more", "says", "remedy"),
    [
        (
            TOLD,
            "instruction `hi` cannot be drawn on the panel: م U+0645 (right to left),",
            "`picture`",
        ),
        (WRITTEN, "free text `seen` cannot be drawn on the panel: م", "--respondent console"),
    ],
)
def test_a_text_is_refused_with_its_place_and_a_remedy(tmp_path, more, says, remedy):
    text = PROTOCOL + more.format(ARABIC)
    (fault,) = faults(tmp_path, text)
    assert fault.startswith(f"{tmp_path / 'tiny.toml'}, line {line_of(text, ARABIC)}, column 1: ")
    assert says in fault
    assert "and 2 more; the panel draws" in fault
    assert remedy in fault


@pytest.mark.parametrize(
    ("key", "says"),
    [
        ("instruction", "the instruction of the MINE cannot"),
        ("item", "item `dizzy` of the MINE cannot"),
        ("label", "an answer of the MINE cannot"),
    ],
)
def test_an_instrument_is_refused_where_it_is_asked(tmp_path, key, says):
    text = PROTOCOL + own_scale(tmp_path, **{key: "日本"})
    (fault,) = faults(tmp_path, text)
    assert f"line {line_of(text, 'mine.toml')}, column 1: {says}" in fault
    assert "日 U+65E5 (not in the font), 本 U+672C (not in the font); " in fault
    assert faults(tmp_path, text, asked_aloud=True) == []


def test_the_words_of_a_language_are_refused_in_that_language_alone(tmp_path):
    text = (
        IN_DUTCH + PROTOCOL + dutch().replace('"F Back"', f'"{ARABIC}"').replace('"F Rest"', '"א"')
    )
    assert faults(tmp_path, text, "en") == []
    for more in ({}, {"asked_aloud": True}):  # they are there whoever asks
        (fault,) = faults(tmp_path, text, "nl", **more)
        assert f"line {line_of(text, 'back =')}, column 1: `back` of the panel's words" in fault
        assert "and 1 more like it, cannot be drawn" in fault


def test_the_wording_of_an_instrument_is_refused_in_the_table_of_its_language(tmp_path):
    text = IN_DUTCH + PROTOCOL + dutch().replace('"F nausea"', '"ན"').replace('"oui"', '"א"')
    ssq, fms = faults(tmp_path, text, "nl")
    assert f"line {line_of(text, 'nausea =')}, column 1: item `nausea` of the SSQ cannot" in ssq
    assert f"line {line_of(text, NON)}, column 1: an answer of the FMS cannot" in fms


def test_check_and_run_refuse_and_nothing_is_recorded(run, tmp_path):
    text = (data_folder("protocols") / "smoke.toml").read_text(encoding="utf-8")
    file, study = tmp_path / "own.toml", tmp_path / "S"
    file.write_text(text + TOLD.format(ARABIC), encoding="utf-8")
    person = ("run", file, "--participant", "P01", "--out", study)
    for words in (("check", file, "--no-draw"), (*person, "--respondent", "simulated"),
                  (*person, "--headset", "desktop")):  # fmt: skip
        code, _, said = run(*words)
        assert code == 2
        assert said.count("error: ") == 1
        assert "own.toml, line" in said
        assert "instruction `hi` cannot be drawn on the panel: م U+0645" in said
    assert not study.exists()


def test_nothing_is_refused_where_no_panel_is(tmp_path):
    protocol = tiny_protocol(tmp_path, PROTOCOL + TOLD.format(ARABIC) + WRITTEN.format("日"))
    for kind in (RespondentKind.TERMINAL, RespondentKind.CONSOLE):
        require_wording(protocol, kind, in_headset=False)
        with pytest.raises(InputError, match="instruction `hi`"):
            require_wording(protocol, kind, in_headset=True)
    asked = tiny_protocol(tmp_path, PROTOCOL + WRITTEN.format("日"))
    require_wording(asked, RespondentKind.CONSOLE, in_headset=True)  # asked aloud
    with pytest.raises(InputError, match="free text `seen`"):
        require_wording(asked, RespondentKind.PANEL, in_headset=True)


def test_a_picture_may_stand_for_the_text_of_a_language(tmp_path):
    Image.new("RGB", (20, 10)).save(tmp_path / "hi.png")
    table = '[text.de.instructions.hi]\npicture = "hi.png"\n'
    text = BOTH + PROTOCOL + TOLD.format("Hello") + table
    with pytest.raises(InputError, match="lacks its text in `de`"):
        tiny_protocol(tmp_path, text)
    protocol = tiny_protocol(tmp_path, text + 'text = ""\n').spoken("de")
    assert [(each.text, each.picture) for each in protocol.told] == [("", "hi.png")]
    with pytest.raises(InputError, match="lacks its text in `de`"):
        tiny_protocol(tmp_path, text.replace('picture = "hi.png"', 'text = ""'))
