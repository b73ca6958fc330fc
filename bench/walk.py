"""Frames of the shipped walks, for measurements on what people see."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from vrcomfort.headset.base import Frame
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.headset.trace import read_trace
from vrcomfort.render.scene_data import Scene
from vrcomfort.resources import data_folder

SCENES = ("temple", "mountain")
REFRESH_HZ = 90


def pairs(scene: Scene, size_px: tuple[int, int], count: int) -> Iterator[tuple[Frame, Frame]]:
    """Yield `count` pairs of consecutive frames, spread evenly over a walk through the scene.

    The first of each pair is a cut; the second is the one to measure.
    """
    trace = read_trace(data_folder("scenes") / f"{scene.name}_walk.csv")
    headset = PlaybackHeadset(
        trace, image_size_px=size_px, refresh_hz=REFRESH_HZ, spawn=scene.spawn, loop=False
    )
    frames = list(headset.frames())
    for index in np.linspace(1, len(frames) - 1, count + 1).astype(int)[:-1]:
        yield replace(frames[index - 1], discontinuity=True), frames[index]
