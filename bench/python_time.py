"""Python's own time per frame: everything that is not inside an OpenGL call."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from bench.effects import CONDITIONS
from bench.table import Result
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.headset.trace import read_trace
from vrcomfort.render.gltf import load_scene
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.resources import data_folder
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES

SIZE_PX = (64, 80)
"""Small, so that a software rasteriser takes little: Python's time does not depend on it."""

_CLASSES = ("Buffer", "Context", "Framebuffer", "Program", "Texture", "Uniform", "VertexArray")


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
    with _clocked_opengl() as inside:
        start_s = time.thread_time()
        for frame in headset.frames():
            rendered = renderer.render(frame, frame.index / REFRESH_HZ)
            headset.submit(frame, rendered.eyes)
            now_s = time.thread_time()
            seconds.append(now_s - start_s - inside())
            ctx.finish()
            inside()
            start_s = time.thread_time()
    return np.array(seconds[1:])  # the first frame compiles shaders


@contextmanager
def _clocked_opengl() -> Iterator[Callable[[], float]]:
    """Clock moderngl's methods; yields what returns the seconds in them since it was last asked."""
    spent_s = [0.0, 0]  # seconds, and how deep calls are nested
    kept = [
        (owner, name, method)
        for owner in (getattr(moderngl, name) for name in _CLASSES if hasattr(moderngl, name))
        for name, method in vars(owner).items()
        if callable(method) and not name.startswith("__")
    ]
    for owner, name, method in kept:
        setattr(owner, name, _clocked(method, spent_s))

    def taken() -> float:
        seconds, spent_s[0] = spent_s[0], 0.0
        return seconds

    try:
        yield taken
    finally:
        for owner, name, method in kept:
            setattr(owner, name, method)


def _clocked(method: Callable[..., Any], spent_s: list[float]) -> Callable[..., Any]:
    def call(*arguments: Any, **options: Any) -> Any:
        spent_s[1] += 1
        start_s = time.thread_time()
        try:
            return method(*arguments, **options)
        finally:
            spent_s[1] -= 1
            if not spent_s[1]:
                spent_s[0] += time.thread_time() - start_s

    return call
