"""The timeline of a session as data: its steps, and those that are left after an interruption."""

from __future__ import annotations

from pathlib import Path

from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.design import build_design
from vrcomfort.protocol.timeline import QuestionnaireStep, Resumption, SessionPlan, Step

EVERYTHING = PROTOCOL.replace(
    "[[conditions]]",
    '[breaks]\nmin_s = 5.0\n\n[posture]\nmode = "seated"\n\n[[instructions]]\nname = "try"\n'
    'when = "before_practice"\ntext = "Try it."\n\n[[practice]]\nname = "warm_up"\ndraw = 1\n\n'
    '[[free_texts]]\nname = "why"\nwhen = "session_end"\ntext = "What was it like?"\n\n'
    "[[conditions]]",
    1,
)


def steps_of(tmp_path: Path, resumption: Resumption | None = None) -> list[Step]:
    protocol = tiny_protocol(tmp_path, EVERYTHING)
    sequence = build_design(protocol).sequences[0]
    return list(SessionPlan(protocol, sequence, 1, protocol.longest_s, resumption).steps())


def names_of(steps: list[Step]) -> list[str]:
    return [type(step).__name__.removesuffix("Step") for step in steps]


def test_a_session_is_one_list_of_steps(tmp_path: Path) -> None:
    steps = steps_of(tmp_path)
    assert names_of(steps) == [
        "Questionnaire", "EyeHeight", "Instruction", "Practice", "Exposure", "Questionnaire",
        "Break", "EyeHeight", "Exposure", "Questionnaire",
        "Rest", "Questionnaire", "FreeText",
    ]  # fmt: skip
    assert [step.place.trial for step in steps if step.when == "after_trial"] == [1, 2]


def test_a_resumed_session_has_the_steps_that_are_left(tmp_path: Path) -> None:
    """The open questionnaire first; neither practice nor a break that are over."""
    steps = steps_of(tmp_path, Resumption(1, 1, begun={1, 2}, practised={"warm_up"}))
    assert names_of(steps) == [
        "Questionnaire", "Questionnaire", "EyeHeight", "Exposure", "Questionnaire",
        "Rest", "Questionnaire", "FreeText",
    ]  # fmt: skip
    owed = [step.owed for step in steps if isinstance(step, QuestionnaireStep)]
    assert owed == [True, False, False, False]
    steps = steps_of(tmp_path, Resumption(1, 1, begun={1}, practised={"warm_up"}))
    assert "Break" in names_of(steps)  # the exposure after it was not begun


def test_a_session_that_had_ended_has_its_open_questions_alone(tmp_path: Path) -> None:
    steps = steps_of(tmp_path, Resumption(0, 1, begun={1}, practised=set(), ended=True))
    assert names_of(steps) == ["Questionnaire"]
    done = steps_of(tmp_path, Resumption(2, 2, begun={1, 2}, practised={"warm_up"}))
    assert names_of(done) == ["Questionnaire", "Questionnaire", "FreeText"]
