"""Residuals of the analysis of variance and differences in pairs, and the plots of both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

from vrcomfort.report.analyses.signed_rank.figure import differences
from vrcomfort.report.canvas import INK, SOFT, Drawing, canvas, dots, lines
from vrcomfort.report.exposures import with_scores
from vrcomfort.report.factors import is_between, level_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Residuals:
    """Residuals and differences of one score, in points.

    Parameters
    ----------
    fitted, residuals
        Shape (n,): of the model with participants and cells; empty where there are none.
    differences
        Differences of the first comparison, shape (pairs,).
    """

    outcome: str
    fitted: Floats
    residuals: Floats
    a: str
    b: str
    differences: Floats


def residuals_of(
    scored: Exposures, plan: Plan, tests: Sequence[SignedRankRow], outcome: str
) -> Residuals:
    """Return the residuals of a score: without the means of participants and cells."""
    fitted, left = _of_cells(scored, plan, outcome)
    test = next((t for t in tests if t.outcome == outcome and t.found), None)
    if test is None:
        return Residuals(outcome, fitted, left, "", "", np.empty(0))
    return Residuals(outcome, fitted, left, test.a, test.b, differences(scored, test))


def residual_lines(found: Iterable[Residuals]) -> list[Cells]:
    """Return a line of CSV for each value that is drawn."""
    return [
        line
        for each in found
        for line in (
            *(
                {"outcome": each.outcome, "kind": "residual", "fitted": x, "value": y}
                for x, y in zip(each.fitted.tolist(), each.residuals.tolist(), strict=True)
            ),
            *(
                {"outcome": each.outcome, "kind": f"{each.a} minus {each.b}", "value": y}
                for y in each.differences.tolist()
            ),
        )
    ]


def _of_cells(scored: Exposures, plan: Plan, outcome: str) -> tuple[Floats, Floats]:
    table, unit = with_scores(scored.table, outcome), scored.units[outcome]
    within = [factor for factor in plan.anova if not is_between(factor)]
    levels = {factor.name: level_of(scored, table, factor) for factor in within}
    factors = {name: each for name, each in levels.items() if each.nunique() > 1}
    if not factors:
        return np.empty(0), np.empty(0)
    cells = table[["participant"]].assign(score=table[outcome], **factors)
    means = cells.groupby(["participant", *factors])["score"].mean().astype(float) * unit
    scores = means.unstack(list(factors)).dropna().to_numpy(dtype=float)
    if len(scores) < 2:
        return np.empty(0), np.empty(0)
    fitted = scores.mean(axis=0) + scores.mean(axis=1, keepdims=True) - scores.mean()
    return fitted.ravel(), (scores - fitted).ravel()


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
    with canvas("residuals", 7.0, 2.15 * len(rows) + 0.3, "residuals") as (figure, drawing):
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
