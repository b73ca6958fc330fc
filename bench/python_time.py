"""Python's own time per frame: everything that is not inside an OpenGL call."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from bench.clocked import Clock, clocked_opengl
from bench.effects import CONDITIONS
from bench.table import Result
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES

SIZE_PX = (64, 80)
"""Small, so that a software rasteriser takes little: Python's time does not depend on it."""


def measure(ctx: moderngl.Context, *, frames: int) -> Result:
    """Play each shipped walk and take the time in OpenGL calls away from each frame's."""
    rows = []
    for name in SCENES:
        for condition in (CONDITIONS[0], CONDITIONS[-1]):
            seconds = _python_seconds(ctx, name, condition, frames)
            median, high = np.percentile(seconds, [50, 99])
            rows.append(
                {
                    "scene": name,
                    "condition": condition.name,
                    "median ms": float(median * 1e3),
                    "p99 ms": float(high * 1e3),
                    "median, share of a 90 Hz frame": float(median * 90),
                }
            )
    notes = [
        f"{frames} stereo frames of the shipped walk; playback and renderer, without files.",
        "CPU time of the Python thread; what is inside moderngl's methods is taken away.",
    ]
    return Result("Python time per frame", rows, notes)


def _python_seconds(
    ctx: moderngl.Context, name: str, condition: Any, frames: int
) -> NDArray[np.float64]:
    scene = load_scene(name)
    renderer = StereoRenderer(ctx, SIZE_PX)
    renderer.begin(scene, condition)
    headset = PlaybackHeadset(
        read_trace(data_folder("scenes") / f"{name}_walk.csv"),
        image_size_px=SIZE_PX,
        refresh_hz=REFRESH_HZ,
        spawn=scene.spawn,
        max_frames=frames + 1,
    )
    seconds = []
    clock = Clock()
    with clocked_opengl(clock):
        clock.lap()
        for frame in headset.frames():
            rendered = renderer.render(frame, frame.index / REFRESH_HZ)
            headset.submit(frame, rendered.eyes)
            seconds.append(clock.lap().python_s)
            ctx.finish()
            clock.lap()
    return np.array(seconds[1:])  # the first frame compiles shaders
