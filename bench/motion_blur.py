"""Motion blur as walked: error against brute force and processor time, ours beside per_pixel.

``python -m bench.motion_blur`` prints the table of ``docs/motion_blur.md``. Times are processor
time of the passes between two ``glFinish``, the methods in turn: the median of their ratios to
`per_pixel` with 8 samples in the same round. `per_pixel 8 again` is the same work (A/A). Reads and
bytes are counted, for each pixel: see ``vrcomfort.gpu.traffic``.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.passes import watched
from vrcomfort.gpu.traffic import TrafficCounter, added_up
from vrcomfort.protocol.conditions import MotionBlur
from vrcomfort.render.effects.effect import EffectInputs, EyeFrame
from vrcomfort.render.effects.motion_blur import MotionBlurPass
from vrcomfort.tradeoff.brute_force import Reference, read_rgb
from vrcomfort.tradeoff.captures import Capture, capture_views, context
from vrcomfort.tradeoff.cases import Case, Scope, frames
from vrcomfort.tradeoff.image_error import judged, rms, sure
from vrcomfort.tradeoff.methods import SHUTTER, base_condition
from vrcomfort.tradeoff.store import scene_and_hash
from vrcomfort.tradeoff.walk import time_s

METHODS: dict[str, dict[str, Any]] = {
    "per_pixel 8": {"method": "per_pixel", "samples": 8},
    "per_pixel 8 again": {"method": "per_pixel", "samples": 8},
    "per_pixel 16": {"method": "per_pixel", "samples": 16},
    **{f"ours {samples}": {"samples": samples} for samples in (4, 8, 16, 32)},
}


def main() -> None:
    """Measure each scene at one size."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", default="640x800", help="of an eye's image")
    parser.add_argument("--samples", type=int, default=128, help="of the reference")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--shutter", type=float, default=1.0, help="open for so much of the frame")
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    print("| scene | method | processor time | reads / px | bytes / px | RMS · 10³ |")
    print("|---|---|---|---|---|---|")
    for scene in ("temple", "mountain"):
        _measure(scene, (width, height), options.samples, options.rounds, options.shutter)


def _measure(
    name: str, size_px: tuple[int, int], samples: int, rounds: int, shutter_fraction: float
) -> None:
    scene, _ = scene_and_hash(name)
    opening = {"shutter_fraction": shutter_fraction}
    condition = base_condition("motion_blur")
    if condition.motion_blur is not None:
        streaks = condition.motion_blur.model_copy(update=opening)
        condition = condition.model_copy(update={"motion_blur": streaks})
    pair = frames(Case(name, 0, "walk", "motion_blur"), Scope(size_px=size_px))
    capture = capture_views(scene, condition, pair, size_px)[0]
    reference = Reference(context(), scene, condition, size_px).render(
        capture.camera, time_s(pair[1]), capture.previous, focus_m=1.5, samples=samples
    )
    exposure = scene.environment.exposure
    seen = sure(reference.halves, exposure=exposure)
    settings = {each: {**SHUTTER, **METHODS[each], **opening} for each in METHODS}
    passes = {each: blur_pass(context(), capture, settings[each]) for each in METHODS}
    frame = EyeFrame(0, 0, Pose(), capture.camera, capture.previous)
    seconds = processor_s({k: lambda p=p: p.render(frame) for k, p in passes.items()}, rounds)
    cost = {each: np.median(seconds[each] / seconds["per_pixel 8"]) for each in METHODS}
    for each, effect in passes.items():
        image = judged(read_rgb(effect.target), seen, exposure)
        error = 1e3 * rms(image, judged(reference.image, seen, exposure))
        reads, moved = traffic(capture, settings[each], frame)
        print(f"| {name} | {each} | {cost[each]:.2f} | {reads:.1f} | {moved:.1f} | {error:.2f} |")


def blur_pass(ctx: moderngl.Context, capture: Capture, settings: dict[str, Any]) -> MotionBlurPass:
    """Return motion blur of a captured image."""
    height, width = capture.depth.shape
    size_px = width, height
    alpha = np.ones((height, width, 1), np.float32)
    colour, depth = gl.color_texture(ctx, size_px), gl.depth_texture(ctx, size_px)
    colour.write(_half(np.concatenate([capture.sharp, alpha], axis=-1)))
    depth.write(capture.depth.tobytes())
    velocity = gl.color_texture(ctx, size_px, components=2)
    if capture.velocity_px is not None:
        velocity.write(_half(capture.velocity_px))
    reads = {"depth": depth, "velocity": velocity}
    wanted = MotionBlur.model_validate(settings)
    return MotionBlurPass(EffectInputs(ctx, wanted, colour, reads))


def traffic(capture: Capture, settings: dict[str, Any], frame: EyeFrame) -> tuple[float, float]:
    """Return texture reads and bytes for each pixel."""
    with shaders.counting_reads():
        effect = blur_pass(context(), capture, settings)
    counter = TrafficCounter(context())
    with watched(counter):
        effect.render(frame)
    moved, pixels = added_up(counter.drawn), capture.depth.size
    return (moved.reads or 0) / pixels, moved.bytes / pixels


def _half(values: NDArray[np.float32]) -> bytes:
    return values.astype(np.float16).tobytes()


def processor_s(
    draws: dict[str, Callable[[], None]], rounds: int
) -> dict[str, NDArray[np.float64]]:
    """Return (rounds,) seconds of each, after one that warms up."""
    found: dict[str, list[float]] = {name: [] for name in draws}
    for _ in range(rounds + 1):
        for name, draw in draws.items():
            context().finish()
            start = time.process_time()
            draw()
            context().finish()
            found[name].append(time.process_time() - start)
    return {name: np.array(seconds[1:]) for name, seconds in found.items()}


if __name__ == "__main__":
    main()
