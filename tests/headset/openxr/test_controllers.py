"""Whatever a hand's controller has, it alone stops an exposure, through a runtime."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice, product
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr_runtime import ScriptedRuntime, numbers
from vrcomfort.geometry import Pose
from vrcomfort.respondent.base import Exposure, Withdrew
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_layout import Act, stop_cells
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.rehearsal import aim_at

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.openxr.profiles import HANDS, PROFILES, Profile

HEAD = Pose(np.array([0.0, 1.6, 0.0]))
BESIDE = Pose(np.array([0.2, 1.2, -0.3]))
FRAME_S = 0.1
"""Of the panel's clock: the runtime's frames do not wait."""
BY_INPUTS = {tuple(sorted(p.own(hand).items())): (p, hand) for p, hand in product(PROFILES, HANDS)}
"""Inputs that a hand has → one of those that have them."""


class OneHand:
    """A participant with one controller, or one bare hand, in an exposure."""

    def __init__(self, made: OpenXrHeadset, runtime: ScriptedRuntime, profile: Profile, hand: str):
        self._made, self._runtime, self._hand = made, runtime, hand
        self._own = profile.own(hand)
        self._now_s = 0.0
        self.screen = PanelScreen(made)
        self.panel = PanelRespondent(self.screen, now_s=lambda: self._now_s)
        self.panel.start_exposure(Exposure(1, 1, "room", "plain", 60.0))
        self._frames = made.frames()
        runtime.say(f"now head {numbers(HEAD)}")
        self.point(BESIDE)

    def point(self, aim: Pose) -> None:
        self._runtime.say(f"now hand {self._hand} {numbers(aim)}")

    def press(self, action: str, value: int) -> None:
        path = f"/user/hand/{self._hand}/input/{self._own[action]}"
        self._runtime.say(f"now press {path} {value}")

    def pass_frames(self, count: int) -> None:
        for frame in islice(self._frames, count):
            self._now_s += FRAME_S
            self._made.submit(frame, None)
            self.panel.update(self._now_s)

    def ask_to_stop(self) -> None:
        bare = "fist" in self._own
        self.press("fist" if bare else "stop", 1)
        self.pass_frames(round(2.5 / FRAME_S) if bare else 2)
        self.press("fist" if bare else "stop", 0)
        self.pass_frames(2)


@contextmanager
def one_hand(ctx: moderngl.Context, folder: Path, profile: Profile, hand: str) -> Iterator[OneHand]:
    other = next(each for each in HANDS if each != hand)
    script = f"profile left {profile.path}\nprofile right {profile.path}\nspeed 0\n"
    settings = OpenXrSettings(image_size_px=(16, 16))
    with (
        ScriptedRuntime(folder, f"{script}start active {other} 0") as runtime,
        OpenXrHeadset(ctx, settings) as made,
    ):
        yield OneHand(made, runtime, profile, hand)


@pytest.mark.parametrize(
    ("profile", "hand"),
    BY_INPUTS.values(),
    ids=[f"{each.path} {hand}" for each, hand in BY_INPUTS.values()],
)
def test_either_hand_alone_stops_an_exposure(
    ctx: moderngl.Context, tmp_path: Path, profile: Profile, hand: str
) -> None:
    with one_hand(ctx, tmp_path, profile, hand) as person:
        person.pass_frames(5)
        assert person.screen.quad is None
        person.ask_to_stop()
        assert person.screen.quad is not None  # the question stands there
        stop = next(each for each in stop_cells() if each.act is Act.WITHDRAW)
        person.point(aim_at(person.screen.quad, stop.center))
        person.pass_frames(2)
        person.press("select", 1)
        with pytest.raises(Withdrew, match="during exposure"):
            person.pass_frames(3)


@pytest.mark.parametrize("seconds", [1.0, None])
def test_a_short_fist_and_one_that_was_there_before_ask_nothing(
    ctx: moderngl.Context, tmp_path: Path, seconds: float | None
) -> None:
    profile = next(each for each in PROFILES if each.path == "ext/hand_interaction_ext")
    with one_hand(ctx, tmp_path, profile, "left") as person:
        if seconds is None:
            person.press("fist", 1)
            person.pass_frames(50)
        else:
            person.pass_frames(5)
            for _ in range(4):
                person.press("fist", 1)
                person.pass_frames(round(seconds / FRAME_S))
                person.press("fist", 0)
                person.pass_frames(5)
        assert person.screen.quad is None
