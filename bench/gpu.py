"""How long frames take on this machine's GPU, at headsets' sizes, and who holds 90 Hz.

``python -m bench.gpu --out FOLDER`` runs unattended on any machine with a GPU (EGL, no display). It
times every step and method of `vrcomfort tradeoff` on whole stereo frames, part by part, and
the copy of an image beside them: no effect can be faster than its bytes are moved. It writes
``gpu.json`` and ``gpu.md``, which name the GPU. On a software rasteriser times are the processor's.

``--model`` needs no GPU: it counts bytes and says how long known GPUs take at least to move them.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from bench.table import Result, write
from vrcomfort.gpu import gl
from vrcomfort.gpu.timer import Stopwatch
from vrcomfort.tradeoff.captures import context
from vrcomfort.tradeoff.cases import Case, Scope
from vrcomfort.tradeoff.costs import CaseTime, MethodTime, time_case, traffic_of_method
from vrcomfort.tradeoff.methods import Effect, methods, no_blur, pick
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES

SIZES_PX = ((1832, 1920), (2064, 2208))
"""One eye of a Quest 2 and of a Quest 3, as their runtimes recommend."""

COPIES, TEXEL_BYTES = 50, 8
BUDGET = 0.9
"""Of a period: the rest is the runtime's, which puts both eyes' images together."""


def measure(
    sizes_px: Sequence[tuple[int, int]], scenes: Sequence[str], names: tuple[str, ...] | None
) -> Result:
    """Time the methods with these names (all where None) and return a row for each."""
    rows = []
    for size_px in sizes_px:
        copied = copy_bytes_per_s(context(), size_px)
        for scene in scenes:
            for effect in ("depth_of_field", "motion_blur"):
                rows += _rows(scene, effect, Scope(size_px=size_px, methods=names), copied)
    budget_ms = BUDGET * 1e3 / REFRESH_HZ
    notes = [
        f"GPU: {context().info['GL_RENDERER']}; {context().info['GL_VERSION']}.",
        "`frame ms`: both eyes, scene and effects, median; `p99 ms` of the effects alone. "
        "`parts`: medians, ms. `copy ms`: moving the effects' bytes as fast as an image is copied.",
        f"`holds`: the frame and its effects' p99 beyond their median fit into {budget_ms:.1f} ms, "
        f"{BUDGET:.0%} of a period at {REFRESH_HZ:g} Hz.",
    ]
    return Result("Frame times on this GPU", rows, notes)


GPUS = {"GeForce RTX 3060": 360.0, "GeForce RTX 4070": 504.0, "GeForce RTX 4090": 1008.0}
"""GB/s between memory and GPU, as published for them."""


def model(size_px: tuple[int, int], scenes: Sequence[str], names: tuple[str, ...] | None) -> Result:
    """Count the bytes of effects, and divide them by the bandwidth of GPUs."""
    scope = Scope(size_px=size_px, methods=names)
    pixels = 2 * size_px[0] * size_px[1]
    rows = []
    for scene in scenes:
        for effect in ("depth_of_field", "motion_blur"):
            case = Case(scene, 1, "still" if effect == "depth_of_field" else "walk", effect)
            for method in pick(methods(effect), names):
                if method == no_blur(effect):
                    continue
                moved = traffic_of_method(method, case, scope)
                found = moved["bytes_per_pixel"]
                least = {
                    f"{name}, ms": found * pixels / per_s / 1e6 for name, per_s in GPUS.items()
                }
                rows.append({
                    "scene": scene, "method": method.name, "bytes per pixel": found,
                    "reads per pixel": moved["reads_per_pixel"], **least, "measured": "",
                })  # fmt: skip
    notes = [
        f"Both eyes at {size_px[0]}×{size_px[1]}: least times of the effects, from bytes alone. "
        "No cache but a perfect one within a pass, no arithmetic, no waiting.",
    ]
    return Result("Least times by bandwidth", rows, notes)


def copy_bytes_per_s(ctx: moderngl.Context, size_px: tuple[int, int]) -> float:
    """Return how many bytes a second a copy of an image of half floats reads and writes."""
    source, target = (gl.color_texture(ctx, size_px) for _ in range(2))
    read, written = (ctx.framebuffer([texture]) for texture in (source, target))
    watch = Stopwatch(ctx)
    watch.seconds(lambda: ctx.copy_framebuffer(written, read))  # the first one makes it
    seconds = [watch.seconds(lambda: ctx.copy_framebuffer(written, read)) for _ in range(COPIES)]
    return 2 * size_px[0] * size_px[1] * TEXEL_BYTES / float(np.median(seconds))


def _rows(scene: str, effect: Effect, scope: Scope, copied: float) -> list[dict[str, Any]]:
    case = Case(scene, 1, "still" if effect == "depth_of_field" else "walk", effect)
    found = time_case(case, scope, lambda: None)
    by_name = {each.name: each for each in pick(methods(effect), scope.methods)}
    pixels = 2 * scope.size_px[0] * scope.size_px[1]
    rows = []
    for timed in found.methods:
        method = by_name[timed.method]
        moved = 0.0
        if method != no_blur(effect):
            moved = traffic_of_method(method, case, scope)["bytes_per_pixel"]
        rows.append(_row(found, timed, scope.size_px) | {
            "bytes per pixel": moved,
            "copy ms": 1e3 * moved * pixels / copied,
        })  # fmt: skip
    return rows


def _row(found: CaseTime, timed: MethodTime, size_px: tuple[int, int]) -> dict[str, Any]:
    p99_ms = timed.effect_p99_ms
    late_ms = 0.0 if p99_ms is None else p99_ms - timed.effect_ms
    holds = timed.frame_ms + late_ms <= BUDGET * 1e3 / REFRESH_HZ
    return {
        "size": "×".join(map(str, size_px)),
        "scene": found.case.scene,
        "effect": found.case.effect,
        "method": timed.method,
        "frame ms": timed.frame_ms,
        "plain frames": timed.cost,
        "effect ms": timed.effect_ms,
        "p99 ms": "too few frames" if p99_ms is None else p99_ms,
        "holds": holds,
        "parts": ", ".join(f"{name} {ms:.3g}" for name, ms in timed.parts_ms.items()),
        "frames": timed.rounds,
    }


def main() -> None:
    """Read the command line, measure and write."""
    parser = argparse.ArgumentParser(prog="python -m bench.gpu", description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="folder to write to")
    parser.add_argument("--sizes", nargs="+", metavar="WIDTHxHEIGHT", help="of one eye's image")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=SCENES)
    parser.add_argument("--methods", nargs="+", help="only these, as `vrcomfort tradeoff` has it")
    parser.add_argument("--model", action="store_true", help="by bandwidth; measures nothing")
    options = parser.parse_args()
    sizes = [tuple(map(int, text.split("x"))) for text in options.sizes or ()] or SIZES_PX
    names = tuple(options.methods) if options.methods else None
    if options.model:
        write(options.out, "gpu_model", model(sizes[0], options.scenes, names))
        return
    write(options.out, "gpu", measure(sizes, options.scenes, names))


if __name__ == "__main__":
    main()
