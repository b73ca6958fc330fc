"""Plots to judge assumptions by: normal quantiles, and residuals over what was fitted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

from vrcomfort.report.canvas import INK, SOFT, Drawing, canvas, dots, lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vrcomfort.report.residuals import Residuals
    from vrcomfort.report.vocabulary import Vocabulary

    Floats = NDArray[np.float64]

MOST_DOTS = 400
"""Dots of one plot; of more values, as many evenly spaced ones of the ordered are drawn."""
FEWEST = 3
MOST_TICKS = 5
"""Of an axis: the plots are small."""


def residual_figure(found: list[Residuals], words: Vocabulary) -> Drawing | None:
    """Draw a row for each score: differences, residuals (both over normal quantiles), spread."""
    rows = [each for each in found if each.differences.size >= FEWEST or each.residuals.size]
    if not rows:
        return None
    with canvas("residuals", 7.0, 2.15 * len(rows) + 0.3) as (figure, drawing):
        grid = figure.subplots(len(rows), 3, squeeze=False)
        for axes in grid.flat:
            axes.locator_params(nbins=MOST_TICKS)
        for (quantiles, normal, over), each in zip(grid, rows, strict=True):
            _quantiles(quantiles, each.differences)
            _quantiles(normal, each.residuals)
            _over_fitted(over, each.fitted, each.residuals)
            quantiles.set_ylabel(f"{lines(words.outcome(each.outcome), 24)}\n(points)")
        for axes, title in zip(grid[0], _TITLES, strict=True):
            axes.set_title(title)
        for axes, label in zip(grid[-1], _ACROSS, strict=True):
            axes.set_xlabel(label)
    return drawing


_TITLES = ("differences in pairs", "residuals of the ANOVA", "residuals over fitted")
_ACROSS = ("normal quantile", "normal quantile", "fitted score (points)")


def _quantiles(axes: Axes, values: Floats) -> None:
    if values.size < FEWEST:
        _nothing(axes)
        return
    ordered = np.sort(values)
    across = norm.ppf((np.arange(1, values.size + 1) - 0.375) / (values.size + 0.25))  # Blom 1958
    chosen = _thinned(values.size)
    dots(axes, across[chosen], ordered[chosen], INK, size=3.2, alpha=0.75)
    low, high = np.percentile(values, [25, 75])
    slope = (high - low) / (norm.ppf(0.75) - norm.ppf(0.25))
    ends = across[[0, -1]]
    axes.plot(ends, (low + high) / 2 + slope * ends, "-", color=SOFT, lw=0.9, zorder=0)


def _over_fitted(axes: Axes, fitted: Floats, residuals: Floats) -> None:
    if residuals.size < FEWEST:
        _nothing(axes)
        return
    chosen = np.argsort(fitted, kind="stable")[_thinned(fitted.size)]
    dots(axes, fitted[chosen], residuals[chosen], INK, size=3.2, alpha=0.75)
    if np.ptp(fitted) == 0:  # else the axis would show the length of a dot
        axes.set_xlim(fitted[0] - 1, fitted[0] + 1)
    axes.axhline(0, color=SOFT, lw=0.9, zorder=0)


def _thinned(size: int) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, size - 1, min(size, MOST_DOTS)).round().astype(np.int64))


def _nothing(axes: Axes) -> None:
    axes.text(0.5, 0.5, "none", transform=axes.transAxes, ha="center", va="center", color=SOFT)
    axes.set_xticks([])
    axes.set_yticks([])
