"""Where the eye focuses: nine rays, one estimate, and the time it takes to get there.

NumPy twins of ``shaders/focus.frag``. Distances are metres along the head's forward axis.
Source: Carnegie & Rhee 2015, p. 36; what its print leaves open is named at each function.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array

RAYS = 9
MAD_TO_SIGMA = 1.4826
"""Standard deviation of a normal distribution with median absolute deviation 1."""


class FocusSettings(Protocol):
    """The settings used here; `protocol.conditions.Focus` has them."""

    @property
    def ring_deg(self) -> float:
        """Return the angle between the central ray and the others."""

    @property
    def mean(self) -> str:
        """Return the space of the mean and of the outlier rule: `metres` or `dioptres`."""

    @property
    def outlier_mad(self) -> float:
        """Return how many scaled median absolute deviations from the median are kept."""

    @property
    def outlier_floor_fraction(self) -> float:
        """Return the least distance from the median that drops a ray, as a share of it."""

    @property
    def outlier_floor_dioptre(self) -> float:
        """Return the same in dioptres, for the mean in dioptres."""

    @property
    def law(self) -> str:
        """Return how focus moves: `linear`, `linear_dioptre` or `instant`."""

    @property
    def refocus_s(self) -> float:
        """Return the time from `infinity_m` to near."""

    @property
    def infinity_m(self) -> float:
        """Return the distance taken for the sky."""


def ray_tangents(ring_deg: float) -> Array:
    """Return (9, 2) tangents (right, up) of the rays: the centre, then eight from the right.

    The ring runs to the left over the top, in steps of 45°. Each of its rays is `ring_deg` from
    the centre; the paper says "small regular angular deviations" and leaves the angle open.
    """
    around = np.arange(RAYS - 1) * (np.pi / 4)
    ring = np.tan(np.radians(ring_deg)) * np.stack([np.cos(around), np.sin(around)], axis=1)
    return np.concatenate([np.zeros((1, 2)), ring])


def ray_directions(ring_deg: float) -> Array:
    """Return (9, 3) ray directions in the head's frame with unit depth: ``(right, up, -1)``.

    Their length is metres along the ray per metre along the head's forward axis.
    """
    tangents = ray_tangents(ring_deg)
    return np.concatenate([tangents, np.full((RAYS, 1), -1.0)], axis=1)


def estimate_focus(
    distances_m: ArrayLike, settings: FocusSettings, /
) -> tuple[float, NDArray[np.bool_]]:
    """Return the mean distance of the rays that are no outliers, and which rays these are.

    Parameters
    ----------
    distances_m
        (9,) metres, inf for the sky, which counts as `infinity_m`.

    Returns
    -------
    The distance in metres, and (9,) bool.

    Notes
    -----
    The paper says "the average of these distances, less outliers" and gives no rule. Here a ray
    is dropped when it is further from the median than ``outlier_mad · 1.4826 · MAD`` and than the
    floor, in the space of the mean: metres (the paper's) or dioptres, where one ray to the sky
    weighs no more than any other.
    """
    metres = np.minimum(np.asarray(distances_m, dtype=np.float64), settings.infinity_m)
    dioptres = settings.mean == "dioptres"
    values = 1.0 / metres if dioptres else metres
    median = np.median(values)
    deviations = np.abs(values - median)
    floor = settings.outlier_floor_dioptre if dioptres else settings.outlier_floor_fraction * median
    limit = max(settings.outlier_mad * MAD_TO_SIGMA * float(np.median(deviations)), float(floor))
    used = deviations <= limit
    mean = float(values[used].mean())
    return (1.0 / mean if dioptres else mean), used


def refocus(current_m: float, target_m: float, dt_s: float, settings: FocusSettings, /) -> float:
    """Return the focus distance `dt_s` after it was `current_m`; it never passes `target_m`.

    Notes
    -----
    `linear` moves in metres, `infinity_m` in `refocus_s`: 60 km/s for the paper's 30 km in
    500 ms, 16.7 µs per metre (the printed 1.7 µs is a slip). Within a room that is instant.
    `linear_dioptre` moves 1 D in `refocus_s`: 2 D/s, from the sky to 1 m in 500 ms, which is what
    the physiology that the paper cites says. Both are exact at any frame time: two steps are the
    same as one of their summed length.
    """
    if settings.law == "instant":
        return target_m
    if settings.law == "linear":
        return _towards(current_m, target_m, settings.infinity_m / settings.refocus_s * dt_s)
    return 1.0 / _towards(1.0 / current_m, 1.0 / target_m, dt_s / settings.refocus_s)


def _towards(current: float, target: float, step: float) -> float:
    return (
        target if abs(target - current) <= step else current + np.copysign(step, target - current)
    )
