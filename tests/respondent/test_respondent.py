from __future__ import annotations

import io
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose
from vrcomfort.protocol import Simulation, load_protocol
from vrcomfort.questionnaire import score, shipped_instruments
from vrcomfort.respondent import (
    Exposure,
    Form,
    SimulatedRespondent,
    TerminalRespondent,
    Withdrew,
)
from vrcomfort.respondent.keyboard import SURE
from vrcomfort.tasks import Demand

FMS = shipped_instruments()["fms"]
SSQ = shipped_instruments()["ssq"]

POST = Form(SSQ, "post")


def expose(
    person: SimulatedRespondent, condition: str = "a", minutes: float = 15, step_s: float = 5
) -> float:
    """Expose somebody until they withdraw; return the seconds they stayed."""
    seconds = minutes * 60
    person.start_exposure(Exposure(1, 1, "room", condition, seconds))
    for elapsed_s in np.arange(0, seconds, step_s):
        try:
            person.update(elapsed_s)
        except Withdrew:
            seconds = elapsed_s
            break
    person.end_exposure(seconds)
    return seconds


def answers(person: SimulatedRespondent) -> dict[str, int | None]:
    heard: dict[str, int | None] = {}
    person.ask(POST, lambda item, response, _: heard.__setitem__(item, response))
    return heard


def somebody(seed: int = 1, name: str = "P01", **settings) -> SimulatedRespondent:
    calm = {"hazard_per_min": 0.0, "question_hazard": 0.0}
    return SimulatedRespondent(Simulation(**calm | settings), participant=name, seed=seed)


def reaction_s(person: SimulatedRespondent, condition: str, trial: int = 1) -> float:
    demand = Demand(np.array([0.0, 0.0, -2.0]), 0.0, press=True)
    person.start_task(trial, condition)
    person.act(demand, Pose(), 0.0)
    return person.next_press_s(demand)


def test_people_differ_in_how_a_condition_affects_them_in_tasks():
    settings = {"reaction_sigma": 0.0, "reaction_s": 1.0, "task_effect_sigma": 0.2}
    people = [somebody(name=f"P{n}", **settings, task_effects={"b": 1.5}) for n in range(300)]
    logs = np.log([[reaction_s(each, name) for name in ("a", "b")] for each in people])
    assert logs.std(axis=0) == pytest.approx([0.2, 0.2], rel=0.15)
    assert logs.mean(axis=0) == pytest.approx([0.0, math.log(1.5)], abs=0.04)
    assert abs(np.corrcoef(logs.T)[0, 1]) < 0.2  # each condition by itself
    assert reaction_s(people[0], "a", trial=7) == reaction_s(people[0], "a")
    alike = [somebody(name=f"P{n}", **settings | {"task_effect_sigma": 0.0}) for n in range(2)]
    assert [reaction_s(each, "a") for each in alike] == [1.0, 1.0]


def test_the_same_person_answers_the_same_and_others_do_not():
    first, again, other = somebody(), somebody(), somebody(name="P02")
    assert first.susceptibility == again.susceptibility != other.susceptibility
    assert answers(first) == answers(again)
    first.start_session(2)
    again.start_session(2)
    assert answers(first) == answers(again)


@given(st.integers(0, 2**32), st.floats(0, 60), st.floats(0.1, 3))
@settings(max_examples=40)
def test_answers_stay_on_their_scales(seed, minutes, rate):
    person = somebody(seed, rate_per_min=rate)
    expose(person, minutes=minutes)
    found = answers(person)
    assert list(found) == [item.name for item in SSQ.items]
    assert all(response in {0, 1, 2, 3} for response in found.values())
    person.start_exposure(Exposure(1, 2, "room", "a", 60))
    person.prompt(FMS, 1.0, 10.0)
    rating = person.rating(20.0)
    assert rating is None or 0 <= rating <= 20


def test_a_rating_takes_a_tenth_of_its_time_at_least():
    person = somebody(missed_rating=0.0)
    person.start_exposure(Exposure(1, 1, "room", "a", 60))
    person.prompt(FMS, 10.0, 10.0)
    assert person.rating(10.9) is None
    assert person.rating(16.1) is not None


def test_sickness_follows_its_differential_equation():
    person = somebody(rate_per_min=0.1, recovery_min=20.0)
    expose(person, minutes=15)
    dose = 0.1 * person.susceptibility
    steps, sickness = 100_000, 0.0
    for _ in range(steps):
        sickness += (dose - sickness / 20.0) * 15 / steps
    assert person.sickness == pytest.approx(sickness, rel=1e-4)
    before = person.sickness
    person.rest(20 * 60)
    assert person.sickness == pytest.approx(before / math.e)


def test_conditions_scenes_and_habituation_scale_the_growth():
    settings = {"condition_effects": {"b": 0.5}, "scene_effects": {"room": 2.0}, "habituation": 0.8}
    plain, milder, later = (somebody(**settings) for _ in range(3))
    later.start_session(2)
    for person, condition in ((plain, "a"), (milder, "b"), (later, "a")):
        expose(person, condition)
    assert milder.sickness == pytest.approx(plain.sickness / 2)
    assert later.sickness == pytest.approx(plain.sickness * 0.8)


def test_a_higher_hazard_makes_people_withdraw_earlier():
    stays = [
        np.mean([expose(somebody(n, hazard_per_min=h, tolerance=0.0)) for n in range(40)])
        for h in (0.0, 0.2, 2.0)
    ]
    assert stays[0] == 900
    assert stays[0] > stays[1] > stays[2]


def test_withdrawal_does_not_depend_on_the_frame_rate():
    stays = [
        expose(somebody(3, hazard_per_min=2.0, tolerance=0.0), step_s=step_s)
        for step_s in (0.011, 0.5)
    ]
    assert stays[0] < 900
    assert stays[0] == pytest.approx(stays[1], abs=0.5)


def _study(seed: int, people: int) -> tuple[dict[str, list[float]], int]:
    protocol = load_protocol("carnegie_2015")
    settings = protocol.simulation.model_copy(update={"question_hazard": 0.0})
    deltas: dict[str, list[float]] = {"dof_on": [], "dof_off": []}
    withdrawals = 0
    for number, sequence in enumerate(build_design(protocol, seed=seed).plan(people)):
        person = SimulatedRespondent(settings, participant=f"P{number}", seed=seed)
        before = score(SSQ, answers(person))["T"]
        for trial in sequence.sessions[0]:
            stayed_s = expose(person, trial.condition)
            after = score(SSQ, answers(person))["T"]
            if stayed_s < 900:
                withdrawals += 1
                break
            assert before is not None
            assert after is not None
            deltas[trial.condition].append(after.points - before.points)
    return deltas, withdrawals


def test_in_carnegie_2015_blur_is_milder_and_some_withdraw():
    deltas, withdrawals = _study(seed=1, people=200)
    assert np.mean(deltas["dof_on"]) < np.mean(deltas["dof_off"])
    assert 0.1 < withdrawals / 200 < 0.4


def test_somebody_who_withdrew_may_refuse():
    with pytest.raises(Withdrew, match="refused"):
        somebody(refusal=1.0).ask(Form(SSQ, "post", after_withdrawal=True), lambda *_: None)


class Typist:
    """Types lines one after the other; answers 0 when they have run out."""

    def __init__(self, *lines: str) -> None:
        self.lines = list(lines)

    def __call__(self, prompt: str) -> str:
        if self.lines:
            return self.lines.pop(0)
        return "" if "Enter" in prompt else "0"


def terminal(read_line, waiting_line=lambda: None) -> tuple[TerminalRespondent, io.StringIO]:
    shown = io.StringIO()
    console = Console(file=shown, width=100)
    clock = iter(range(1000))
    return TerminalRespondent(
        console, read_line=read_line, waiting_line=waiting_line, now_s=lambda: float(next(clock))
    ), shown


def typed(*lines: str) -> tuple[list[tuple[str, int | None]], str]:
    person, shown = terminal(Typist(*lines))
    heard: list[tuple[str, int | None]] = []
    person.ask(POST, lambda item, response, _: heard.append((item, response)))
    return heard, shown.getvalue()


def test_typed_answers_are_heard_in_order():
    heard, shown = typed("3", "-")
    assert heard[:3] == [("general_discomfort", 3), ("fatigue", None), ("headache", 0)]
    assert len(heard) == 16
    assert "0 none, 1 slight, 2 moderate, 3 severe" in shown


def test_wrong_keys_are_explained_and_asked_again():
    heard, shown = typed("4", "x", "²", "1")
    assert heard[0] == ("general_discomfort", 1)
    assert shown.count("0 to 3;") == 3


def test_back_asks_the_question_before_again():
    heard, _ = typed("1", "2", "b", "3")
    assert heard[:4] == [
        ("general_discomfort", 1),
        ("fatigue", 2),
        ("fatigue", 3),
        ("headache", 0),
    ]


def test_answers_can_be_corrected_at_the_end():
    heard, _ = typed(*["0"] * 16, "8", "2", "")
    assert heard[-1] == ("nausea", 2)


def test_a_person_may_withdraw_at_a_question():
    with pytest.raises(Withdrew):
        typed("1", "q", "y")


def test_a_wish_to_withdraw_is_asked_once_more():
    heard, _ = typed("1", "q", "n", "q", "q", "2")
    assert heard[:2] == [("general_discomfort", 1), ("fatigue", 2)]


def test_the_end_of_input_is_told():
    def closed(prompt: str) -> str:
        raise EOFError

    person, _ = terminal(closed)
    with pytest.raises(InputError, match="input ended"):
        person.ask(POST, lambda *_: None)


def test_ratings_and_withdrawals_are_typed_during_exposure():
    lines = iter([None, "7", None, "21", "q", "q", "n", "q", "y"])
    person, shown = terminal(Typist(), lambda: next(lines))
    person.start_exposure(Exposure(1, 1, "room", "secret_condition", 60))
    person.prompt(FMS, 0.0, 10.0)
    person.update(0.1)
    assert person.rating(0.1) is None
    person.update(0.2)
    assert person.rating(0.2) == 7
    person.prompt(FMS, 30.0, 10.0)
    person.update(30.1)
    person.update(30.2)
    assert person.rating(30.2) is None
    for _ in range(4):
        person.update(30.3)
    assert shown.getvalue().splitlines()[-4:] == [SURE, SURE, "The session continues.", SURE]
    with pytest.raises(Withdrew):
        person.update(30.4)


def test_what_is_typed_too_late_or_for_nothing_is_said_to_be_lost():
    lines = iter(["4", "5", "30", "6", "7", "8"])
    person, shown = terminal(Typist(), lambda: next(lines))
    person.start_exposure(Exposure(1, 1, "room", "none", 60))
    person.update(1.0)
    person.prompt(FMS, 10.0, 5.0)
    person.update(15.1)
    assert person.rating(15.1) is None
    person.prompt(FMS, 20.0, 5.0)
    for elapsed_s in (21.0, 22.0):
        person.update(elapsed_s)
    assert person.rating(22.0) == 6
    person.prompt(FMS, 30.0, 5.0)
    for elapsed_s in (31.0, 32.0):
        person.update(elapsed_s)
    assert person.rating(32.0) == 7
    told = [line for line in shown.getvalue().splitlines() if line.startswith("'")]
    assert told == [
        "'4' was not recorded: nothing was asked",
        "'5' came too late and was not recorded",
        "'30' was not recorded: 0 to 20 is a rating",
        "'8' was not recorded: 7 was given before",
    ]


def test_a_wish_to_stop_that_the_exposure_overtook_is_asked_at_the_next_question():
    lines = iter(["q", None])
    person, _ = terminal(Typist("y"), lambda: next(lines))
    person.update(59.9)
    person.end_exposure(60.0)
    with pytest.raises(Withdrew):
        person.ask(POST, lambda *_: None)


def test_a_rating_typed_too_late_answers_no_question():
    lines = iter(["5", None, "6"])
    person, shown = terminal(Typist("3"), lambda: next(lines))
    person.end_exposure(60.0)
    heard: list[int | None] = []
    person.ask(POST, lambda _item, response, _took: heard.append(response))
    assert heard[0] == 3
    assert "'5' came too late" in shown.getvalue()
    person.ask(POST, lambda *_: None)
    assert next(lines) == "6", "what is typed between two questionnaires is the next one's"


def test_a_person_may_withdraw_in_a_rest():
    person, _ = terminal(Typist(), iter(["q", None, "y"]).__next__)
    person.resting(900.5)
    with pytest.raises(Withdrew, match="between exposures"):
        person.resting(900.0)


def test_the_terminal_does_not_name_the_condition():
    person, shown = terminal(Typist())
    person.start_exposure(Exposure(1, 1, "room", "secret_condition", 60))
    assert "secret_condition" not in shown.getvalue()
