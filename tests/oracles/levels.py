"""Which part of a disc a level draws: NumPy twin of ``shaders/include/levels.glsl``."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array
from vrcomfort.optics.blur_kernels import CROSS_FADE_FROM, WIDER, exact_px


def level_part(level: int, radius_px: ArrayLike, *, samples: int, count: int) -> Array:
    """Return the part of discs of these radii that is drawn on one of `count` levels."""
    radius = np.asarray(radius_px, dtype=np.float64)
    finer = _coarser_part(level - 1, radius, samples, count) if level else np.ones_like(radius)
    return finer - _coarser_part(level, radius, samples, count)


def _coarser_part(level: int, radius_px: Array, samples: int, count: int) -> Array:
    if level >= count - 1:
        return np.zeros_like(radius_px)
    filled = radius_px / (exact_px(samples) * (WIDER * 2**level if level else 1))
    part: Array = np.clip((filled - CROSS_FADE_FROM) / (1 - CROSS_FADE_FROM), 0.0, 1.0)
    return part
