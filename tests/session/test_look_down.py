"""A wish to stop by looks alone: a look far down in an exposure, and two looks at the answer."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.headset.openxr.test_looks import Looker
from tests.session.test_panel import TwoHands, aim_at
from tests.support.openxr import fresh_monado, needs_monado
from vrcomfort.cli.headset_setup import look_down_of
from vrcomfort.geometry import Gaze, Pose, normalize, turn_to, yaw_pitch_roll
from vrcomfort.headset.inputs import HandInput, Inputs, SeenGaze
from vrcomfort.protocol import load_protocol
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.respondent.base import Exposure, Withdrew
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_input import AWAY_S, LookDown
from vrcomfort.respondent.panel_layout import Act
from vrcomfort.respondent.panel_picture import stop_page
from vrcomfort.session.panel_screen import PanelScreen

FRAME_S = 0.05
DOWN = (-89.0, 0.0)


def looks(*parts: tuple[float | None, float]) -> list[float]:
    """Return when a look asks to stop, of (degrees below the horizon, seconds) one by one."""
    look, asked, now_s = LookDown(60.0, 2.0), [], 0.0
    for down_deg, seconds in parts:
        for _ in range(round(seconds / FRAME_S)):
            if look.update(down_deg, now_s):
                asked.append(round(now_s, 2))
            now_s += FRAME_S
    return asked


def test_a_look_down_that_rests_asks_once() -> None:
    assert looks((0.0, 1.0), (70.0, 10.0)) == pytest.approx([3.0], abs=0.06)
    assert looks((70.0, 5.0), (0.0, 1.0), (60.0, 5.0)) == pytest.approx([2.0, 8.0], abs=0.06)


@pytest.mark.parametrize("down_deg", [0.0, 45.0, 59.9, -80.0, None])
def test_a_look_that_is_less_steep_never_asks(down_deg: float | None) -> None:
    assert looks((down_deg, 60.0)) == []


def test_glances_at_ones_feet_do_not_ask() -> None:
    assert looks(*[(80.0, 1.8), (10.0, AWAY_S + 2 * FRAME_S)] * 20) == []


def test_a_blink_is_no_look_away() -> None:
    (asked_s,) = looks((80.0, 1.0), (None, AWAY_S - 2 * FRAME_S), (80.0, 3.0))
    assert asked_s == pytest.approx(2.0, abs=0.06)


class Moving(TwoHands):
    """A head that looks where it is told, with nothing in its hands."""

    def look(self, pitch_deg: float, yaw_deg: float = 0.0) -> None:
        turn = yaw_pitch_roll(np.radians(yaw_deg), np.radians(pitch_deg), 0.0)
        self.head_pose = Pose(np.array([0.0, 1.6, 0.0]), turn)

    def look_at(self, point: tuple[float, float]) -> None:
        width, height = self.quad.size_m
        right, down = (point[0] - 0.5) * width, (0.5 - point[1]) * height
        place = (self.quad.pose @ Pose(np.array([right, down, 0.0]))).position
        eyes = np.array([0.0, 1.6, 0.0])
        self.head_pose = Pose(eyes, turn_to(normalize(place - eyes)))

    def show_pointer(self, quad: object) -> None:
        """Show nothing."""

    def hide(self) -> None:
        """Show nothing."""

    def tick(self, hand: int) -> None:
        """Tick nowhere."""


class Person:
    """Somebody in an exposure, frame by frame."""

    def __init__(self, look_down: LookDown | None, *, points_with_head: bool = True) -> None:
        self.headset, self.now_s = Moving(), 0.0
        screen = PanelScreen(self.headset, points_with_head=points_with_head)
        self.panel = PanelRespondent(
            screen, now_s=lambda: self.now_s, look_down=look_down, dwell_s=0.5
        )
        self.screen = screen
        self.panel.start_exposure(Exposure(1, 1, "room", "plain", 60.0))

    def update(self, seconds: float) -> None:
        for _ in range(round(seconds / FRAME_S)):
            self.now_s += FRAME_S
            self.panel.update(self.now_s)

    def choose(self, act: Act) -> None:
        """Look at an answer, away, and at it again."""
        cell = next(each for each in stop_page().cells if each.act is act)
        for _ in range(2):
            self.headset.look(0.0, 60.0)
            self.update(0.5)
            self.headset.look_at(cell.center)
            self.update(1.2)


def test_whoever_looks_down_and_chooses_to_stop_by_looks_has_withdrawn() -> None:
    person = Person(LookDown())
    person.headset.look(*DOWN)
    person.update(2.5)
    assert person.screen.quad is not None  # the question stands before them
    ahead = person.screen.quad.pose.position
    assert ahead[1] == pytest.approx(1.5)  # at the height of their eyes, not on the floor
    with pytest.raises(Withdrew, match="during exposure"):
        person.choose(Act.WITHDRAW)


def test_whoever_did_not_mean_it_goes_on() -> None:
    person = Person(LookDown())
    person.headset.look(*DOWN)
    person.update(2.5)
    person.choose(Act.BACK)
    assert person.screen.quad is None
    person.headset.look(0.0)
    person.update(5.0)
    assert person.screen.quad is None


def test_looking_down_alone_never_ends_anything() -> None:
    person = Person(LookDown())
    person.headset.look(*DOWN)
    person.update(20.0)  # no exception: the question stands, and is not answered


def test_a_protocol_may_do_without() -> None:
    person = Person(None)
    person.headset.look(*DOWN)
    person.update(10.0)
    assert person.screen.quad is None


def test_a_controller_in_hand_takes_no_look_down_away_and_answers() -> None:
    person = Person(LookDown())
    person.headset.now = Inputs(right=HandInput(Pose()))
    person.headset.look(*DOWN)
    person.update(2.5)
    assert person.screen.quad is not None
    stop = next(each for each in stop_page().cells if each.act is Act.WITHDRAW)
    aim = aim_at(person.screen.quad, stop.center)
    person.headset.now = Inputs(right=HandInput(aim, select=True))
    with pytest.raises(Withdrew):
        person.update(FRAME_S)


@pytest.mark.parametrize("points_with_head", [False, True])
def test_looks_answer_what_a_look_has_asked_though_a_controller_lies_beside(
    points_with_head: bool,
) -> None:
    person = Person(LookDown(), points_with_head=points_with_head)
    behind = Pose(np.array([0.0, 0.8, 0.0]), yaw_pitch_roll(np.pi, 0.0, 0.0))
    person.headset.now = Inputs(left=HandInput(behind))
    person.headset.look(*DOWN)
    person.update(2.5)
    with pytest.raises(Withdrew):
        person.choose(Act.WITHDRAW)


def test_looks_do_not_answer_what_a_button_has_asked() -> None:
    person = Person(LookDown())
    person.headset.now = Inputs(left=HandInput(Pose(), stop=True))
    person.update(FRAME_S)
    person.headset.now = Inputs(left=HandInput(Pose()))
    person.choose(Act.WITHDRAW)
    assert person.screen.quad is not None


def test_the_eyes_count_where_they_are_seen() -> None:
    person = Person(LookDown())
    down = Pose(orientation=yaw_pitch_roll(0.0, np.radians(-70.0), 0.0))
    for gaze, stands in ((Gaze(Pose(), True), False), (Gaze(down, True), True)):
        person.headset.now = Inputs(gaze=SeenGaze(gaze.pose, gaze.valid))
        person.headset.look(*DOWN)  # the head looks down in both
        person.update(3.0)
        assert (person.screen.quad is not None) is stands


def test_a_rating_gives_way_to_the_wish_to_stop() -> None:
    person = Person(LookDown())
    person.panel.prompt(shipped_instruments()["fms"], 0.0, 60.0)
    person.headset.look(*DOWN)
    person.update(3.0)
    with pytest.raises(Withdrew):
        person.choose(Act.WITHDRAW)


def test_the_protocol_says_how_far_and_how_long_and_whether() -> None:
    answering = load_protocol("smoke").answering
    found = look_down_of(answering.model_copy(update={"stop_down_s": 4.0, "stop_down_deg": 30.0}))
    assert [found.update(31.0, now_s) for now_s in (0.0, 3.9, 4.0)] == [False, False, True]
    assert look_down_of(answering.model_copy(update={"stop_by_looks": False})) is None


class Leaver(Looker):
    """Looks down, then away and at "Yes, stop now" in turn."""

    def watch(self, page: object) -> None:
        del page

    def _turn(self) -> np.ndarray:
        if self.screen is None or self.screen.quad is None:
            return yaw_pitch_roll(0.0, np.radians(-80.0), 0.0)
        self._cell = next(each for each in stop_page().cells if each.act is Act.WITHDRAW)
        return super()._turn()


def update(person: PanelRespondent, headset: Any) -> None:
    for frame in islice(headset.frames(), 3000):
        headset.submit(frame, None)
        person.update(float(frame.index))


@needs_monado[0]
@needs_monado[1]
def test_a_head_stops_an_exposure_through_the_runtime(
    ctx: moderngl.Context, tmp_path: Path
) -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        leaver = Leaver(feed, 0)
        settings = OpenXrSettings(image_size_px=(16, 16))
        with OpenXrHeadset(ctx, settings, before_wait=leaver.before_frame) as headset:
            leaver.screen = PanelScreen(headset, points_with_head=True)
            person = PanelRespondent(leaver.screen, look_down=LookDown(least_s=0.5), dwell_s=0.4)
            person.start_exposure(Exposure(1, 1, "room", "plain", 60.0))
            with pytest.raises(Withdrew):
                update(person, headset)
    assert leaver.looks_at >= 2
