"""Frames of the shipped walks, for measurements on what people see."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from vrcomfort.headset.base import Frame
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.headset.trace import read_trace
from vrcomfort.render.scene_data import Scene
from vrcomfort.resources import data_folder

SCENES = ("temple", "mountain")
REFRESH_HZ = 90


def pairs(scene: Scene, size_px: tuple[int, int], count: int) -> Iterator[tuple[Frame, Frame]]:
    """Yield `count` pairs of consecutive frames: of each part of a walk, where the head is fastest.

    The first of each pair is a cut; the second is the one to measure.
    """
    trace = read_trace(data_folder("scenes") / f"{scene.name}_walk.csv")
    headset = PlaybackHeadset(
        trace, image_size_px=size_px, refresh_hz=REFRESH_HZ, spawn=scene.spawn, loop=False
    )
    frames = list(headset.frames())
    steps = [_movement(a, b) for a, b in pairwise(frames)]
    for part in np.array_split(np.arange(len(steps)), count):
        fastest = int(part[np.argmax(np.take(steps, part))])
        yield replace(frames[fastest], discontinuity=True), frames[fastest + 1]


def _movement(before: Frame, after: Frame) -> float:
    """Return metres plus radians between two frames: about what things a metre away move by."""
    step = before.head_pose.inverse() @ after.head_pose
    half_turn = np.linalg.norm(step.orientation[:3])
    return float(np.linalg.norm(step.position) + 2 * np.arcsin(min(float(half_turn), 1.0)))
