"""Focus that follows a script: distances at times, and what is between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def scripted_focus_m(
    script: Sequence[tuple[float, float]], time_s: float, every_s: float | None = None
) -> float:
    """Return the focus distance at a time.

    Parameters
    ----------
    script
        (seconds, metres), times rising. Between two entries focus moves linearly in dioptres, as
        an eye's accommodation is measured; before the first and after the last it rests.
    every_s
        The script begins again so often; None never.
    """
    at_s = time_s if every_s is None else time_s % every_s
    times_s, distances_m = np.array(script, dtype=np.float64).T
    return float(1 / np.interp(at_s, times_s, 1 / distances_m))
