"""Estimation plots of two groups: everybody's scores, beside the difference that was tested.

After Gardner & Altman (1986) and Ho et al. (2019), for independent groups, and for pairs whose test
is not the signed-rank test.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.canvas import Drawing, canvas, lines
from vrcomfort.report.estimation import difference_label
from vrcomfort.report.families import reported
from vrcomfort.report.pairs import Side, groups_of, pair_up
from vrcomfort.report.sides import draw_difference, draw_people, draw_side, draw_zero

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.vocabulary import Vocabulary

    Floats = NDArray[np.float64]
    Row = dict[str, Any]


def group_figure(scored: Exposures, row: Row, words: Vocabulary) -> Drawing | None:
    """Draw one comparison: the scores of both sides, then the difference with its interval.

    Returns
    -------
    Drawing or None
        None where there was no test.
    """
    if row["not_tested"]:
        return None
    name = f"comparison-{row['outcome']}-{row['a']}-{row['b']}-{row['test']}"
    a, b = values_of(scored, row)
    with canvas(name, 5.2, 3.7) as (figure, drawing):
        raw, effect = figure.subplots(1, 2, width_ratios=[2.4, 1.3])
        if row["design"] == "paired":
            draw_people(raw, np.array([0.0, 1.0]), np.column_stack([a, b]))
        for place, (side, values) in enumerate((("a", a), ("b", b))):
            half = 0.0 if row["design"] == "paired" else 0.09
            draw_side(raw, place, values, words.place(row[side]), half)
        raw.set_xticks([0, 1], [lines(words.condition(row[side]), 14) for side in ("a", "b")])
        raw.set_xlim(-0.45, 1.6)
        raw.set_ylabel(lines(words.axis(row["outcome"]), 40))
        _draw_difference(effect, row, words)
    return drawing


def values_of(scored: Exposures, row: Row) -> tuple[Floats, Floats]:
    """Return the scores of those in a comparison, in points."""
    one, two = (Side(**side) for side in row["sides"])
    tested = set(row["participants"])
    if row["design"] == "paired":
        pairs = pair_up(scored, row["outcome"], one, two, complete=False)
        kept = [place for place, who in enumerate(pairs.participants) if who in tested]
        return _in_points(pairs.a[kept], pairs.unit), _in_points(pairs.b[kept], pairs.unit)
    groups = groups_of(scored, row["outcome"], one, two, complete=False)
    sides = ((groups.people_a, groups.a), (groups.people_b, groups.b))
    a, b = (
        np.array([value for who, value in zip(people, values, strict=True) if who in tested])
        for people, values in sides
    )
    return _in_points(a, groups.unit), _in_points(b, groups.unit)


def _in_points(steps: NDArray[np.int64], unit: float) -> Floats:
    return np.asarray(steps * unit, dtype=np.float64)


def _draw_difference(axes: Axes, row: Row, words: Vocabulary) -> None:
    found = reported(row, "difference")
    ends = [found["estimate"] if found[end] is None else found[end] for end in ("low", "high")]
    draw_difference(axes, 0, found["estimate"], *ends)
    draw_zero(axes)
    a, b = (lines(words.condition(row[side]), 16) for side in ("a", "b"))
    axes.set_xticks([0], [f"{a}\n− {b}"])
    axes.set_xlim(-0.6, 0.6)
    axes.set_ylabel(difference_label(row["outcome"], words))
