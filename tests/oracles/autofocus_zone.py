"""Means over the autofocus zone: the twins of ``focus_zone.frag`` and of halving.

NumPy, float64. Source: Hillaire et al. 2008, Eq. 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array
from vrcomfort.optics.autofocus_zone import ZoneSettings


def halved(image: Array) -> Array:
    """Return an (h, w, n) image down-sampled by two: means of 2 × 2, zeros beyond an odd edge."""
    height, width, _ = image.shape
    even = np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)))
    quarters: Array = (even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]) / 4
    return quarters


def zone_focus_m(sums: ArrayLike, settings: ZoneSettings) -> float:
    """Return the focus distance from (2,) means (or sums) of `weighted`.

    Means over a zone that zeros have made larger have one factor too many, and it cancels: any
    size of zone is exact.
    """
    values, weights = np.asarray(sums, dtype=np.float64)
    mean = float(values / weights)
    return 1 / mean if settings.mean == "dioptres" else settings.infinity_m * mean
