"""Nothing of our own making holds up the frames of an exposure."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.session import go
from tests.support.study import AheadHeadset, Scripted
from vrcomfort.frame import Frame, HeadsetEvent
from vrcomfort.geometry import Pose, Quad
from vrcomfort.headset.inputs import Inputs
from vrcomfort.respondent.panel_picture import Picture
from vrcomfort.session import exposure
from vrcomfort.session.exposure import collector_at_rest
from vrcomfort.session.panel_screen import LOADING_FRAMES, PanelScreen


class Room:
    """A headset that writes down which panels stand there in each frame that is submitted."""

    head_pose = Pose()

    def __init__(self, seen_from: int) -> None:
        self._seen_from = seen_from
        self.panels: list[Picture | None] = []
        self.submitted: list[list[Picture | None]] = []

    def frames(self) -> Iterator[Frame]:
        for count, frame in enumerate(AheadHeadset().frames()):
            yield Frame(**{**frame.__dict__, "should_render": count >= self._seen_from})

    def submit(self, frame: Frame, eyes: None) -> None:  # noqa: ARG002
        if frame.should_render:
            self.submitted.append(list(self.panels))

    def inputs(self) -> Inputs:
        return Inputs()

    def take_events(self) -> list[HeadsetEvent]:
        return []

    def allow_absence(self, duration_s: float) -> None:
        """Wait as long as usual."""

    def tick(self, hand: int) -> None:
        """Do not tick."""

    def show_pointer(self, quad: Quad | None) -> None:
        """Nobody points."""

    def show_panel(self, size_px: tuple[int, int], quad: Quad) -> Any:
        room = self
        room.panels.append(None)

        class Panel:
            def __init__(self) -> None:
                self.quad = quad

            def draw(self, picture: Picture) -> None:
                assert picture.shape[:2] == size_px[::-1]
                room.panels[-1] = picture

            def hide(self) -> None:
                room.panels.pop()

        return Panel()


def test_one_frame_that_is_seen_says_that_a_scene_is_loading() -> None:
    room = Room(seen_from=3)
    PanelScreen(room).show_loading()
    ((picture,),) = room.submitted
    assert picture is not None
    assert np.ptp(picture[..., :3]) > 100  # something is written there
    assert room.panels == []


def test_nobody_waits_for_a_headset_that_shows_nothing() -> None:
    room = Room(seen_from=LOADING_FRAMES + 1)
    PanelScreen(room).show_loading()
    assert room.submitted == []


def test_the_loading_picture_comes_before_each_scene_is_loaded(tmp_path: Path) -> None:
    order: list[str] = []

    class Screen(PanelScreen):
        def show_loading(self) -> None:
            order.append("loading")

    class Shown(AheadHeadset):
        def frames(self) -> Iterator[Frame]:
            order.append("frames")
            yield from super().frames()

    go(tmp_path, Scripted(), headset=Shown, screen=Screen(Room(0)))
    assert order == ["loading", "frames"] * 4  # two sessions of two exposures


def test_during_an_exposure_the_collector_leaves_alone_what_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exposure, "collector_at_rest", collector_at_rest)
    frozen: list[int] = []

    class Counts(AheadHeadset):
        def frames(self) -> Iterator[Frame]:
            for frame in super().frames():
                if frame.index in {0, 40}:  # training, and an exposure; counting takes a while
                    frozen.append(gc.get_freeze_count())
                yield frame

    gc.unfreeze()
    go(tmp_path, Scripted(), headset=lambda: Counts(interrupt_at=41))
    assert len(frozen) == 2
    assert min(frozen) > 1000
    assert gc.get_freeze_count() == 0
