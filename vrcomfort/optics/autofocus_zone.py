"""Focus by a zone in the middle of the image, where people look: a weighted mean of its distances.

What `zone_mean_on = "cpu"` computes: the twin of ``shaders/focus/focus_weights.frag``. Source:
Hillaire et al. 2008, Eq. 2 and 3.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array


class ZoneSettings(Protocol):
    """The settings used here; `protocol.conditions.Focus` has them."""

    @property
    def mean(self) -> str:
        """Return the space of the mean: `metres` (the paper's) or `dioptres`."""

    @property
    def semantic_min(self) -> float:
        """Return W_S,min."""

    @property
    def semantic_max(self) -> float:
        """Return W_S,max."""

    @property
    def gauss_centre(self) -> float:
        """Return W_G,max."""

    @property
    def gauss_border(self) -> float:
        """Return W_G,min."""

    @property
    def infinity_m(self) -> float:
        """Return the distance taken for the sky."""


def gauss_weights(size_px: tuple[int, int], settings: ZoneSettings) -> Array:
    """Return (h, w) W_G: `gauss_centre` in the middle, `gauss_border` all along the border.

    A Gaussian of the distance from the middle in half sides, which has the least weight in the
    middle of each side and would fall on in the corners; there it stays.
    """
    width, height = size_px
    x = (2 * np.arange(width) + 1) / width - 1
    y = (2 * np.arange(height) + 1) / height - 1
    square = x[None, :] ** 2 + y[:, None] ** 2
    fall = settings.gauss_border / settings.gauss_centre
    return np.maximum(settings.gauss_centre * fall**square, settings.gauss_border)


def weighted(
    depth: ArrayLike, semantic_weight: ArrayLike, near_m: float, settings: ZoneSettings, /
) -> Array:
    """Return (h, w, 2): weight times value, and weight, of each pixel of the zone.

    Parameters
    ----------
    depth
        (h, w) ``near_m / distance``, 0 for the sky.
    semantic_weight
        (h, w) of what is seen there, clipped to the settings' limits.

    Notes
    -----
    The value is the distance in units of `infinity_m`, at most 1, so that no sum or mean can
    overflow; with the mean in dioptres it is one over the distance.
    """
    z = np.maximum(np.asarray(depth, dtype=np.float64), near_m / settings.infinity_m)
    value = z / near_m if settings.mean == "dioptres" else near_m / z / settings.infinity_m
    semantic = np.clip(semantic_weight, settings.semantic_min, settings.semantic_max)
    height, width = z.shape
    weight = semantic * gauss_weights((width, height), settings)
    return np.stack([weight * value, weight], axis=-1)
