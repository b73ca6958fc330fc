"""A Gaussian blur: NumPy twin, in float64, of ``shaders/speed_blur/gaussian.frag``."""

from __future__ import annotations

from math import ceil

import numpy as np

from vrcomfort.geometry import Array

REACH = 3.0
"""Taps reach this many standard deviations to each side; 0.3 % of the weight lies beyond."""


def gaussian_weights(sigma_px: float, /) -> Array:
    """Return (2n + 1,) weights of neighbouring pixels with n = ceil(3 sigma); their sum is 1."""
    reach = ceil(REACH * sigma_px)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / max(sigma_px, 1e-9)) ** 2)
    normalised: Array = weights / weights.sum()
    return normalised
