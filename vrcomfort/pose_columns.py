"""Names of the pose columns that `frames.csv` and head traces share.

Poses are target-from-source as in `geometry`: head and eyes in the stage, the avatar
(world-from-stage) in the world. A pose is seven columns, ``<name>_x_m`` to ``<name>_qw``.
"""

from __future__ import annotations

TIME = "xr_time_ns"
PERIOD = "period_ns"
TRIAL = "trial"
DISCONTINUITY = "discontinuity"
"""1 where the pose before has nothing to do with this one (loop, teleport), else 0."""

_POSE_PARTS = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
_FOV_PARTS = ("left", "right", "up", "down")


def pose_columns(name: str) -> tuple[str, ...]:
    """Return the seven columns of the pose called `name`: position, then quaternion."""
    return tuple(f"{name}_{part}" for part in _POSE_PARTS)


def fov_columns(eye: str) -> tuple[str, ...]:
    """Return the four half-angle columns of the eye called `left` or `right`."""
    return tuple(f"{eye}_fov_{part}_rad" for part in _FOV_PARTS)


HEAD = pose_columns("head")
EYES = (pose_columns("left"), pose_columns("right"))
FOVS = (fov_columns("left"), fov_columns("right"))
AVATAR = pose_columns("avatar")
REQUIRED = (TIME, *HEAD)
POSE_COLUMNS = (*HEAD, *EYES[0], *EYES[1], *FOVS[0], *FOVS[1], *AVATAR)
"""All pose columns of a recorded frame, in the order they are written."""
