"""Focus by a zone in the middle of the image, where people look: a statistic of its distances.

The computation of `zone_mean_on = "cpu"`, and the twin of ``shaders/focus/focus_weights.frag``,
``focus_candidates.frag``, ``focus_extreme.frag`` and ``include/zone_depth.glsl``. Source: Hillaire
et al. 2008, Eq. 2 and 3.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array


class ZoneSettings(Protocol):
    """The settings used here; `protocol.conditions.Focus` has them."""

    @property
    def zone_statistic(self) -> str:
        """Return which statistic it is: `mean`, `minimum` or `maximum`."""

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


def kept_within(
    centre: tuple[float, float], screen: tuple[float, float], ratio: float
) -> tuple[float, float]:
    """Return the middle of a zone, moved so that all of the zone is in the image.

    Parameters
    ----------
    centre
        Tangents (right, up) of where the middle is to be.
    screen
        Half width and half height of the image as tangents.
    ratio
        The zone's sides over the image's.
    """
    (x, y), (width, height) = centre, screen
    reach_x, reach_y = width * (1 - ratio), height * (1 - ratio)
    return max(-reach_x, min(x, reach_x)), max(-reach_y, min(y, reach_y))


def halvings(size_px: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the sizes from a zone to one texel: each half of the one before, rounded up."""
    sizes = [size_px]
    while sizes[-1] != (1, 1):
        width, height = sizes[-1]
        sizes.append(((width + 1) // 2, (height + 1) // 2))
    return sizes


def _half_sides(size_px: tuple[int, int]) -> tuple[Array, Array]:
    """Return (1, w) and (h, 1) places of the pixels' middles, −1 to 1."""
    x, y = ((2 * np.arange(side) + 1) / side - 1 for side in size_px)
    return x[None, :], y[:, None]


def gauss_weights(size_px: tuple[int, int], settings: ZoneSettings) -> Array:
    """Return (h, w) W_G: `gauss_centre` in the middle, `gauss_border` all along the border.

    A Gaussian of the distance from the middle in half sides, which has the least weight in the
    middle of each side and would fall on in the corners; there it stays.
    """
    x, y = _half_sides(size_px)
    fall = settings.gauss_border / settings.gauss_centre
    return np.maximum(settings.gauss_centre * fall ** (x**2 + y**2), settings.gauss_border)


def zone_depth(
    depth: ArrayLike,
    near_m: float,
    settings: ZoneSettings,
    /,
    half_tangents: tuple[float, float] | None = None,
    centre: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """Return (h, w) ``near_m / distance``, at least that of `infinity_m`.

    Parameters
    ----------
    depth
        (h, w) ``near_m / distance`` along the head's forward axis, 0 for the sky.
    half_tangents
        Half width and half height of the zone, where distances are those along each pixel's ray.
    centre
        Tangents (right, up) of the zone's middle from the head's forward axis.
    """
    z = np.asarray(depth, dtype=np.float64)
    if half_tangents is not None:
        x, y = _half_sides((z.shape[1], z.shape[0]))
        right, up = centre[0] + x * half_tangents[0], centre[1] + y * half_tangents[1]
        z = z / np.sqrt(1 + right**2 + up**2)
    return np.maximum(z, near_m / settings.infinity_m)


def reduced(
    depth: ArrayLike,
    semantic_weight: ArrayLike,
    near_m: float,
    settings: ZoneSettings,
    /,
    half_tangents: tuple[float, float] | None = None,
    centre: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """Return the (2,) numbers from which ``focus_zone.frag`` takes the focus.

    Means of weight times value and of weight; or, for an extreme, ``near_m / distance`` of what
    has it, and 1 where it is among those that weigh more than the least.

    Parameters
    ----------
    depth, half_tangents, centre
        Those of :func:`zone_depth`.
    semantic_weight
        (h, w) of the visible surfaces.
    """
    z = zone_depth(depth, near_m, settings, half_tangents, centre)
    if settings.zone_statistic == "mean":
        mean: Array = weighted(z, semantic_weight, near_m, settings).mean(axis=(0, 1))
        return mean
    first = outweighs(semantic_weight, settings)
    among = z[first] if first.any() else z
    found = among.max() if settings.zone_statistic == "minimum" else among.min()
    return np.array([found, float(first.any())])


def weighted(
    depth: Array, semantic_weight: ArrayLike, near_m: float, settings: ZoneSettings, /
) -> Array:
    """Return (h, w, 2): weight times value, and weight, of each pixel of the zone.

    Parameters
    ----------
    depth
        (h, w) of :func:`zone_depth`.
    semantic_weight
        (h, w) of the visible surfaces, clipped to the settings' limits.

    Notes
    -----
    The value is the distance in units of `infinity_m`, at most 1, so that no sum or mean can
    overflow; with the mean in dioptres it is one over the distance.
    """
    dioptres = settings.mean == "dioptres"
    value = depth / near_m if dioptres else near_m / depth / settings.infinity_m
    semantic = np.clip(semantic_weight, settings.semantic_min, settings.semantic_max)
    height, width = depth.shape
    weight = semantic * gauss_weights((width, height), settings)
    return np.stack([weight * value, weight], axis=-1)


def outweighs(semantic_weight: ArrayLike, settings: ZoneSettings) -> NDArray[np.bool_]:
    """Return (h, w) bool: weights above the least, compared in single precision."""
    least, most = np.float32(settings.semantic_min), np.float32(settings.semantic_max)
    return np.minimum(np.asarray(semantic_weight, dtype=np.float32), most) > least
