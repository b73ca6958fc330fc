"""Savings and error of drawing at half size where all is blurred; it is not done."""

from __future__ import annotations

import time
from typing import Any

import moderngl
import numpy as np
from scipy.ndimage import map_coordinates

from bench.table import Result
from vrcomfort.geometry import Array
from vrcomfort.optics.tone import tone_mapped
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.data import Scene
from vrcomfort.scene.load import load_scene
from vrcomfort.tradeoff.image_error import rms
from vrcomfort.tradeoff.walk import REFRESH_HZ, SCENES, pairs

SIZE_PX = (640, 800)
LEVELS = (1, 2, 3)
PLAIN = Condition(name="plain")


def measure(ctx: moderngl.Context, *, rounds: int) -> Result:
    """Draw the same frames at full and at half size, in turn, and compare MIP levels."""
    rows = [row for name in SCENES for row in _rows(ctx, load_scene(name), rounds)]
    notes = [
        f"{SIZE_PX[0]}×{SIZE_PX[1]} per eye and half of it, {rounds} frames of the walk, CPU time "
        "of the whole process for a plain stereo frame. Error: RMS in display values, left eye, "
        "of a level from the image at half size, against the same level from the whole image; "
        "`blur` is the RMS by which that level differs from the sharp image.",
        "A second set of images for half the size takes a quarter of the memory of the first.",
        f"Renderer: {ctx.info['GL_RENDERER']}.",
    ]
    return Result("Drawing smaller", rows, notes)


def _rows(ctx: moderngl.Context, scene: Scene, rounds: int) -> list[dict[str, Any]]:
    half_px = (SIZE_PX[0] // 2, SIZE_PX[1] // 2)
    drawn = [_drawn(ctx, scene, size_px, rounds) for size_px in (SIZE_PX, half_px)]
    (whole_s, whole), (half_s, half) = drawn
    exposure = scene.environment.exposure
    rows = []
    for level in LEVELS:
        full = [_blown_up(image, 2**level, 2**level) for image in whole]
        small = [_blown_up(image, 2 ** (level - 1), 2**level) for image in half]
        shown, other, sharp = (
            tone_mapped(np.stack(images), exposure=exposure) for images in (full, small, whole)
        )
        rows.append(
            {
                "scene": scene.name,
                "level": level,
                "half / whole": float(np.median(np.array(half_s) / np.array(whole_s))),
                "error": rms(_rows_of(other), _rows_of(shown)),
                "blur": rms(_rows_of(shown), _rows_of(sharp)),
            }
        )
    return rows


def _drawn(
    ctx: moderngl.Context, scene: Scene, size_px: tuple[int, int], rounds: int
) -> tuple[list[float], list[Array]]:
    """Return the CPU seconds of each frame, and the left eye's (h, w, 3) radiance."""
    renderer = StereoRenderer(ctx, size_px)
    renderer.begin(scene, PLAIN)
    seconds, images = [], []

    def keep(eye: int, found: Any) -> None:
        if eye == 0:
            images.append(np.asarray(read_texture(found.pinhole)[..., :3], dtype=np.float64))

    for _, frame in pairs(scene, size_px, rounds):
        renderer.render(frame, frame.index / REFRESH_HZ)
        ctx.finish()
        start_s = time.process_time()
        renderer.render(frame, (frame.index + 1) / REFRESH_HZ)
        ctx.finish()
        seconds.append(time.process_time() - start_s)
        renderer.render(frame, (frame.index + 1) / REFRESH_HZ, keep)
    renderer.release()
    return seconds, images


def _blown_up(image: Array, side: int, scale: int) -> Array:
    """Return means of squares of `side` pixels, each bilinearly `scale` pixels wide."""
    height, width = (size // side for size in image.shape[:2])
    texels = image.reshape(height, side, width, side, 3).mean(axis=(1, 3))
    rows, columns = ((np.arange(count * scale) + 0.5) / scale - 0.5 for count in (height, width))
    places = np.meshgrid(rows, columns, indexing="ij")
    parts = [map_coordinates(texels[..., c], places, order=1, mode="nearest") for c in range(3)]
    return np.stack(parts, axis=-1)


def _rows_of(images: Array) -> Array:
    """Return several images below each other."""
    return images.reshape(-1, *images.shape[2:])
