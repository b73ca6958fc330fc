"""What the visibility mask saves: reads and bytes of each part of a frame, and time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from importlib import import_module

import moderngl
import numpy as np

from bench.effects import CONDITIONS, SIZE_PX
from bench.table import Result
from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, HiddenArea, HiddenAreas
from vrcomfort.gpu.visible_area import hidden_pixels
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.costs import traffic_of
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES, pairs

SEGMENTS = 64
MASKED = [condition for condition in CONDITIONS if condition.name != "plain_again"]


def measure(ctx: moderngl.Context, *, rounds: int) -> Result:
    """Draw the same frames with and without a mask, in turn; count reads and bytes of one."""
    rows = []
    for name in SCENES:
        scene = load_scene(name)
        pair = next(iter(pairs(scene, SIZE_PX, 1)))
        fov = pair[1].views[0].fov
        for mask, area in masks(ctx, fov):
            hidden = float(100 * hidden_pixels(area, fov, SIZE_PX).mean())
            for condition in MASKED:
                shares = _shares(ctx, scene, condition, pair, area)
                times = _times(ctx, scene, condition, (area, area), rounds)
                row = {"scene": name, "mask": f"{mask}, {hidden:.1f} %"}
                rows.append({**row, "condition": condition.name, **shares, "time": times})
    notes = [
        f"Masked over whole; {SIZE_PX[0]}×{SIZE_PX[1]} per eye. Reads and bytes: the left eye of "
        "one frame of the shipped walk, as `vrcomfort passes` counts them; `scene` has the resolve "
        "in it. –: no such part.",
        f"Time: median of {rounds} frames, CPU time of the whole process.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Visibility mask", rows, notes)


def masks(ctx: moderngl.Context, fov: Fov) -> Iterator[tuple[str, HiddenArea]]:
    """Yield masks by name: a round one, and the left eye's of the active OpenXR runtime."""
    yield "ellipse", beyond_ellipse(fov)
    try:
        openxr = import_module("vrcomfort.headset.openxr")
        with openxr.OpenXrHeadset(ctx) as headset:
            name, area = headset.name, headset.hidden_areas[0]
    except (ImportError, InputError):
        return
    if area is not None:
        yield name, area


def beyond_ellipse(fov: Fov) -> HiddenArea:
    """Return what lies beyond the ellipse that fills an image: 21 % of it."""
    angles = np.linspace(0, 2 * np.pi, SEGMENTS + 1)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    square = circle / np.abs(circle).max(axis=1, keepdims=True)
    left, right, up, down = fov.tangents
    middle, half = np.array([left + right, up + down]) / 2, np.array([right - left, up - down]) / 2
    quads = np.stack([circle[:-1], square[:-1], square[1:], circle[1:]], axis=1).reshape(-1, 2)
    order = np.arange(len(quads)).reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return HiddenArea((middle + half * quads).astype(np.float32), order.astype(np.uint32))


PARTS = {
    "scene": ("scene", "resolve"),
    "depth of field": ("depth_of_field",),
    "motion blur": ("motion_blur",),
    "tone map": ("tone_map",),
}


def _shares(
    ctx: moderngl.Context,
    scene: Scene,
    condition: Condition,
    pair: tuple[Frame, Frame],
    area: HiddenArea,
) -> dict[str, str]:
    """Return masked reads and bytes over whole ones, by part."""
    masked, whole = (
        traffic_of(ctx, scene, condition, pair, SIZE_PX, count_reads=True, hidden=hidden)
        for hidden in ((area, None), (None, None))
    )
    found = {}
    for part, names in PARTS.items():
        there = [name for name in names if name in whole]
        reads, of_whole = (sum(each[name].reads or 0 for name in there) for each in (masked, whole))
        moved, all_moved = (sum(each[name].bytes for name in there) for each in (masked, whole))
        words = f"{reads / of_whole:.2f}, {moved / all_moved:.2f}" if of_whole else "–"
        found[f"{part}: reads, bytes"] = words
    return found


def _times(
    ctx: moderngl.Context, scene: Scene, condition: Condition, hidden: HiddenAreas, rounds: int
) -> float:
    renderers = [StereoRenderer(ctx, SIZE_PX, hidden=each) for each in (hidden, (None, None))]
    for each in renderers:
        each.begin(scene, condition)
    times = [
        [_seconds(ctx, renderer, pair) for renderer in renderers]
        for pair in pairs(scene, SIZE_PX, rounds + 1)
    ]
    for each in renderers:
        each.release()
    masked, whole = np.array(times[1:]).T  # the first frame finds the tiles
    return float(np.median(masked / whole))


def _seconds(ctx: moderngl.Context, renderer: StereoRenderer, pair: tuple[Frame, Frame]) -> float:
    before, frame = pair
    renderer.render(before, frame.index / REFRESH_HZ)
    ctx.finish()
    start_s = time.process_time()
    renderer.render(frame, (frame.index + 1) / REFRESH_HZ)
    ctx.finish()
    return time.process_time() - start_s
