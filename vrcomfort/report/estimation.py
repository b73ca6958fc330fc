"""The parts of estimation plots: people, means, differences with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.report.canvas import (
    FAINT,
    INK,
    PAPER,
    SOFT,
    dots,
    spread,
    threads,
)
from vrcomfort.report.palette import colour_of, marker_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vrcomfort.report.vocabulary import Vocabulary

    Floats = NDArray[np.float64]

MOST_DRAWN = 1000
"""People who are drawn; of more, as many evenly spaced ones. Means and tests are of everybody."""
CROWD = 60
"""People from whom on dots and lines are drawn thin."""


def thinned(values: Floats) -> Floats:
    """Return evenly spaced rows, the first and the last among them, where there are too many."""
    if len(values) <= MOST_DRAWN:
        return values
    chosen: Floats = values[np.linspace(0, len(values) - 1, MOST_DRAWN).round().astype(int)]
    return chosen


def dot_size(people: int, size: float = 4.0) -> float:
    """Return the size of a dot, in points: smaller in a crowd."""
    return 2.2 if people > CROWD else size


def draw_people(axes: Axes, places: Floats, scores: Floats) -> None:
    """Join the scores of each person (people × places) by a line."""
    crowded = len(scores) > CROWD
    threads(axes, places, thinned(scores), color=FAINT, lw=0.5 if crowded else 0.8,
            alpha=0.25 if crowded else 0.7, zorder=1)  # fmt: skip


def draw_side(axes: Axes, at: float, values: Floats, look: int, half: float) -> None:
    """Draw the scores of a side within `at` ± `half`; beside them their mean with its SD.

    Parameters
    ----------
    look
        Place of the condition in the order of all, which gives its colour and its shape.
    """
    colour = colour_of(look)
    across = at + spread(len(values), half)
    dots(axes, thinned(across), thinned(values), colour, size=dot_size(len(values)), alpha=0.55,
         zorder=2)  # fmt: skip
    deviation = values.std(ddof=1) if len(values) > 1 else 0.0
    axes.errorbar(at + 0.2, values.mean(), deviation, fmt=marker_of(look), color=colour, ms=6,
                  lw=1.6, mec=PAPER, mew=0.8, zorder=5)  # fmt: skip


def draw_difference(axes: Axes, at: float, estimate: float | None, low: float, high: float) -> None:
    """Draw a difference upright with its interval; an estimate of None, or a NaN, is not drawn."""
    axes.plot((at, at), (low, high), "-", color=INK, lw=2.2, zorder=4)
    if estimate is not None:
        axes.plot(at, estimate, "D", color=INK, ms=6, mec=PAPER, mew=0.8, zorder=5)


def draw_zero(axes: Axes, *, upright: bool = False) -> None:
    """Draw the dashed line of no difference."""
    line = axes.axvline if upright else axes.axhline
    line(0, color=SOFT, lw=0.8, ls=(0, (4, 3)), zorder=0)


def difference_label(outcome: str, words: Vocabulary) -> str:
    """Return the label of an axis with differences of an outcome."""
    unit = words.unit(outcome)
    return f"difference ({unit})" if unit else "difference"
