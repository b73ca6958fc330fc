"""What a simple post-process would do: taps over a pixel's own blur, whoever hides whom."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.float32]
GOLDEN_ANGLE_RAD = np.pi * (3 - np.sqrt(5))


def gather_disc(image: Pixels, radius_px: NDArray[np.float64], taps: int = 12) -> Pixels:
    """Average (h, w, 3) pixels over `taps` of a spiral in each pixel's own disc."""
    index = np.arange(taps) + 0.5
    angle, reach = index * GOLDEN_ANGLE_RAD, np.sqrt(index / taps)
    offsets = np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=-1)
    radius = np.abs(radius_px)[..., None]
    return _mean([_shifted(image, radius * offset) for offset in offsets])


def gather_streak(image: Pixels, streak_px: Pixels, taps: int = 8) -> Pixels:
    """Average (h, w, 3) pixels over `taps` along each pixel's own (h, w, 2) streak."""
    steps = (np.arange(taps) + 0.5) / taps - 0.5
    return _mean([_shifted(image, streak_px * step) for step in steps])


def _shifted(image: Pixels, offset_px: NDArray[np.floating]) -> Pixels:
    height, width, _ = image.shape
    y, x = np.mgrid[:height, :width]
    column = np.clip(np.rint(x + offset_px[..., 0]), 0, width - 1).astype(int)
    row = np.clip(np.rint(y + offset_px[..., 1]), 0, height - 1).astype(int)
    shifted: Pixels = image[row, column]
    return shifted


def _mean(images: list[Pixels]) -> Pixels:
    mean: Pixels = np.mean(images, axis=0)
    return mean
