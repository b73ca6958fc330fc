"""Frames that nobody sees, so that the first one of an exposure finds everything compiled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vrcomfort.geometry import Fov, Gaze, Pose, View, yaw_pitch_roll

EYES_M = (0.0, 1.6, 0.0)
WIDE = Fov(-1.2, 1.2, 1.2, -1.2)
"""Radians: two frames back to back see nearly everything around."""

LATEST_NS = 2**63 - 1
"""After it every frame goes back in time, which resets what remembers frames before."""


@dataclass(frozen=True)
class WarmUpFrame:
    """A look from where a scene begins."""

    avatar_pose: Pose
    head_pose: Pose
    index: int = -1
    predicted_display_time_ns: int = LATEST_NS
    period_ns: int = 1
    discontinuity: bool = True

    @property
    def gaze(self) -> Gaze:
        """Return a look straight ahead: whether there is an eye tracker matters later."""
        return Gaze(self.head_pose)

    @property
    def views(self) -> tuple[View, View]:
        """Return both eyes, at the same place."""
        view = View(self.head_pose, WIDE)
        return view, view


def looks_around(spawn: Pose) -> tuple[WarmUpFrame, ...]:
    """Return a look ahead and one back, from eye height above the point where a scene begins."""
    return tuple(
        WarmUpFrame(spawn, Pose(np.array(EYES_M), yaw_pitch_roll(yaw_rad, 0.0, 0.0)))
        for yaw_rad in (0.0, np.pi)
    )
