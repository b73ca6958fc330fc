"""Errors by region of what is seen, and beside far edges what is finer than blur."""

from __future__ import annotations

import math

import numpy as np

from vrcomfort.geometry import Array
from vrcomfort.tradeoff.regions import REGIONS, Mask
from vrcomfort.tradeoff.seams import high_pass


def region_errors(error: Array, masks: dict[str, Mask], known: Mask) -> dict[str, float | None]:
    """Return the RMS of an (h, w, 3) error in each region, and how many pixels that is.

    Parameters
    ----------
    masks
        (h, w) by name, those of :data:`regions.REGIONS`.
    known
        (h, w): where the reference is sure; the others do not count.
    """
    found: dict[str, float | None] = {}
    for name in REGIONS:
        counted = masks[name] & known
        found[f"{name}_rms"] = _rms(error[counted])
        found[f"{name}_px"] = int(counted.sum())
    found["seams"] = _rms(high_pass(error)[masks["far_edges"] & known])
    return found


def _rms(values: Array) -> float | None:
    return math.sqrt(float(np.mean(values**2))) if len(values) else None
