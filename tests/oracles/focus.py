"""One focus distance from nine rays: NumPy twins, in float64, of ``shaders/focus/focus.frag``.

Distances are metres along the head's forward axis. Sources: Carnegie & Rhee 2015, p. 36; Mantiuk
et al. 2011, section 4. What their print leaves open is named at each function.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array
from vrcomfort.optics.focus import RAYS, ray_tangents

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
    def infinity_m(self) -> float:
        """Return the distance taken for the sky."""


def ray_directions(ring_deg: float) -> Array:
    """Return (9, 3) ray directions in the head's frame with unit depth: ``(right, up, -1)``.

    Their length is metres along the ray per metre along the head's forward axis.
    """
    tangents = ray_tangents(ring_deg)
    return np.concatenate([tangents, np.full((RAYS, 1), -1.0)], axis=1)


def gaze_focus(distances_m: ArrayLike, infinity_m: float, /) -> tuple[float, NDArray[np.bool_]]:
    """Return the median of nine distances around a line of sight, and the rays that have it.

    What covers most of the neighbourhood decides, wherever the nine rays fall on its rim: no
    distance between two things is ever focused, as the mean of both would be.
    """
    metres = np.minimum(np.asarray(distances_m, dtype=np.float64), infinity_m)
    median = float(np.median(metres))
    return median, metres == median


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
