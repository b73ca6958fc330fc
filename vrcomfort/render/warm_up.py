"""Frames that nobody sees, so that the first one of an exposure finds everything compiled."""

from __future__ import annotations

import numpy as np

from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Gaze, Pose, View, yaw_pitch_roll

EYES_M = (0.0, 1.6, 0.0)
WIDE = Fov(-1.2, 1.2, 1.2, -1.2)
"""Radians: two frames back to back see nearly everything around."""

LATEST_NS = 2**63 - 1
"""After it every frame goes back in time, which resets what remembers frames before."""


def looks_around(spawn: Pose) -> tuple[Frame, ...]:
    """Return a look ahead and one back, from eye height above the point where a scene begins.

    Both eyes and hands are at the same place. The gaze is straight ahead: whether there is an eye
    tracker matters later.
    """
    heads = (Pose(np.array(EYES_M), yaw_pitch_roll(yaw_rad, 0.0, 0.0)) for yaw_rad in (0.0, np.pi))
    return tuple(
        Frame(
            index=-1,
            predicted_display_time_ns=LATEST_NS,
            period_ns=1,
            head_pose=head,
            views=(View(head, WIDE), View(head, WIDE)),
            avatar_pose=spawn,
            discontinuity=True,
            gaze=Gaze(head),
            hands=(head, head),
        )
        for head in heads
    )
