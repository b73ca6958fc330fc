"""Answers in one's own words: typed, kept to the letter, asked once, exported, and left out."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.console.test_verbal import Experimenter
from tests.respondent.test_respondent import Typist, terminal
from tests.session.test_panel import ScriptedScreen
from tests.support.operator import Given
from tests.support.protocols import ASKED_AFTER_EACH, NOBODY_LEAVES, protocol_text
from tests.support.study import Scripted, read_rows
from tests.support.tasks import do, doing_protocol
from vrcomfort.console.server import read_command
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.psych_ds import export_psych_ds
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol.texts import ENGLISH
from vrcomfort.records.rows import cell_text
from vrcomfort.records.session_rows import LONGEST_TEXT, in_lines, one_line
from vrcomfort.respondent import keyboard
from vrcomfort.respondent.base import Withdrew, Written
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_input import Pointing
from vrcomfort.respondent.panel_layout import rest_cells
from vrcomfort.respondent.panel_picture import Page, Painter
from vrcomfort.session import NoPictures, StillHeadset
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.verbal import VerbalRespondent

PROTOCOL = protocol_text(
    ASKED_AFTER_EACH,
    """\
[[free_texts]]
name = "noticed"
text = "What did you notice?"
when = "after_trial"

[[free_texts]]
name = "anything"
text = "Anything else?"
when = "session_end"

[text.de.free_texts]
noticed = "Was ist Ihnen aufgefallen?"
anything = "Noch etwas?"
""",
    NOBODY_LEAVES,
    name="telling",
    keys='languages = ["en", "de"]\n',
)
AWKWARD = 'She said "no",\nthen: a\\nb\t=1+1; ünïcode 漢字 🙂\r\n\u2028\x85\x1b[0m \x00 end'


class Says(Scripted):
    """Answers each open question with the next text."""

    def __init__(self, *texts, **more):
        super().__init__(**more)
        self.texts, self.questions = list(texts), []

    def write(self, question):
        self.questions.append(question)
        return Written(self.texts.pop(0), 1.5)


def tell(folder, respondent=None, text=PROTOCOL, **more):
    return do(folder, text, respondent=respondent, **more)


def texts(folder):
    return read_rows(folder / "S/sub-P01/ses-1/texts.csv")


@given(st.text(st.characters(exclude_characters="\r")))
@settings(max_examples=60)
def test_any_text_comes_back_and_is_one_line(text):
    line = one_line(text)
    assert in_lines(line) == text
    assert len(line.splitlines()) <= 1
    assert cell_text(line) == line
    line.encode()


def test_what_was_said_is_kept_to_the_letter_with_its_place(tmp_path):
    tell(tmp_path, Says(AWKWARD, "", "x" * (LONGEST_TEXT + 5)))
    rows = texts(tmp_path)
    assert [(row["trial"], row["question"]) for row in rows] == [
        ("1", "noticed"), ("2", "noticed"), ("", "anything"),
    ]  # fmt: skip
    assert in_lines(rows[0]["text"]) == AWKWARD.replace("\r\n", "\n")
    assert {row["condition"] for row in rows} == {"plain", "blur", ""}
    assert rows[1]["text"] == ""
    assert rows[2]["text"] == "x" * LONGEST_TEXT
    events = read_rows(tmp_path / "S/sub-P01/ses-1/events.csv")
    assert [row["detail"] for row in events if row["name"] == "free_text_cut"] == [
        "anything: only the first 20000 of 20005 characters are kept"
    ]
    assert not any("She said" in row["detail"] for row in events)  # it stands in one file alone
    assert not verify_study(tmp_path / "S").faults


def test_the_question_is_asked_in_the_participants_language(tmp_path):
    person = Says("a", "b", "c")
    tell(tmp_path, person, language="de")
    assert person.questions == ["Was ist Ihnen aufgefallen?"] * 2 + ["Noch etwas?"]


def test_a_session_that_goes_on_asks_what_is_open_and_nothing_twice(tmp_path):
    class Leaves(Says):
        def write(self, question):
            if len(self.questions) == 1:
                raise KeyboardInterrupt
            return super().write(question)

    assert tell(tmp_path, Leaves("first")).status == "aborted"
    again = Says("second", "third")
    assert tell(tmp_path, again, resume=True).status == "completed"
    assert [(row["text"], row["resumed"]) for row in texts(tmp_path)] == [
        ("first", "0"), ("second", "1"), ("third", "1"),
    ]  # fmt: skip
    assert not verify_study(tmp_path / "S").faults


def test_who_stops_an_exposure_is_still_asked_what_they_noticed(tmp_path):
    assert tell(tmp_path, Says("too much", withdraw_at_s=0.5)).status == "withdrawn"
    assert [row["text"] for row in texts(tmp_path)] == ["too much"]


def test_simulated_participants_say_the_same_with_and_without_frames(tmp_path):
    tell(tmp_path / "a")
    jumps = {"renderer": NoPictures(), "load_scene": lambda _: None, "jumps": True}
    tell(tmp_path / "b", headset_for=lambda *_: StillHeadset(), **jumps)
    said = [[row["text"] for row in texts(tmp_path / each)] for each in "ab"]
    assert len(said[0]) == 3
    assert said[0] == said[1]
    without = PROTOCOL.split("[[free_texts]]", maxsplit=1)[0] + PROTOCOL[PROTOCOL.index("[sim") :]
    tell(tmp_path / "c", text=without)
    asked = "S/sub-P01/ses-1/questionnaires.csv"
    answers = [
        [row["response"] for row in read_rows(tmp_path / each / asked)] for each in ("a", "c")
    ]
    assert answers[0] == answers[1]


def test_an_experimenter_types_lines_until_an_empty_one():
    person, shown = terminal(Typist("My eyes,", "  and the", keyboard.STOP, ""))
    assert person.write("How was it?").text == f"My eyes,\n  and the\n{keyboard.STOP}"
    assert "How was it?" in shown.getvalue()
    with pytest.raises(Withdrew):
        terminal(Typist(keyboard.STOP, keyboard.YES))[0].write("How was it?")
    assert (
        terminal(Typist(keyboard.STOP, keyboard.NO, "fine", ""))[0].write("How was it?").text
        == "fine"
    )
    assert terminal(Typist(""))[0].write("How was it?").text == ""


def test_on_the_panel_the_participant_tells_it_and_the_experimenter_types():
    screen = ScriptedScreen([])
    lines = iter([None, "It flickered,\n", None, "I think.\n", "\n"])
    asked = []
    person = PanelRespondent(screen, waiting_line=lambda: next(lines), prompt=asked.append)
    screen.upcoming(Pointing())
    assert person.write("How was it?").text == "It flickered,\nI think."
    assert asked == ["How was it?"]
    page = Page(ENGLISH.say_aloud, "How was it?", rest_cells())
    assert np.array_equal(screen.pictures[0], Painter().draw(page, None))
    assert screen.frames == 5  # none of them waited for the typist
    assert screen.pictures[-1] is None


def test_on_the_console_it_is_entered_with_its_lines():
    message = {"id": "1", "action": "write", "step": 3, "text": "one\n  two "}
    assert read_command(json.dumps(message)).text == "one\n  two"
    desk = Experimenter()
    operators = OperatorControl(desk)
    operators.begin("questionnaire", "free text")
    refused = Given("confirm", desk.steps[-1].number, "B", "")
    taken = Given("write", desk.steps[-1].number, "B", "one\ntwo")
    commands = iter([refused, taken])
    desk.next_command = lambda: next(commands, None)
    assert VerbalRespondent(desk, operators).write("How was it?").text == "one\ntwo"
    assert [reply for _, reply in desk.replies] == ["this question takes no confirm", ""]
    assert desk.questions[0]["items"][0]["text"] == "How was it?"
    assert desk.question is None


def test_it_is_exported_and_left_out_of_what_is_shared(tmp_path):
    tell(tmp_path, Says(AWKWARD, "b", "c"))
    export_psych_ds(tmp_path / "S", tmp_path / "dataset")
    (file,) = (tmp_path / "dataset/data").glob("*texts*")
    assert in_lines(read_rows(file)[0]["text"]) == AWKWARD.replace("\r\n", "\n")
    assert "may tell who gave it" in (tmp_path / "dataset/README.md").read_text(encoding="utf-8")
    anonymise(tmp_path / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    assert not list((tmp_path / "shared").rglob("texts.csv"))
    record = (tmp_path / "shared/anonymised.json").read_text(encoding="utf-8")
    assert json.loads(record)["files_left_out"]["texts.csv"] == "own words"
    assert not any(b"She said" in each.read_bytes() for each in (tmp_path / "shared").rglob("*.*"))
    assert not verify_study(tmp_path / "shared").faults


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('name = "anything"', 'name = "noticed"', "noticed"),
        ('text = "Anything else?"', 'text = ""', "at least 1"),
        ('text = "Anything else?"', 'text = "  "', "has an empty question; write its `text`"),
        ('text = "Anything else?"', f'text = "{"why " * 500}"', "why why …"),
        ('anything = "Noch etwas?"\n', "", "`anything` is not worded in `de`"),
        ("[simulation]", '[text.en.free_texts]\nanythink = "x"\n[simulation]', "did you mean `any"),
        ('"session_end"', '"sometimes"', "session_end"),
    ],
)
def test_what_cannot_be_asked_is_refused(tmp_path, old, new, says):
    with pytest.raises(InputError) as refused:
        doing_protocol(tmp_path, PROTOCOL.replace(old, new))
    assert says in str(refused.value)
    assert refused.value.line is not None
