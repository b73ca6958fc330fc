"""Names of the pose columns that traces and ``frames.csv`` share, and poses as cells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from vrcomfort.geometry import Fov, Pose

Body = Literal["head", "left", "right", "avatar", "left_hand", "right_hand"]
Eye = Literal["left", "right"]

_POSE_SUFFIXES = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
_FOV_SIDES = ("left", "right", "up", "down")


def pose_columns(body: Body) -> tuple[str, ...]:
    """Return the seven columns of a body: position (metres), then quaternion (x, y, z, w)."""
    return tuple(f"{body}_{suffix}" for suffix in _POSE_SUFFIXES)


def fov_columns(eye: Eye) -> tuple[str, ...]:
    """Return the four half-angle columns of an eye (radians; left and down negative)."""
    return tuple(f"{eye}_fov_{side}_rad" for side in _FOV_SIDES)


HEAD = pose_columns("head")
EYES = (*pose_columns("left"), *pose_columns("right"))
FOVS = (*fov_columns("left"), *fov_columns("right"))
AVATAR = pose_columns("avatar")
HANDS = (*pose_columns("left_hand"), *pose_columns("right_hand"))
POSE_COLUMNS = (*HEAD, *EYES, *FOVS, *AVATAR)


def pose_cells(body: Body, pose: Pose) -> dict[str, float]:
    """Return a pose as its seven named numbers."""
    return dict(zip(pose_columns(body), pose.numbers, strict=True))


def fov_cells(eye: Eye, fov: Fov) -> dict[str, float]:
    """Return a frustum as its four named numbers."""
    return dict(zip(fov_columns(eye), (fov.left, fov.right, fov.up, fov.down), strict=True))


def pose_from_cells(body: Body, cells: Mapping[str, float]) -> Pose:
    """Return the pose that `pose_cells` wrote."""
    values = np.array([cells[column] for column in pose_columns(body)])
    return Pose(values[:3], values[3:])
