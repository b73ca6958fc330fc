"""What stands in the headset while an operator keeps the participant waiting."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.operator import ScriptedDesk, Wanted
from tests.support.study import frame
from vrcomfort.frame import Frame, HeadsetEvent
from vrcomfort.geometry import Pose, Quad
from vrcomfort.headset.inputs import Inputs
from vrcomfort.protocol.texts import ENGLISH
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.respondent import Form
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_picture import Picture
from vrcomfort.session.operator_control import OperatorControl, Skipped
from vrcomfort.session.panel_screen import PanelScreen, words_picture


class WornHeadset:
    """Frames that come at once, and one panel at most."""

    def __init__(self) -> None:
        self.head_pose = Pose()
        self.quad = Quad(Pose(), (1.0, 1.0))
        self.frames_passed = 0
        self.shown: Picture | None = None
        self.drawn = 0

    def frames(self) -> Iterator[Frame]:
        while True:
            self.frames_passed += 1
            yield frame(self.frames_passed)

    def submit(self, _frame: Frame, _eyes: None) -> None:
        pass

    def inputs(self) -> Inputs:
        return Inputs()

    def take_events(self) -> list[HeadsetEvent]:
        return []

    def allow_absence(self, _duration_s: float) -> None:
        pass

    def tick(self, _hand: int) -> None:
        pass

    def show_panel(self, _size_px: tuple[int, int], quad: Quad) -> WornHeadset:
        self.quad = quad
        return self

    def show_pointer(self, _quad: Quad | None) -> None:
        pass

    def draw(self, picture: Picture) -> None:
        self.shown = picture
        self.drawn += 1

    def hide(self) -> None:
        self.shown = None


class Events:
    """A log that forgets."""

    def now_s(self) -> float:
        return 0.0

    def event_soon(self, name: str, start_s: float | None = None, *, detail: str = "") -> None:
        pass


def test_frames_pass_and_words_stand_there_until_the_session_is_started():
    headset = WornHeadset()
    screen = PanelScreen(headset)
    desk = ScriptedDesk([Wanted("ready", "start", after=20)], starts_sessions=True)
    operators = OperatorControl(desk)
    operators.attach(Events(), screen)
    seen: list[Picture | None] = []
    screen.each_frame = lambda: seen.append(headset.shown)
    operators.await_start()
    assert headset.frames_passed >= 20
    assert all(picture is words_picture(ENGLISH.ready) for picture in seen)
    assert headset.shown is None


def test_a_pause_says_so_where_nothing_else_is_shown_and_is_gone_afterwards():
    headset = WornHeadset()
    screen = PanelScreen(headset)
    desk = ScriptedDesk([Wanted("exposure", "pause"), Wanted("exposure", "go_on", after=5)])
    operators = OperatorControl(desk)
    operators.attach(Events(), screen)
    operators.begin("exposure", "exposure 1 of 1")
    shown = []
    for _ in range(12):
        operators.look()
        shown.append(headset.shown)
    paused = [picture for picture in shown if picture is not None]
    assert paused == [words_picture(ENGLISH.paused)] * len(paused)
    assert 4 <= len(paused) < len(shown)
    assert shown[0] is None
    assert shown[-1] is None


def test_a_question_goes_before_the_words_and_the_words_come_back_after_it():
    headset = WornHeadset()
    screen = PanelScreen(headset)
    question = words_picture("How do you feel?")
    screen.show(question)
    screen.rest_on(ENGLISH.paused)
    assert headset.shown is question
    screen.show(None)
    assert headset.shown is words_picture(ENGLISH.paused)
    drawn = headset.drawn
    screen.rest_on(ENGLISH.paused)  # the same words again are not drawn again
    assert headset.drawn == drawn
    screen.rest_on(None)
    assert headset.shown is None


def test_a_question_that_an_operator_ends_leaves_nothing_in_the_headset():
    headset = WornHeadset()
    screen = PanelScreen(headset)
    desk = ScriptedDesk([Wanted("questionnaire", "skip", after=5)])
    operators = OperatorControl(desk)
    operators.attach(Events(), screen)
    operators.begin("questionnaire", "questionnaire ssq (post)")
    screen.each_frame = operators.look
    form = Form(shipped_instruments()["ssq"], "post")
    with pytest.raises(Skipped):
        PanelRespondent(screen).ask(form, lambda *_: None)
    assert headset.drawn > 0
    assert headset.shown is None
