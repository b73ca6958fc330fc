"""Sphericity of repeated measures: Mauchly's test and the two epsilon corrections."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Sphericity:
    """How far the covariance of the contrasts is from spherical."""

    mauchly_w: float | None
    """None where the error covariance is singular (too few participants)."""
    mauchly_p: float | None
    greenhouse_geisser: float
    huynh_feldt: float
    """Capped at 1."""


def sphericity(error: NDArray[np.float64], df_error: int) -> Sphericity:
    """Describe the error matrix of a within effect.

    Parameters
    ----------
    error
        Sums of squares and products of the orthonormal contrasts, shape (p, p), p >= 2.
    df_error
        Its degrees of freedom (participants minus groups).
    """
    p = error.shape[0]
    trace = float(np.trace(error))
    if trace <= 0:
        return Sphericity(None, None, 1.0, 1.0)
    gg = trace**2 / (p * float(np.sum(error**2)))
    mauchly_w = mauchly_p = None
    if df_error >= p:
        mauchly_w = max(float(np.linalg.det(error / (trace / p))), 0.0)
        mauchly_p = _mauchly_p(mauchly_w, p, df_error)
    return Sphericity(mauchly_w, mauchly_p, gg, _huynh_feldt(gg, p, df_error))


def _huynh_feldt(gg: float, p: int, df_error: int) -> float:
    """Huynh & Feldt (1976) with Lecoutre's (1991) correction for groups."""
    denominator = p * (df_error - p * gg)
    if denominator <= 0:
        return 1.0
    return min(1.0, ((df_error + 1) * p * gg - 2) / denominator)


def _mauchly_p(w: float, p: int, df_error: int) -> float:
    """Second-order chi-square approximation (Anderson 2003, section 10.7)."""
    if w <= 0:
        return 0.0
    rho = 1 - (2 * p**2 + p + 2) / (6 * p * df_error)
    order_2 = (p + 2) * (p - 1) * (p - 2) * (2 * p**3 + 6 * p**2 + 3 * p + 2)
    omega = order_2 / (288 * (df_error * p * rho) ** 2)
    statistic = -df_error * rho * np.log(w)
    df = p * (p + 1) / 2 - 1
    first, second = chdtrc(df, statistic), chdtrc(df + 4, statistic)
    return float(np.clip(first + omega * (second - first), 0, 1))
