"""What comes of the autofocus zone: the twins of ``focus_zone.frag`` and of halving.

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


def zone_focus_m(reduced: ArrayLike, near_m: float, settings: ZoneSettings) -> float:
    """Return the focus distance from the (2,) numbers of `reduced`, or sums in place of means.

    Means over a zone that zeros have made larger have one factor too many, and it cancels: any
    size of zone is exact.
    """
    x, y = np.asarray(reduced, dtype=np.float64).tolist()
    if settings.zone_statistic != "mean":
        return near_m / x
    return y / x if settings.mean == "dioptres" else settings.infinity_m * (x / y)
