"""Cost of effects that blur nothing, against the same frame without them: none."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from bench.table import Result
from vrcomfort.frame import Frame
from vrcomfort.gpu.gl import is_software
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur, SpeedBlur
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES, pairs

SIZE_PX = (320, 400)
DARKNESS = (0.0, 0.0, 0.0)
WITHIN, LESS, MORE = "within A/A", "less than plain", "early-outs"


class Case(NamedTuple):
    """A condition, its expected cost, whether the scene has a sun and the head moves."""

    name: str
    condition: Condition
    expected: str
    sun: bool = True
    still: bool = False


def _case(
    name: str, expected: str, *, sun: bool = True, still: bool = False, **effects: Any
) -> Case:
    return Case(name, Condition(name="case", **effects), expected, sun, still)


CASES = (
    _case("plain", "1"),
    _case("plain again (A/A)", "1"),
    _case(
        "depth of field, largest radius 0",
        WITHIN,
        depth_of_field=DepthOfField(max_radius_percent=0),
    ),
    _case("motion blur, shutter never open", WITHIN, motion_blur=MotionBlur(shutter_fraction=0)),
    _case("speed blur that nothing makes grow", WITHIN, speed_blur=SpeedBlur()),
    _case("another focus, and nothing to blur", WITHIN, focus=Focus(method="autofocus_zone")),
    _case("no sun: no shadow pass", LESS, sun=False),
    _case(
        "depth of field, all in focus",
        MORE,
        depth_of_field=DepthOfField(law="dioptre", full_blur_dioptre=1e3),
    ),
    _case("depth of field", MORE, depth_of_field=DepthOfField(law="dioptre")),
    _case("motion blur, nothing moves", MORE, still=True, motion_blur=MotionBlur(mode="full")),
    _case(
        "motion blur, less than half a pixel",
        MORE,
        motion_blur=MotionBlur(mode="full", shutter_fraction=1e-4),
    ),
    _case("motion blur", MORE, motion_blur=MotionBlur(mode="full")),
)


def measure(ctx: moderngl.Context, *, rounds: int) -> Result:
    """Time all cases in turn on the same frames of each scene."""
    rows = []
    for name in SCENES:
        seconds = _seconds(ctx, load_scene(name), rounds)
        rows += _rows(name, seconds / seconds[:, :1])
    _, clock = _clock(ctx)
    notes = [
        f"{SIZE_PX[0]}×{SIZE_PX[1]} per eye, {rounds} frames of the shipped walk, the cases in "
        f"turn on each frame; {clock} between two finish(); ratio to `plain` on the same frame.",
        "A case that needs no pass passes where its median lies within the 5–95 % of the same work "
        "done twice in this run.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Model only what is required", rows, notes)


def _rows(scene: str, ratios: NDArray[np.float64]) -> Sequence[dict[str, Any]]:
    # Which of the two A comes first is of no account, hence both the ratio and its inverse.
    again = np.concatenate([ratios[:, 1], 1 / ratios[:, 1]])
    low, high = np.percentile(again, [5, 95])
    rows = []
    for index, case in enumerate(CASES):
        five, median, ninety_five = np.percentile(ratios[:, index], [5, 50, 95])
        held = {WITHIN: low <= median <= high, LESS: median < 1}.get(case.expected)
        rows.append(
            {
                "scene": scene,
                "case": case.name,
                "ratio to plain": float(median),
                "5 %": float(five),
                "95 %": float(ninety_five),
                "expected": case.expected,
                "holds": "" if held is None else bool(held),
            }
        )
    return rows


def _seconds(ctx: moderngl.Context, scene: Scene, rounds: int) -> NDArray[np.float64]:
    """Return (rounds, cases) seconds per stereo frame."""
    dark = replace(scene, environment=replace(scene.environment, sun_irradiance=DARKNESS))
    renderers = []
    for case in CASES:
        renderer = StereoRenderer(ctx, SIZE_PX)
        renderer.begin(scene if case.sun else dark, case.condition)
        renderers.append(renderer)
    now, _ = _clock(ctx)
    times = []
    for before, frame in pairs(scene, SIZE_PX, rounds + 1):
        times.append(
            [
                _frame_seconds(ctx, renderer, before, frame, still=case.still, now=now)
                for case, renderer in zip(CASES, renderers, strict=True)
            ]
        )
    return np.array(times[1:])  # the first frame compiles shaders


def _frame_seconds(
    ctx: moderngl.Context,
    renderer: StereoRenderer,
    before: Frame,
    frame: Frame,
    *,
    still: bool,
    now: Callable[[], float],
) -> float:
    """Return the seconds of a frame; `still`: the frame before it was the same."""
    time_s = frame.index / REFRESH_HZ
    if still:
        renderer.render(replace(frame, discontinuity=True), time_s)
    else:
        renderer.render(before, time_s - 1 / REFRESH_HZ)
    ctx.finish()
    start_s = now()
    renderer.render(frame, time_s)
    ctx.finish()
    return now() - start_s


def _clock(ctx: moderngl.Context) -> tuple[Callable[[], float], str]:
    """Return a clock and its name: where the CPU draws, other programs must not count."""
    if is_software(ctx):
        return time.process_time, "CPU time of all threads"
    return time.perf_counter, "wall clock"
