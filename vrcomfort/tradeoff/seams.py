"""What eyes find at once, however small its mean: hairlines, beads, stairs; and what flickers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter, median_filter, minimum_filter

from vrcomfort.geometry import Array
from vrcomfort.render.image_error import LUMINANCE

HIGH_PASS_PX = 1.0
"""Standard deviation of the Gaussian that is taken away: what is left is finer than blur."""

WIDE_PX, WIDE_SIDE_PX = 10.0, 41
"""Where the radius is above the first over a square of the second, nothing fine can be right."""

MEDIAN_SIDE_PX = 5
STEP = 1 / 255
"""Of a display."""


class OffMedian(NamedTuple):
    """Pixels that stand out where everything is wide blur."""

    wide_px: int
    """How many pixels were looked at."""
    over_2: int
    """Off the median around them by more than 2/255."""
    over_4: int


def high_pass(error: ArrayLike) -> Array:
    """Return an (h, w, 3) error less its Gaussian mean: lines and beads, not soft errors."""
    image = np.asarray(error, dtype=np.float64)
    soft: Array = gaussian_filter(image, (HIGH_PASS_PX, HIGH_PASS_PX, 0))
    return image - soft


def off_median(
    shown: NDArray[np.floating],
    radius_px: NDArray[np.floating],
    judged: tuple[slice, slice] = (slice(None), slice(None)),
) -> OffMedian:
    """Count pixels of an (h, w, 3) image of display values in [0, 1] that are off their median.

    In luminance, against the median of the 5×5 pixels around, where the radius is above
    :data:`WIDE_PX` over 41×41 pixels: no such blur has anything so fine.

    Parameters
    ----------
    judged
        Slices of rows and columns in which pixels are counted; what lies around is looked at only.
    """
    wide = minimum_filter(np.abs(radius_px), WIDE_SIDE_PX, mode="nearest")[judged] > WIDE_PX
    light = np.asarray(shown, dtype=np.float32) @ LUMINANCE.astype(np.float32)
    off = np.abs(light - median_filter(light, MEDIAN_SIDE_PX))[judged][wide]
    return OffMedian(int(wide.sum()), int((off > 2 * STEP).sum()), int((off > 4 * STEP).sum()))


def flicker(before: ArrayLike, after: ArrayLike) -> Array:
    """Return how an (h, w, 3) error changes from a frame to the next: what does not move with it.

    An error that stays the same is a wrong picture; one that changes is seen to flicker.
    """
    changed: Array = np.asarray(after, dtype=np.float64) - np.asarray(before, dtype=np.float64)
    return changed
