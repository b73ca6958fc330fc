"""The plot of one comparison: the scores of both sides, and their difference."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.report.canvas import (
    Drawing,
    canvas,
    lines,
)
from vrcomfort.report.estimation import (
    difference_label,
    draw_difference,
    draw_people,
    draw_side,
    draw_zero,
)
from vrcomfort.report.pairs import groups_of, pair_up

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vrcomfort.report.analyses.comparisons.computation import ComparisonRow
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.vocabulary import Vocabulary

    Floats = NDArray[np.float64]


def group_figure(scored: Exposures, row: ComparisonRow, words: Vocabulary) -> Drawing | None:
    """Draw one comparison: the scores of both sides, then the difference with its interval.

    Returns
    -------
    Drawing or None
        None where there was no test.
    """
    if row.found is None:
        return None
    name = f"comparison-{row.outcome}-{row.a}-{row.b}-{row.test}"
    a, b = values_of(scored, row)
    with canvas(name, 5.2, 3.7, "scores", "comparisons") as (figure, drawing):
        raw, effect = figure.subplots(1, 2, width_ratios=[2.4, 1.3])
        if row.design == "paired":
            draw_people(raw, np.array([0.0, 1.0]), np.column_stack([a, b]))
        for place, (side, values) in enumerate(((row.a, a), (row.b, b))):
            half = 0.0 if row.design == "paired" else 0.09
            draw_side(raw, place, values, words.place(side), half)
        raw.set_xticks([0, 1], [lines(words.condition(name), 14) for name in (row.a, row.b)])
        raw.set_xlim(-0.45, 1.6)
        raw.set_ylabel(lines(words.axis(row.outcome), 40))
        _draw_difference(effect, row, words)
    return drawing


def values_of(scored: Exposures, row: ComparisonRow) -> tuple[Floats, Floats]:
    """Return the scores of the people in a comparison, in points."""
    one, two = row.sides
    tested = set(row.participants)
    if row.design == "paired":
        pairs = pair_up(scored, row.outcome, one, two, complete=False)
        kept = [place for place, who in enumerate(pairs.participants) if who in tested]
        return _in_points(pairs.a[kept], pairs.unit), _in_points(pairs.b[kept], pairs.unit)
    groups = groups_of(scored, row.outcome, one, two, complete=False)
    sides = ((groups.people_a, groups.a), (groups.people_b, groups.b))
    a, b = (
        np.array([value for who, value in zip(people, values, strict=True) if who in tested])
        for people, values in sides
    )
    return _in_points(a, groups.unit), _in_points(b, groups.unit)


def _in_points(steps: NDArray[np.int64], unit: float) -> Floats:
    return np.asarray(steps * unit, dtype=np.float64)


def _draw_difference(axes: Axes, row: ComparisonRow, words: Vocabulary) -> None:
    named = row.reported.difference if row.reported else None
    if named is not None:
        found = named.of
        ends = [found.estimate if end is None else end for end in (found.low, found.high)]
        draw_difference(axes, 0, found.estimate, *ends)
    draw_zero(axes)
    a, b = (lines(words.condition(name), 16) for name in (row.a, row.b))
    axes.set_xticks([0], [f"{a}\n− {b}"])
    axes.set_xlim(-0.6, 0.6)
    axes.set_ylabel(difference_label(row.outcome, words))
