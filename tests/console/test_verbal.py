"""Answers that an experimenter enters on the console have the rows of any other answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import pytest

from tests.support.operator import Given, ScriptedDesk, Wanted
from tests.support.resume import attempts, go, manifest, rows
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.operator_interface import Command
from vrcomfort.protocol.texts import ENGLISH
from vrcomfort.session import operator_control
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.verbal import VerbalRespondent


@pytest.fixture(autouse=True)
def _no_waiting_between_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock is the test's."""
    monkeypatch.setattr(operator_control, "IDLE_S", 0.0)


@dataclass
class Experimenter(ScriptedDesk):
    """Answers what is asked: 1 to every item, 3 to a rating, and what `first` says before that."""

    first: Sequence[Command] = ()
    question: Any = None
    questions: list[Any] = field(default_factory=list)

    def ask(self, question: Any) -> None:
        if question and question["action"] == "answer":
            answered = [item["answered"] for item in question["items"]]
            assert question["current"] == [*answered, False].index(False)
        self.question = question
        self.questions.append(question)

    def next_command(self) -> Command | None:
        if (question := self.question) is None:
            return None
        step = self.steps[-1].number
        if question["current"] == len(question["items"]):
            self.question = None
            return Given("confirm", step, "B", "")
        if question["action"] == "answer" and self.first:
            given, *self.first = self.first
            if not refused_soon(given):
                self.question = None  # until it is asked again
            return Given(given.action, step, "B", given.text, given.value)
        self.question = None
        value = 3 if question["action"] == "rate" else 1
        name = question["items"][question["current"]]["name"]
        return Given(question["action"], step, "B", name, value)


def refused_soon(given: Command) -> bool:
    known = given.text in {"general_discomfort", "fatigue"}
    return given.action != "answer" or not known or given.value not in {None, 0, 3}


def asked_aloud(tmp_path, *, first: Sequence[Command] = (), **more) -> Experimenter:
    desk = Experimenter(first=list(first), **more)
    operators = OperatorControl(desk)
    clock = iter(range(10**6))
    respondent = VerbalRespondent(desk, operators, now_s=lambda: float(next(clock)))
    desk.outcome = go(tmp_path, respondent, operators=operators)
    assert [str(each) for each in verify_study(tmp_path / "S").faults] == []
    return desk


def events(tmp_path, name: str) -> list[str]:
    return [row["detail"] for row in rows(tmp_path, "events") if row["name"] == name]


def test_a_whole_session_is_asked_aloud(tmp_path):
    desk = asked_aloud(tmp_path)
    assert desk.outcome.status == "enrolled"
    assert attempts(tmp_path) == [
        ("1", "1", "0", "completed", ""),
        ("2", "1", "0", "completed", ""),
    ]
    answers = rows(tmp_path, "questionnaires")
    assert [row["response"] for row in answers] == ["1"] * 64
    for row in answers:
        assert float(row["answered_s"]) - float(row["asked_s"]) == pytest.approx(1.0, abs=0.01)
    ratings = rows(tmp_path, "ratings")
    assert [row["response"] for row in ratings] == ["3"] * 4
    assert manifest(tmp_path)["respondent"] == "console"


def test_the_events_say_who_entered_what(tmp_path):
    asked_aloud(tmp_path)
    entered = events(tmp_path, "operator_answer")
    assert len(entered) == 64
    assert entered[0] == "B, step 1 (questionnaire ssq (baseline)): general_discomfort 1"
    assert events(tmp_path, "operator_rate")[0].startswith("B, step 3 (exposure 1 of 2, attempt 1")
    assert events(tmp_path, "operator_rate")[0].endswith(": fms 3")
    assert len(events(tmp_path, "operator_confirm")) == 4


def test_answers_may_be_refused_corrected_or_declined(tmp_path):
    first = [
        Given("answer", 0, "", "general_discomfort", 4),
        Given("answer", 0, "", "general_discomfort", 0.5),
        Given("answer", 0, "", "colour", 1),
        Given("confirm", 0, "", ""),
        Given("rate", 0, "", "general_discomfort", 1),
        Given("answer", 0, "", "general_discomfort", 3),
        Given("answer", 0, "", "fatigue", None),
        Given("answer", 0, "", "general_discomfort", 0),
    ]
    desk = asked_aloud(tmp_path, first=first)
    refused = [refusal for _, refusal in desk.replies if refusal]
    assert refused == [
        "0 to 3 is an answer to 'General discomfort'",
        "0 to 3 is an answer to 'General discomfort'",
        "this questionnaire has no question 'colour'",
        "16 questions are open; answer them first",
        "rate has no meaning in this step: questionnaire ssq (baseline)",
    ]
    baseline = rows(tmp_path, "questionnaires")[:16]
    assert [row["response"] for row in baseline[:3]] == ["0", "", "1"]
    assert [row["order"] for row in baseline] == [str(n) for n in range(1, 17)]
    said = events(tmp_path, "answer")
    assert said[:3] == [
        "baseline ssq general_discomfort: 3",
        "baseline ssq fatigue: rather not say",
        "baseline ssq general_discomfort: 0",
    ]


def test_a_rating_that_is_not_entered_in_time_is_missed_and_its_question_goes(tmp_path):
    class Silent(Experimenter):
        def ask(self, question: Any) -> None:
            self.questions.append(question)
            if question is None or question["action"] != "rate":
                self.question = question

    desk = Silent()
    operators = OperatorControl(desk)
    go(tmp_path, VerbalRespondent(desk, operators), operators=operators)
    assert [row["missed"] for row in rows(tmp_path, "ratings")] == ["1"] * 4
    pairs = pairwise(desk.questions)
    after = [then for asked, then in pairs if asked and asked["action"] == "rate"]
    assert after == [None] * 4


def test_nothing_can_be_entered_where_somebody_else_answers(tmp_path):
    desk = ScriptedDesk([Wanted("exposure", "rate", "fms", value=3)])
    go(tmp_path, operators=OperatorControl(desk))
    ((_, refusal),) = desk.replies
    assert refusal.startswith("nothing is asked that is answered on a console")


def test_the_participant_reads_that_they_are_asked_and_may_take_the_headset_off_in_a_rest():
    class Screen:
        def __init__(self) -> None:
            self.words: list[str | None] = []
            self.absent_s: list[float] = []

        def rest_on(self, words: str | None) -> None:
            self.words.append(words)

        def allow_absence(self, duration_s: float) -> None:
            self.absent_s.append(duration_s)

    desk, screen = Experimenter(), Screen()
    operators = OperatorControl(desk)
    respondent = VerbalRespondent(desk, operators, screen)
    assert respondent.resting(12.0)
    respondent.rest(12.0)
    assert screen.absent_s == [12.0]
    assert screen.words[-1] is None
    assert ENGLISH.listen not in screen.words
