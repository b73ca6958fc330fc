"""Frames of the shipped walks, for measurements on real views."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Literal, TypeAlias, get_args

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose, View, axis_angle, rotate
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.resources import data_folder
from vrcomfort.scene.data import Scene
from vrcomfort.traces.trace import read_trace

SCENES = ("temple", "mountain")
REFRESH_HZ = 90

Motion: TypeAlias = Literal["still", "walk", "turn"]
"""At rest; as the walk has it; the head turning to the left at :data:`TURN_DEG_PER_S`."""
MOTIONS: tuple[Motion, ...] = get_args(Motion)
TURN_DEG_PER_S = 90.0
SLOW_M_PER_S = 0.3
"""A slow step to the side: a surface 1.5 m away moves by less than a pixel of 640 in a frame."""


def pairs(scene: Scene, size_px: tuple[int, int], count: int) -> Iterator[tuple[Frame, Frame]]:
    """Yield `count` pairs of consecutive frames: of each part of a walk, where the head is fastest.

    The first of each pair is a cut; the second is the one to measure.

    Raises
    ------
    InputError
        If no walk ships with the scene.
    """
    file = data_folder("scenes") / f"{scene.name}_walk.csv"
    if not file.exists():
        raise InputError(f"no walk ships with the scene {scene.name!r}; use {', '.join(SCENES)}")
    headset = PlaybackHeadset(
        read_trace(file),
        image_size_px=size_px,
        refresh_hz=REFRESH_HZ,
        spawn=scene.spawn,
        loop=False,
    )
    frames = list(headset.frames())
    steps = [_movement(a, b) for a, b in pairwise(frames)]
    for part in np.array_split(np.arange(len(steps)), count):
        fastest = int(part[np.argmax(np.take(steps, part))])
        yield replace(frames[fastest], discontinuity=True), frames[fastest + 1]


def with_motion(pair: tuple[Frame, Frame], motion: Motion) -> tuple[Frame, Frame]:
    """Return the pair with the first frame where `motion` would have had the head."""
    before, frame = pair
    if motion == "walk":
        return pair
    angle_rad = -np.radians(TURN_DEG_PER_S / REFRESH_HZ) if motion == "turn" else 0.0
    turn = Pose(orientation=axis_angle([0.0, 1.0, 0.0], angle_rad))
    head = frame.head_pose @ turn
    stage_from_now = head @ frame.head_pose.inverse()
    left, right = (View(stage_from_now @ view.pose, view.fov) for view in frame.views)
    moved = replace(before, head_pose=head, avatar_pose=frame.avatar_pose, views=(left, right))
    return moved, frame


def slowly_later(frame: Frame) -> Frame:
    """Return the frame as it is after one more frame of a slow step to the right.

    Animations stand still meanwhile.
    """
    avatar = frame.avatar_pose
    right = rotate((avatar @ frame.head_pose).orientation, np.array([1.0, 0.0, 0.0]))
    step_m = SLOW_M_PER_S / REFRESH_HZ * right
    return replace(frame, avatar_pose=Pose(avatar.position + step_m, avatar.orientation))


def time_s(frame: Frame) -> float:
    """Return the time of the scene's animations at a frame."""
    return frame.index / REFRESH_HZ


def _movement(before: Frame, after: Frame) -> float:
    """Return metres plus radians between two frames: about the motion of points a metre away."""
    step = before.head_pose.inverse() @ after.head_pose
    half_turn = np.linalg.norm(step.orientation[:3])
    return float(np.linalg.norm(step.position) + 2 * np.arcsin(min(float(half_turn), 1.0)))
