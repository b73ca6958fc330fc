"""Inputs of a participant's hands, eyes and keys, and the pointer on panels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Gaze, Pose, Quad


@dataclass(frozen=True)
class HandInput:
    """One controller, or one bare hand, at one frame.

    Parameters
    ----------
    aim
        stage-from-aim: it points along −Z. None where the controller is off or not tracked.
    select, back, stop
        True in the one frame in which the button goes down.
    held
        True as long as the button of `select` is down.
    fist, closed
        Of a bare hand: whether it is a fist, and whether it became one in this frame.
    thumbstick
        (right, forward), each −1 to 1.
    """

    aim: Pose | None = None
    select: bool = False
    back: bool = False
    stop: bool = False
    held: bool = False
    fist: bool = False
    closed: bool = False
    thumbstick: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class SeenGaze(Gaze):
    """Where both eyes look, and when the tracker saw them.

    Parameters
    ----------
    time_ns
        On the clock of the frames' predicted display times; 0 where the tracker does not say.
    """

    time_ns: int = 0


@dataclass(frozen=True)
class KeyInput:
    """Keyboard and mouse of a window at one frame.

    Parameters
    ----------
    arrow
        Presses of the arrow keys since the frame before, (right, down).
    digits
        Number keys since the frame before, in order.
    letters
        Other keys that write something, small letters and -, in order.
    enter, back, stop
        True in the one frame in which the key goes down.
    walk
        (right, forward) of the keys that are held, each −1, 0 or 1.
    turn_rad, look_up_rad
        Movement of the mouse since the frame before: to the left, and up.
    """

    arrow: tuple[int, int] = (0, 0)
    digits: str = ""
    letters: str = ""
    enter: bool = False
    back: bool = False
    stop: bool = False
    walk: tuple[int, int] = (0, 0)
    turn_rad: float = 0.0
    look_up_rad: float = 0.0


@dataclass(frozen=True)
class Inputs:
    """Hands, eyes and keys at one frame; `gaze` is None where the headset has no eye tracker."""

    left: HandInput = HandInput()
    right: HandInput = HandInput()
    gaze: SeenGaze | None = None
    keys: KeyInput = KeyInput()

    @property
    def hands(self) -> tuple[HandInput, HandInput]:
        """Return (left, right)."""
        return self.left, self.right

    @property
    def stop(self) -> bool:
        """Return whether the participant asks to stop: with a button, by key, or with two fists."""
        left, right = self.hands
        two_fists = left.fist and right.fist and (left.closed or right.closed)
        return left.stop or right.stop or self.keys.stop or two_fists

    @property
    def back(self) -> bool:
        """Return whether the participant goes back, with either hand or by key."""
        return self.left.back or self.right.back or self.keys.back


POINTER_SIZE_PX = 32, 32
PANEL_SHARE = 0.02
"""Its diameter, of the panel's width: nearly a degree on a panel 45 degrees wide."""
LIFT_M = 0.002
"""Distance before the panel, so that the pointer is never hidden by it."""

COLOUR, RIM = (255, 210, 80), (0, 0, 0)
RIM_SHARE = 0.3
"""Of its radius."""


@lru_cache(maxsize=1)
def pointer_picture() -> NDArray[np.uint8]:
    """Return (height, width, 4) pixels, sRGB with straight alpha: a disc with a dark rim."""
    width, height = POINTER_SIZE_PX
    y, x = np.mgrid[:height, :width]
    radius_px = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2)
    edge_px = width / 2 - 1
    picture = np.zeros((height, width, 4), np.uint8)
    inner = np.clip(edge_px * (1 - RIM_SHARE) - radius_px + 0.5, 0, 1)[..., None]
    picture[..., :3] = np.rint(inner * COLOUR + (1 - inner) * RIM)
    picture[..., 3] = np.rint(255 * np.clip(edge_px - radius_px + 0.5, 0, 1))
    picture.flags.writeable = False
    return picture


def pointer_quad(panel: Quad, point: tuple[float, float]) -> Quad:
    """Return where the pointer stands at the fractions (right, down) of a panel."""
    width_m, height_m = panel.size_m
    right, down = point
    place = Pose(np.array([(right - 0.5) * width_m, (0.5 - down) * height_m, LIFT_M]))
    return Quad(panel.pose @ place, (PANEL_SHARE * width_m, PANEL_SHARE * width_m))
