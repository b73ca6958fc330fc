"""The error of both effects against brute force, beside that of simpler ways."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from bench.naive import gather_disc, gather_streak
from bench.table import Result
from bench.walk import REFRESH_HZ, SCENES, pairs
from vrcomfort.headset.base import Frame
from vrcomfort.optics.circle_of_confusion import max_radius_px, signed_radius_px
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.render.gltf import load_scene
from vrcomfort.render.image_error import Accuracy, accuracy, pixels_per_degree
from vrcomfort.render.pipeline import EyeImages, StereoRenderer
from vrcomfort.render.reference import Reference, read_rgb
from vrcomfort.render.scene_data import Scene

SIZE_PX = (160, 200)
VIEWS = 2
MARGIN_PX = 20
SUN = 8.0
UNSURE = 0.25
FOCUS_M = 1.5
LENS = DepthOfField(law="dioptre", max_radius_percent=3.5, full_blur_dioptre=1.0)
SHUTTER = MotionBlur(mode="full", shutter_fraction=1.0, max_radius_percent=20.0)

Pixels = NDArray[np.float32]
Pixels64 = NDArray[np.float64]


class Shot(NamedTuple):
    """One eye's image: sharp, blurred by us, and what else a blur may read."""

    sharp: Pixels
    blurred: Pixels
    depth: Pixels
    velocity: Pixels | None
    images: EyeImages


def measure(ctx: moderngl.Context, *, samples: int) -> Result:
    """Compare every method with the reference, on both scenes and in both effects."""
    focus = Focus(method="fixed", fixed_m=FOCUS_M)
    conditions = [
        Condition(name="depth_of_field", focus=focus, depth_of_field=LENS),
        Condition(name="motion_blur", motion_blur=SHUTTER),
    ]
    rows = [
        row
        for name in SCENES
        for condition in conditions
        for row in _rows(ctx, load_scene(name), condition, samples)
    ]
    notes = [
        f"{SIZE_PX[0]}×{SIZE_PX[1]} px, left eye, {VIEWS} views of the shipped walk (each the "
        "fastest of its part), linear HDR times the scene's exposure; PSNR with peak 1, HDR-FLIP "
        f"at the view's pixels per degree. A margin of {MARGIN_PX} px is left out: what blurs in "
        "from outside the image is in no method's input; so is the sun's disc, smaller "
        f"than a pixel: pixels above {SUN:g}, or whose two halves differ by more than {UNSURE:g}.",
        f"Reference: {samples} samples, the scene drawn again for each. Its own error is half the "
        "difference of two independent halves; it counts where that is at most a tenth of the "
        "method's.",
        f"Lens: law dioptre (exact in the reference), focus {FOCUS_M} m, r_max "
        f"{LENS.max_radius_percent} % of the width at {LENS.full_blur_dioptre} D. Shutter: fully "
        f"open, mode {SHUTTER.mode}.",
        "`naive` is a gather of 12 taps over the pixel's own disc (or 8 along its own streak) "
        "without regard to who hides whom.",
    ]
    return Result("Error against the reference", rows, notes)


def _rows(
    ctx: moderngl.Context, scene: Scene, condition: Condition, samples: int
) -> list[dict[str, Any]]:
    reference = Reference(ctx, scene, condition, SIZE_PX, samples=samples)
    found: dict[str, list[Accuracy]] = {}
    for before, frame in pairs(scene, SIZE_PX, VIEWS):
        shot = shoot(ctx, scene, condition, before, frame)
        truth = reference.render(
            shot.images.camera, _time_s(frame), shot.images.previous, focus_m=FOCUS_M
        )
        for name, method in _methods(condition).items():
            found.setdefault(name, []).append(errors(scene, shot, method(shot), truth.halves))
    return [_row(scene, condition, name, errors) for name, errors in found.items()]


def errors(scene: Scene, shot: Shot, image: Pixels, halves: tuple[Pixels64, Pixels64]) -> Accuracy:
    """Return the errors of an image, without the margin and the sun's disc."""
    exposure = scene.environment.exposure
    bright, apart = np.maximum(*halves) * exposure, np.abs(halves[0] - halves[1]) * exposure
    sun = np.any((bright > SUN) | (apart > UNSURE), axis=-1, keepdims=True)
    inside = slice(MARGIN_PX, -MARGIN_PX)
    test, first, second = (
        np.where(sun, 0.0, pixels)[inside, inside] for pixels in (image, *halves)
    )
    return accuracy(
        test,
        (first, second),
        pixels_per_degree=pixels_per_degree(shot.images.camera.fov, SIZE_PX),
        exposure=exposure,
    )


def _row(scene: Scene, condition: Condition, method: str, errors: list[Accuracy]) -> dict[str, Any]:
    mean_square = float(np.mean([e.rms**2 for e in errors]))
    own = math.sqrt(float(np.mean([e.reference_rms**2 for e in errors])))
    return {
        "scene": scene.name,
        "effect": condition.name,
        "method": method,
        "PSNR dB": -10 * math.log10(mean_square),
        "FLIP": float(np.mean([e.flip for e in errors])),
        "RMS": math.sqrt(mean_square),
        "reference RMS": own,
        "reference FLIP": float(np.mean([e.reference_flip for e in errors])) / 2,
        "counts": own <= 0.1 * math.sqrt(mean_square),
    }


def _methods(condition: Condition) -> dict[str, Callable[[Shot], Pixels]]:
    naive = _naive_lens if condition.depth_of_field else _naive_shutter
    return {"ours": lambda s: s.blurred, "naive": naive, "no blur": lambda s: s.sharp}


def _naive_lens(shot: Shot) -> Pixels:
    limit_px = max_radius_px(LENS.max_radius_percent, SIZE_PX[0])
    radius = signed_radius_px(
        shot.depth,
        law=LENS.law,
        focus_m=FOCUS_M,
        near_m=shot.images.camera.near_m,
        radius_limit_px=limit_px,
        full_blur=LENS.full_blur_dioptre,
    )
    return gather_disc(shot.sharp, radius)


def _naive_shutter(shot: Shot) -> Pixels:
    if shot.velocity is None:
        return shot.sharp
    return gather_streak(shot.sharp, shot.velocity * SHUTTER.shutter_fraction)


def _time_s(frame: Frame) -> float:
    return frame.index / REFRESH_HZ


def shoot(
    ctx: moderngl.Context, scene: Scene, condition: Condition, before: Frame, frame: Frame
) -> Shot:
    """Return the left eye's images of a frame that follows another."""
    shots: list[Shot] = []

    def keep(eye: int, images: EyeImages) -> None:
        if eye == 0:
            shots.append(_shot(images))

    renderer = StereoRenderer(ctx, SIZE_PX)
    renderer.begin(scene, condition)
    renderer.render(before, _time_s(frame) - 1 / REFRESH_HZ)
    renderer.render(frame, _time_s(frame), keep)
    return shots[0]


def _shot(images: EyeImages) -> Shot:
    width, height = SIZE_PX
    velocity = None
    if images.velocity is not None:
        halves = np.frombuffer(images.velocity.read(), np.float16)
        velocity = halves.reshape(height, width, 2).astype(np.float32)
    depth = np.frombuffer(images.depth.read(), np.float32).reshape(height, width)
    return Shot(read_rgb(images.pinhole), read_rgb(images.linear), depth, velocity, images)
