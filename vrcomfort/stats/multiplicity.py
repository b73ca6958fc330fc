"""Adjustment of p values within a declared family."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.stats.packages import pingouin, quiet

if TYPE_CHECKING:
    from collections.abc import Sequence

    Levels = list[float | None]


def holm(p_values: Sequence[float | None]) -> list[float | None]:
    """Return Holm's step-down adjusted p values (Holm 1979), in the order given.

    A test that could not be made (None) stays None and does not count in the family. Computed by
    pingouin, which does so too with NaN.
    """
    p = np.array([np.nan if each is None else each for each in p_values], dtype=np.float64)
    if np.isfinite(p).sum() < 2:
        return list(p_values)
    with quiet():
        _, adjusted = pingouin().multicomp(p, method="holm")
    return [None if np.isnan(each) else float(each) for each in adjusted]


def holm_levels(p_values: Sequence[float | None], level: float = 0.05) -> Levels:
    """Return the level at which Holm's method decides on each test, in the order given.

    Of the i-th smallest of m values, while they are rejected, it is level / (m − i + 1); of the
    others it is level over their number. So a test's p is at or below it exactly where its adjusted
    p is at or below `level`, and an interval of that level says of the null value what the adjusted
    p says. Equal values have one level.
    """
    there = sorted((p, place) for place, p in enumerate(p_values) if p is not None)
    found: Levels = [None] * len(p_values)
    own, before = level, None
    rejecting = True
    for done, (p, place) in enumerate(there):
        if rejecting and p != before:
            own = level / (len(there) - done)
            rejecting = p <= own
        found[place], before = own, p
    return found
