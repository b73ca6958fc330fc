"""A question answered by looks of the head, through the runtime: no controller, no eye tracker."""

from __future__ import annotations

from itertools import cycle
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr import fresh_monado, needs_monado
from vrcomfort.geometry import Pose, normalize, turn_to
from vrcomfort.headset.inputs import HandInput, Inputs, KeyInput
from vrcomfort.headset.monado import RemoteFeed, RemoteHand, RemoteState
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.respondent.base import Form
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_layout import Act, Cell
from vrcomfort.respondent.panel_picture import Page
from vrcomfort.session.panel_screen import PanelScreen

EYES = np.array([0.3, 1.6, -0.2])
DWELL_S = 0.4
LOOK_FRAMES = 20
"""A second, or longer where the machine is slow."""


class Looker:
    """Looks away and at the same answer in turn, so many frames each; holds no controller."""

    def __init__(self, feed: RemoteFeed, answer: int) -> None:
        self.feed, self.answer = feed, answer
        self.screen: PanelScreen | None = None
        self.looks_at = 0
        self._cell: Cell | None = None
        self._turns = cycle([False, True])
        self._at, self._frames_left = next(self._turns), 0

    def watch(self, page: Page) -> None:
        cells = [each for each in page.cells if each.act is Act.ANSWER]
        self._cell = next(each for each in cells if each.value == self.answer)
        self._frames_left = LOOK_FRAMES

    def before_frame(self) -> None:
        self._frames_left -= 1
        if self._frames_left < 0:
            self._at, self._frames_left = next(self._turns), LOOK_FRAMES
            self.looks_at += self._at
        away = RemoteHand(Pose(np.array([0.0, 1.0, 0.0])), active=False)
        self.feed.send(RemoteState(Pose(EYES, self._turn()), left=away, right=away))

    def _turn(self) -> np.ndarray:
        quad = None if self.screen is None else self.screen.quad
        if quad is None or self._cell is None or not self._at:
            return np.array([0.0, 0.0, 0.0, 1.0])  # before the panel: between answers and question
        right, down = self._cell.center
        width, height = quad.size_m
        place = Pose(np.array([(right - 0.5) * width, (0.5 - down) * height, 0.0]))
        return turn_to(normalize((quad.pose @ place).position - EYES))


def test_two_fists_are_a_wish_to_stop_and_one_is_not() -> None:
    fist, closing = HandInput(fist=True), HandInput(fist=True, closed=True)
    assert Inputs(fist, closing).stop
    assert not Inputs(closing, HandInput()).stop
    assert not Inputs(fist, fist).stop  # told once
    assert Inputs(keys=KeyInput(stop=True)).stop


@needs_monado[0]
@needs_monado[1]
def test_the_head_answers_by_two_looks(ctx: moderngl.Context, tmp_path: Path) -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

    heard: list[int | None] = []
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        looker = Looker(feed, 7)
        settings = OpenXrSettings(image_size_px=(16, 16))
        with OpenXrHeadset(ctx, settings, before_wait=looker.before_frame) as headset:
            looker.screen = PanelScreen(headset, points_with_head=True)
            person = PanelRespondent(looker.screen, watch=looker.watch, dwell_s=DWELL_S)
            form = Form(shipped_instruments()["fms"], "post")
            person.ask(form, lambda _, value, __: heard.append(value))
            extensions = headset.details["extensions"]
    assert heard == [7]
    assert looker.looks_at == 2
    print("\nbare hands:", "XR_EXT_hand_interaction" in extensions)
