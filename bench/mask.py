"""Savings from masking pixels that no lens shows; the renderer does not do it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from bench.clocked import replaced
from bench.effects import CONDITIONS
from bench.table import Result
from vrcomfort.render import scene_pass
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES, pairs

SIZE_PX = (320, 400)
SEGMENTS = 64

VERTEX = """#version 450
in vec2 corner;
void main() { gl_Position = vec4(corner, 1.0, 1.0); }  // on the near plane: nothing is nearer
"""
FRAGMENT = """#version 450
layout(location = 0) out vec4 colour;
layout(location = 1) out vec2 velocity;
void main() { colour = vec4(0.0, 0.0, 0.0, 1.0); velocity = vec2(0.0); }
"""


def measure(ctx: moderngl.Context, *, rounds: int) -> Result:
    """Draw the same frames with and without a round mask, in turn."""
    rows = []
    hidden = corners()
    for name in SCENES:
        scene = load_scene(name)
        for condition in (CONDITIONS[0], CONDITIONS[-1]):
            ratios = _ratios(ctx, scene, condition, hidden, rounds)
            low, median, high = np.percentile(ratios, [10, 50, 90])
            rows.append(
                {
                    "scene": name,
                    "condition": condition.name,
                    "masked / whole": float(median),
                    "10 %": float(low),
                    "90 %": float(high),
                }
            )
    notes = [
        f"CPU time of the whole process, all threads of the rasteriser; {SIZE_PX[0]}×{SIZE_PX[1]} "
        f"per eye, {rounds} frames. Outside of the ellipse that fills the image "
        f"({hidden_percent(hidden):.0f} % of it) a mesh on the near plane is drawn before the "
        "scene, so that nothing behind it is shaded.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Visibility mask", rows, notes)


def corners() -> NDArray[np.float32]:
    """Return (n, 2) vertices of triangles between the unit circle and the square around it."""
    angles = np.linspace(0, 2 * np.pi, SEGMENTS + 1)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    square = circle / np.abs(circle).max(axis=1, keepdims=True)
    a, b, c, d = circle[:-1], square[:-1], square[1:], circle[1:]
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 2).astype(np.float32)


def hidden_percent(triangles: NDArray[np.float32]) -> float:
    """Return the triangles' share of the image."""
    a, b, c = np.moveaxis(triangles.reshape(-1, 3, 2), 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    return float(100 * np.abs(ux * vy - uy * vx).sum() / 2 / 4)


def _ratios(
    ctx: moderngl.Context, scene: Scene, condition: Any, hidden: NDArray[np.float32], rounds: int
) -> NDArray[np.float64]:
    renderer = StereoRenderer(ctx, SIZE_PX)
    with _masking(ctx, hidden) as switch:
        renderer.begin(scene, condition)
        times = [
            [_seconds(ctx, renderer, pair, switch, masked=masked) for masked in (True, False)]
            for pair in pairs(scene, SIZE_PX, rounds + 1)
        ]
    renderer.release()
    masked, whole = np.array(times[1:]).T  # the first frame compiles shaders
    return np.asarray(masked / whole)


def _seconds(
    ctx: moderngl.Context,
    renderer: StereoRenderer,
    pair: Any,
    switch: Callable[[bool], None],
    *,
    masked: bool,
) -> float:
    before, frame = pair
    switch(masked)
    renderer.render(before, frame.index / REFRESH_HZ)
    ctx.finish()
    start_s = time.process_time()
    renderer.render(frame, (frame.index + 1) / REFRESH_HZ)
    ctx.finish()
    return time.process_time() - start_s


@contextmanager
def _masking(
    ctx: moderngl.Context, hidden: NDArray[np.float32]
) -> Iterator[Callable[[bool], None]]:
    """Yield a switch: whether scene passes begin with the hidden area on the near plane."""
    program = ctx.program(VERTEX, FRAGMENT)
    mesh = ctx.vertex_array(program, [(ctx.buffer(hidden), "2f", "corner")])
    targets, wanted = scene_pass._Targets, [False]
    begin: Any = targets.begin

    def begin_masked(self: Any) -> None:
        begin(self)
        if wanted[0]:
            ctx.enable_only(moderngl.DEPTH_TEST)
            ctx.depth_func = "1"
            mesh.render(moderngl.TRIANGLES)

    with replaced(targets, "begin", begin_masked):
        yield lambda on: wanted.__setitem__(0, on)
