"""Adjustment of p values within a declared family."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.stats.packages import pingouin, quiet

if TYPE_CHECKING:
    from collections.abc import Sequence


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
