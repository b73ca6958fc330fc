"""The cost of each effect as a ratio to the plain frame, with the run's own A/A interval."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np
from numpy.typing import NDArray

from bench.table import Result
from vrcomfort.frame import Frame
from vrcomfort.gpu.timer import Stopwatch
from vrcomfort.protocol.conditions import Condition, DepthOfField, MotionBlur
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES, pairs

SIZE_PX = (640, 800)
CONDITIONS = (
    Condition(name="plain"),
    Condition(name="plain_again"),
    Condition(name="depth_of_field", depth_of_field=DepthOfField()),
    Condition(name="motion_blur", motion_blur=MotionBlur()),
    Condition(name="both", depth_of_field=DepthOfField(), motion_blur=MotionBlur()),
)


def measure(ctx: moderngl.Context, *, rounds: int) -> Result:
    """Time every condition on the same frames, in turn, between two `finish` calls."""
    rows = []
    for name in SCENES:
        scene = load_scene(name)
        seconds = frame_seconds(ctx, scene, CONDITIONS, rounds=rounds)
        ratios = seconds / seconds[:, :1]
        for index, condition in enumerate(CONDITIONS):
            low, median, high = np.percentile(ratios[:, index], [5, 50, 95])
            rows.append(
                {
                    "scene": name,
                    "condition": condition.name,
                    "ms per stereo frame": float(np.median(seconds[:, index]) * 1e3),
                    "ratio to plain": float(median),
                    "5 %": float(low),
                    "95 %": float(high),
                }
            )
    notes = [
        f"{SIZE_PX[0]}×{SIZE_PX[1]} per eye, {rounds} frames of the shipped walk, the conditions "
        "in turn on each frame; processor time of all threads on a software rasteriser, else the "
        "GPU's own time.",
        "`plain_again` is the A/A interval: the same work as `plain`.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Cost of the effects", rows, notes)


def frame_seconds(
    ctx: moderngl.Context,
    scene: Scene,
    conditions: Sequence[Condition],
    *,
    rounds: int,
    size_px: tuple[int, int] = SIZE_PX,
) -> NDArray[np.float64]:
    """Return (rounds, conditions) seconds per stereo frame, the conditions in turn on each."""
    renderers = []
    for condition in conditions:
        renderer = StereoRenderer(ctx, size_px)
        renderer.begin(scene, condition)
        renderers.append(renderer)
    stopwatch = Stopwatch(ctx)
    times = [
        [_frame_seconds(stopwatch, renderer, pair) for renderer in renderers]
        for pair in pairs(scene, size_px, rounds + 1)
    ]
    return np.array(times[1:])  # the first frame compiles shaders


def _frame_seconds(
    stopwatch: Stopwatch, renderer: StereoRenderer, pair: tuple[Frame, Frame]
) -> float:
    before, frame = pair
    scene_time_s = frame.index / REFRESH_HZ
    renderer.render(before, scene_time_s - 1 / REFRESH_HZ)
    return stopwatch.seconds(lambda: renderer.render(frame, scene_time_s))
