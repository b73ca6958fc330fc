"""How much time a session will still take: as planned at first, then as its steps have taken."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from tests.support.operator import ScriptedDesk, Wanted
from tests.support.resume import go
from tests.support.study import PROTOCOL, Scripted, tiny_protocol
from vrcomfort.operator_interface import NoOperator
from vrcomfort.protocol.timeline import PlannedStep
from vrcomfort.session.operator_control import OperatorControl, SessionTime


@dataclass
class Clock:
    now_s: float = 100.0

    def __call__(self) -> float:
        return self.now_s


def asked_three_times() -> tuple[SessionTime, Clock]:
    clock = Clock()
    steps = [
        PlannedStep("questionnaire", "questionnaire", 60.0),
        PlannedStep("exposure", "exposure", 30.0),
        PlannedStep("questionnaire", "questionnaire", 60.0),
        PlannedStep("rest", "rest", 20.0),
        PlannedStep("exposure", "exposure", 30.0),
        PlannedStep("questionnaire", "questionnaire", 60.0),
    ]
    return SessionTime(steps, clock), clock


def test_at_first_it_is_what_was_planned_and_it_counts_down() -> None:
    time, clock = asked_three_times()
    assert time.remaining_s() == 260.0
    time.begin("ready", "ready of some kind")  # nobody knows how long it takes to come
    clock.now_s += 500.0
    assert time.remaining_s() == 260.0
    time.begin("questionnaire", "questionnaire of some kind")
    clock.now_s += 25.0
    assert time.remaining_s() == 235.0


def test_steps_of_a_kind_are_expected_to_take_what_those_before_have_taken() -> None:
    time, clock = asked_three_times()
    time.begin("questionnaire", "questionnaire of some kind")
    clock.now_s += 120.0  # twice as long
    assert time.remaining_s() == 200.0  # this one may end at any moment
    time.begin("exposure", "exposure of some kind")
    slower = (120 + 60) / (60 + 60)  # a minute of the plan is believed, too
    assert time.remaining_s() == pytest.approx(30 + 60 * slower + 20 + 30 + 60 * slower)
    clock.now_s += 30.0
    time.begin("questionnaire", "questionnaire of some kind")
    clock.now_s += 120.0
    time.begin("rest", "rest of some kind")
    slower = (240 + 60) / (120 + 60)
    assert time.remaining_s() == pytest.approx(20 + 30 + 60 * slower)


def test_of_a_step_that_says_how_far_it_has_come_the_rest_is_expected() -> None:
    """However long that took: a machine that draws too slowly shows an exposure for longer."""
    time, clock = asked_three_times()
    time.begin("questionnaire", "questionnaire of some kind")
    time.come(0.0)
    clock.now_s += 300.0
    time.come(0.25)
    assert time.remaining_s() == 45 + 200
    clock.now_s += 60.0
    assert time.remaining_s() == 45 + 200
    time.begin("exposure", "exposure of some kind")
    assert time.remaining_s() == pytest.approx(30 + 60 * 3.5 + 20 + 30 + 60 * 3.5)


def test_a_pause_is_not_counted() -> None:
    time, clock = asked_three_times()
    time.begin("questionnaire", "questionnaire of some kind")
    time.begin("exposure", "exposure of some kind")
    clock.now_s += 10.0
    before_s = time.remaining_s()
    time.pause()
    clock.now_s += 300.0
    assert time.remaining_s() == before_s
    time.end_pause()
    clock.now_s += 5.0
    assert time.remaining_s() == pytest.approx(before_s - 5.0)
    clock.now_s += 15.0
    expected_s = time.remaining_s()
    time.begin("questionnaire", "questionnaire of some kind")
    assert time.remaining_s() == pytest.approx(expected_s)  # it took 30 s, as planned


def test_what_is_redone_begins_again_and_what_is_cut_short_teaches_nothing() -> None:
    time, clock = asked_three_times()
    time.begin("questionnaire", "questionnaire of some kind")
    clock.now_s += 60.0
    time.begin("exposure", "exposure of some kind")
    clock.now_s += 20.0
    time.begin("exposure", "exposure of some kind", again=True, cut_short=True)
    assert time.remaining_s() == 30 + 60 + 20 + 30 + 60
    clock.now_s += 1.0
    time.begin("questionnaire", "questionnaire of some kind", cut_short=True)  # skipped
    assert time.remaining_s() == 60 + 20 + 30 + 60


def test_a_step_that_nobody_planned_takes_none_of_those_planned() -> None:
    time, clock = asked_three_times()
    time.begin("questionnaire", "questionnaire of some kind")
    clock.now_s += 60.0
    time.begin("questionnaire", "screening")  # which has its time only where somebody is asked
    clock.now_s += 60.0
    time.begin("training", "training of some kind")  # once more
    clock.now_s += 60.0
    assert time.remaining_s() == 200.0
    time.begin("rest", "rest of some kind")  # the one that is planned comes after the exposure
    assert time.remaining_s() == 200.0
    time.begin("exposure", "exposure of some kind")
    assert time.remaining_s() == 200.0


@dataclass
class Watching(ScriptedDesk):
    """An operator who looks at the time that is left whenever a step begins."""

    left_s: list[tuple[str, float]] = field(default_factory=list)

    def begin(self, step: Any) -> None:
        super().begin(step)
        assert self.order is not None
        self.left_s.append((step.kind, self.order.remaining_s()))


def watched(tmp_path: Path, text: str = PROTOCOL, **more: Any) -> Watching:
    desk = Watching(script=more.pop("script", ()))
    protocol = tiny_protocol(tmp_path, text)
    go(tmp_path, Scripted(), protocol=protocol, operators=OperatorControl(desk), **more)
    return desk


def test_a_session_is_estimated_by_its_plan_and_ever_better(tmp_path: Path) -> None:
    """Each item is planned with 4 s, and answered in 2 s."""
    desk = watched(tmp_path)
    kinds = [kind for kind, _ in desk.left_s]
    assert kinds == [
        "questionnaire", "training", "exposure", "questionnaire", "exposure", "questionnaire",
        "rest", "questionnaire",
    ]  # fmt: skip
    assert desk.left_s[0][1] == 4 * 64 + 1 + 2 * 10 + 60
    true_s = [4 * 32 + 81.0, 3 * 32 + 81, 3 * 32 + 80, 3 * 32 + 70, 2 * 32 + 70, 2 * 32 + 60]
    true_s += [32.0 + 60, 32.0]
    too_much = [left / true - 1 for (_, left), true in zip(desk.left_s, true_s, strict=True)]
    assert too_much[0] > 0.6
    assert 0 < too_much[-2] < 0.15


def test_everything_that_takes_time_is_planned(tmp_path: Path) -> None:
    """Breaks, practice, a validation of the gaze, instructions and free texts are steps, too."""
    text = PROTOCOL.replace("exposure_s = 10.0", "exposure_s = 10.0\nbreak_s = 7.0").replace(
        "[[conditions]]",
        "[gaze_validation]\npoints = [[0.0, 0.0, 1.0], [9.0, 0.0, 1.0]]\n\n[[instructions]]\n"
        'name = "hello"\nwhen = "session_start"\ntext = "Look around and say how you feel."\n\n'
        '[[practice]]\nname = "try"\ntrials = [{ scene = "room.glb", condition = "plain" }]\n'
        'exposure_s = 4.0\n\n[[free_texts]]\nname = "why"\nwhen = "session_end"\n'
        'text = "What was it like?"\n\n[[conditions]]',
        1,
    )
    desk = watched(tmp_path, text)
    protocol = tiny_protocol(tmp_path, text)
    assert protocol.gaze_validation is not None
    gaze_s = 2 * 2 * protocol.gaze_validation.each_s  # two points, and again after the break
    planned_s = 7 / 3 + 4 * 64 + gaze_s + 4 + 1 + 2 * 10 + 7 + 60 + 30
    first = next(left for kind, left in desk.left_s if kind == "instruction")
    assert first == pytest.approx(planned_s)


def test_a_session_that_goes_on_has_what_is_left(tmp_path: Path) -> None:
    go(tmp_path, interrupt=(2, 30))
    desk = watched(tmp_path, resume=True)
    baseline_s, exposure_s = (desk.left_s[index][1] for index in (0, 1))
    assert [kind for kind, _ in desk.left_s] == [
        "questionnaire", "exposure", "questionnaire", "rest", "questionnaire",
    ]  # fmt: skip
    assert baseline_s == 64 + 10 + 64 + 60 + 64
    assert exposure_s < baseline_s - 64


def test_an_exposure_that_is_redone_is_expected_again(tmp_path: Path) -> None:
    desk = watched(tmp_path, script=[Wanted("exposure", "redo", after=40)])
    first, again = [left for kind, left in desk.left_s if kind == "exposure"][:2]
    assert again == pytest.approx(first)


def test_a_step_says_how_much_of_it_is_done(tmp_path: Path) -> None:
    heard = []

    class Noting(OperatorControl):
        def come(self, done: float, total: float) -> None:
            heard.append((done, total))
            super().come(done, total)

    go(tmp_path, operators=Noting(NoOperator()), exposure_s=1.0)
    timed = [(done, total) for done, total in heard if total > 0]
    assert len({done for done, _ in timed}) > 2
    assert all(0 <= done <= total for done, total in timed)
