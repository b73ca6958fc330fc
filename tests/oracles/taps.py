"""How wide patterns of few reads are, and how far half an image fades in.

NumPy twins, in float64, of ``gather_taps.frag`` and ``crossfade_half_resolution.frag``
(``shaders/depth_of_field``). Radii are in pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array
from vrcomfort.optics.taps import Spread


def extent_px(radius_px: ArrayLike, law: Spread, /) -> Array:
    """Return the (...,) radius of the pattern for discs of these radii (``gather_taps.frag``)."""
    squared = np.square(np.asarray(radius_px, dtype=np.float64))
    far = np.sqrt(np.maximum(squared - law.far_px2, 0.0))
    near = np.minimum(np.maximum(squared - law.near_px2, 0.0) * law.per_px, law.near_px)
    extent: Array = np.maximum(far, near)
    return extent


def fade(radius_px: ArrayLike, /) -> Array:
    """Return the (...,) opacity of half an image, blown up, over the image.

    ``crossfade_half_resolution.frag``: from 0.5 px, which change nothing, linear in
    the variance up to a disc of 2 px: that is how blurred half an image is (`optics.pyramid`).
    """
    squared = np.square(np.asarray(radius_px, dtype=np.float64))
    return np.clip((squared - 0.25) / (4.0 - 0.25), 0.0, 1.0)
