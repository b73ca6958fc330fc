"""Screening: who is told of, who decides, what is kept of it, and how reports count it."""

from __future__ import annotations

import json
import re

import pytest

from tests.console.test_verbal import Experimenter
from tests.respondent.test_respondent import Typist, terminal
from tests.session.test_panel import ScriptedScreen
from tests.support.exchange import cell
from tests.support.operator import Given
from tests.support.protocols import ASKED_AFTER_EACH, ASKED_BEFORE, NOBODY_LEAVES, protocol_text
from tests.support.report import build_report
from tests.support.study import AheadHeadset, Scripted, read_rows
from tests.support.tasks import doing_protocol, in_the_room
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol.questions import Screening
from vrcomfort.records import read_participants, undo_withdrawal
from vrcomfort.respondent import SimulatedRespondent, keyboard
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.session import NoPictures, SessionSettings, StillHeadset, open_enrolment
from vrcomfort.session import run as run_enrolment
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.verbal import VerbalRespondent

PROTOCOL = protocol_text(
    """\
[[covariates]]
name = "age"

[[covariates]]
name = "gender"
levels = ["f", "m", "d"]
""",
    ASKED_BEFORE,
    ASKED_AFTER_EACH,
    """\
[[screening]]
instrument = "ssq"
above = 30.0

[[screening]]
covariate = "age"
below = 18
above = 65
""",
    NOBODY_LEAVES,
    name="screening",
)
CALM = PROTOCOL.replace("above = 30.0", "above = 300.0")


class Decider(Scripted):
    """Answers 1 everywhere (an SSQ total of 78.54), and decides as told."""

    def __init__(self, *decisions, **more):
        super().__init__(**more)
        self.decisions, self.questions = list(decisions), []

    def decide(self, question):
        self.questions.append(question)
        return self.decisions.pop(0)


def screen(folder, respondent=None, text=PROTOCOL, *, who="P01", age="30", resume=False, **more):
    protocol = doing_protocol(folder, text)
    person = respondent or SimulatedRespondent(protocol.simulation, participant=who, seed=0)
    parts = {**in_the_room(), **more}
    with open_enrolment(
        protocol, who, study=folder / "S", respondent=person.name, resume=resume,
        covariates=None if resume else {"age": age, "gender": "d"},
    ) as enrolment:  # fmt: skip
        return run_enrolment(enrolment, SessionSettings(respondent=person, **parts))


def decisions(folder, who="P01"):
    rows = read_rows(folder / f"S/sub-{who}/ses-1/screening.csv")
    return [(row["rule"], float(row["value"]), row["decision"]) for row in rows]


def test_the_experimenter_is_told_the_number_and_goes_on(tmp_path):
    """And `verify` and copies for others know what was decided."""
    person = Decider(True)
    assert screen(tmp_path, person).status == "completed"
    (question,) = person.questions
    assert re.search(r"SSQ T is 78\.54, above 30\. Go on", question)
    assert decisions(tmp_path) == [("SSQ T above 30", 78.54, "go_on")]
    assert not verify_study(tmp_path / "S").faults
    anonymise(tmp_path / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    assert not verify_study(tmp_path / "shared").faults
    (file,) = (tmp_path / "shared").rglob("screening.csv")
    assert read_rows(file)[0]["participant"] == file.parents[1].name.removeprefix("sub-")
    file = tmp_path / "S/sub-P01/ses-1/screening.csv"
    (file.parent / "checksums.sha256").unlink()
    cell(file, 2, "decision", "perhaps")
    (told,) = (str(each) for each in verify_study(tmp_path / "S").faults)
    assert "'perhaps'" in told


def test_who_is_screened_out_is_exposed_to_nothing(tmp_path):
    outcome = screen(tmp_path, Decider(False))
    assert outcome.status == "withdrawn"
    assert "screened out: SSQ T above 30 (78.54)" in outcome.note
    assert read_rows(tmp_path / "S/sub-P01/ses-1/trials.csv") == []
    assert decisions(tmp_path) == [("SSQ T above 30", 78.54, "stop")]
    assert not verify_study(tmp_path / "S").faults
    with pytest.raises(InputError, match="P01 is withdrawn"):
        screen(tmp_path, Decider(True))
    undo_withdrawal(tmp_path / "S", "P01", "the score was mistyped")
    again = Decider(True)
    assert screen(tmp_path, again, resume=True).status == "completed"
    assert len(again.questions) == 1  # after a new baseline


def test_who_is_screened_out_has_not_withdrawn_in_the_report(tmp_path):
    for who, goes_on in (("P01", False), ("P02", True)):
        screen(tmp_path, Decider(goes_on), who=who)
    summary = build_report(tmp_path / "S", out=tmp_path / "r")
    assert summary.withdrawn == 0
    results = json.loads(summary.results.read_text("utf-8"))
    (enrolled, *_) = results["flow"]
    assert enrolled["left"] == [{"reason": "screened out by the experimenter", "n": 1}]


def test_a_rule_may_end_the_session_alone(tmp_path):
    text = PROTOCOL.replace("above = 30.0", 'above = 30.0\nends = "session"')
    assert screen(tmp_path, Decider(False), text).status == "completed"  # there is but one session
    (row,) = read_participants(tmp_path / "S")
    assert "screened out" in row.note


@pytest.mark.parametrize(("age", "rule"), [("17", "age below 18"), ("66.5", "age above 65")])
def test_covariates_are_looked_at_before_any_question(tmp_path, age, rule):
    screen(tmp_path, Decider(False), age=age)
    assert decisions(tmp_path) == [(rule, float(age), "stop")]
    assert read_rows(tmp_path / "S/sub-P01/ses-1/questionnaires.csv") == []


def test_bounds_themselves_are_within(tmp_path):
    assert screen(tmp_path, Decider(), CALM, age="65").status == "completed"
    assert not (tmp_path / "S/sub-P01/ses-1/screening.csv").exists()


def test_a_covariate_is_decided_upon_once(tmp_path):
    class Breaks(AheadHeadset):
        def frames(self):
            yield from ()
            raise KeyboardInterrupt

    first = Decider(True)
    assert screen(tmp_path, first, CALM, age="17", headset_for=lambda *_: Breaks()).status == (
        "aborted"
    )
    again = Decider()
    assert screen(tmp_path, again, CALM, resume=True).status == "completed"
    assert decisions(tmp_path) == [("age below 18", 17.0, "go_on")]


def test_simulated_experimenters_decide_by_the_seed_and_change_no_answer(tmp_path):
    text = PROTOCOL.replace("above = 30.0", "above = 0.0").replace(
        "[simulation]", "[simulation]\nbaseline_sd = 2.0"
    )
    found = {}
    for number in range(5):
        who = f"P{number}"
        screen(
            tmp_path, text=text, who=who, headset_for=lambda *_: StillHeadset(),
            renderer=NoPictures(), load_scene=lambda _: None, jumps=True,
        )  # fmt: skip
        file = tmp_path / f"S/sub-{who}/ses-1/screening.csv"
        found[who] = decisions(tmp_path, who)[0][2] if file.exists() else None
    assert set(found.values()) >= {"go_on", "stop"}
    status = {row.participant: row.status for row in read_participants(tmp_path / "S")}
    assert {who for who, said in found.items() if said == "stop"} == {
        who for who, state in status.items() if state == "withdrawn"
    }
    asked = "S/sub-P0/ses-1/questionnaires.csv"
    screen(tmp_path / "other", text=text.replace("above = 0.0", "above = 900.0"), who="P0")
    first, other = (
        [row["response"] for row in read_rows(folder / asked) if row["timepoint"] == "baseline"]
        for folder in (tmp_path, tmp_path / "other")
    )
    assert first == other


def test_the_terminal_asks_until_it_is_decided():
    person, shown = terminal(Typist("perhaps", keyboard.NO))
    assert person.decide("SSQ T is 60, above 30. Go on?") is False
    assert "SSQ" not in shown.getvalue()  # it stands in the prompt
    assert terminal(Typist(keyboard.YES))[0].decide("Go on?") is True


def test_the_panel_lets_the_participant_wait():
    screen_, asked = ScriptedScreen([]), []
    lines = iter([None, "hm\n", f"{keyboard.NO}\n"])
    person = PanelRespondent(screen_, waiting_line=lambda: next(lines), prompt=asked.append)
    assert person.decide("SSQ T is 60, above 30. Go on?") is False
    assert screen_.frames == 3
    assert "SSQ T is 60" in asked[0]


def test_the_console_has_two_buttons():
    desk = Experimenter()
    operators = OperatorControl(desk)
    operators.begin("questionnaire", "screening")
    step = desk.steps[-1].number
    given = [Given("answer", step, "B", "text", 1), Given("decide", step, "B", "text", 0)]
    commands = iter(given)
    desk.next_command = lambda: next(commands, None)
    assert VerbalRespondent(desk, operators).decide("Go on?") is False
    assert desk.replies[-1][1] == ""
    assert "go on (1) or stop (0)" in desk.replies[0][1]
    assert desk.questions[0]["items"][0]["labels"] == ["continue", "stop"]


@pytest.mark.slow
def test_the_report_counts_them(tmp_path):
    for who, decision in (("P01", False), ("P02", True), ("P03", True)):
        screen(tmp_path, Decider(decision), who=who)
    build_report(tmp_path / "S", out=tmp_path / "report")
    results = json.loads((tmp_path / "report/results.json").read_text(encoding="utf-8"))
    assert results["flow"][0] == {
        "stage": "Enrolled",
        "n": 3,
        "left": [{"reason": "screened out by the experimenter", "n": 1}],
    }
    told = "SSQ T above 30 in 3 participants; the experimenter stopped 1 and went on with 2"
    assert f"screening: {told}" in results["notices"]


def test_a_bound_is_the_last_number_within():
    rule = Screening(covariate="age", above=65, below=18)
    assert [rule.broken(each) for each in (17.99, 18, 65, 65.01)] == [
        "below 18", None, None, "above 65",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("above = 30.0", "", "needs a bound; give `above` or `below`"),
        ("above = 30.0", "above = 30.0\nbelow = 40.0", "swap `above` and `below`"),
        ('instrument = "ssq"', 'instrument = "ssq"\ncovariate = "age"', "one of the two"),
        ('instrument = "ssq"\nabove', 'instrument = "vrsq"\nabove', "not asked at session_start"),
        ('instrument = "ssq"', 'instrument = "ssq"\nscale = "X"', "has no scale `X`"),
        ('covariate = "age"', 'covariate = "aged"', "did you mean `age`"),
        ('covariate = "age"', 'covariate = "gender"', "and no number"),
    ],
)
def test_what_cannot_be_screened_by_is_refused(tmp_path, old, new, says):
    with pytest.raises(InputError) as refused:
        doing_protocol(tmp_path, PROTOCOL.replace(old, new))
    assert says in str(refused.value)
    assert refused.value.line is not None
