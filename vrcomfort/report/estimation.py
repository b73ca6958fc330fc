"""Estimation plots: scores under each condition, beside the differences of the tests.

After Gardner & Altman (1986) and Ho et al. (2019); the difference shown is the one that is tested.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.report.canvas import (
    FAINT,
    GRID,
    INK,
    PAPER,
    SOFT,
    Drawing,
    canvas,
    dots,
    lines,
    spread,
    threads,
)
from vrcomfort.report.pairs import Side, groups_of, in_a_test, pair_up
from vrcomfort.report.palette import colour_of, marker_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vrcomfort.report.analyses.comparisons import ComparisonRow
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.exposures import Exposures
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


MOST_BESIDE = 2
"""Comparisons that fit beside the scores; more go below them, one in a row."""


def estimation_figure(
    scored: Exposures, tests: list[SignedRankRow], words: Vocabulary
) -> Drawing | None:
    """Draw one outcome: scores by condition (a line is a participant), then the differences.

    Parameters
    ----------
    tests
        Those of one outcome.

    Returns
    -------
    Drawing or None
        None without a test.
    """
    made = [test for test in tests if test.found]
    if not made:
        return None
    outcome = made[0].outcome
    sides = {s.name: s for t in made for s in t.sides}
    shown = [name for name in words.labels if name in sides]
    scores = _scores(scored, made, [sides[name] for name in shown])
    beside = len(made) <= MOST_BESIDE
    left, rows = 1.0 + 0.75 * len(shown), 0.42 * len(made) + 0.9
    size = (left + 0.9 + 1.1 * len(made), 3.7) if beside else (max(5.6, left + 0.6), 3.2 + rows)
    with canvas(f"estimation-{outcome}", *size) as (figure, drawing):
        if beside:
            ratios = [left, 0.9 + 1.0 * len(made)]
            raw, effect = figure.subplots(1, 2, width_ratios=ratios)
        else:
            raw, effect = figure.subplots(2, 1, height_ratios=[3.2, rows])
        _draw_scores(raw, scores, shown, words)
        moments = any(side.timepoint for side in sides.values())
        raw.set_ylabel(lines(words.axis(outcome, raw=moments), 40))
        draw = _draw_beside if beside else _draw_below
        draw(effect, [(test, differences(scored, test)) for test in made], words)
    return drawing


def _scores(scored: Exposures, tests: list[SignedRankRow], sides: list[Side]) -> Floats:
    """Return the mean score per exposure, people × sides; NaN for people in no test."""
    outcome = tests[0].outcome
    columns = []
    for side in sides:
        rows = side.rows(scored).dropna(subset=[outcome])
        rows = rows[rows["participant"].isin(in_a_test(tests, side.name, outcome))]
        columns.append(rows.groupby("participant")[outcome].mean() * scored.units[outcome])
    people = sorted(set().union(*(column.index for column in columns)))
    return np.column_stack([column.reindex(people).to_numpy(dtype=float) for column in columns])


def differences(scored: Exposures, test: SignedRankRow) -> Floats:
    """Return the differences of a test in points, of people with scores."""
    found = pair_up(scored, test.outcome, *test.sides, complete=False)
    tested = set(test.participants)
    chosen = [place for place, who in enumerate(found.participants) if who in tested]
    return np.asarray(found.differences[chosen] * found.unit, dtype=float)


def _draw_scores(axes: Axes, scores: Floats, shown: list[str], words: Vocabulary) -> None:
    places = np.arange(len(shown), dtype=float)
    draw_people(axes, places, scores)
    for place, condition in enumerate(shown):
        values = scores[:, place][~np.isnan(scores[:, place])]
        half = 0.05 if len(values) > 12 else 0.0
        draw_side(axes, places[place], values, words.place(condition), half)
    axes.set_xticks(places, [lines(words.condition(c), 14) for c in shown])
    axes.set_xlim(-0.45, len(shown) - 0.4)
    draw_zero(axes)


def _draw_beside(axes: Axes, found: list[tuple[SignedRankRow, Floats]], words: Vocabulary) -> None:
    for place, (test, each) in enumerate(found):
        across = place - 0.22 + spread(len(each), 0.1)
        dots(axes, thinned(across), thinned(each), FAINT, size=dot_size(len(each), 3.6), alpha=0.6,
             zorder=2)  # fmt: skip
        estimate = test.found.shift.estimate if test.found and test.found.shift else None
        draw_difference(axes, place + 0.12, estimate, *_ends(test, each))
    names = [_difference_of(test, words, 16) for test, _ in found]
    axes.set_xticks(range(len(found)), names)
    axes.set_xlim(-0.55, len(found) - 0.4)
    axes.set_ylabel(difference_label(found[0][0].outcome, words))
    draw_zero(axes)


def _draw_below(axes: Axes, found: list[tuple[SignedRankRow, Floats]], words: Vocabulary) -> None:
    for place, (test, each) in enumerate(found):
        axes.plot(_ends(test, each), (place, place), "-", color=INK, lw=2.2, zorder=4)
        if test.found and test.found.shift:
            axes.plot(test.found.shift.estimate, place, "D", color=INK, ms=5.5, mec=PAPER, mew=0.8)
    axes.set_yticks(range(len(found)), [_difference_of(test, words, 40) for test, _ in found])
    axes.set_ylim(len(found) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="x", color=GRID)
    axes.set_axisbelow(True)
    axes.set_xlabel(difference_label(found[0][0].outcome, words))
    draw_zero(axes, upright=True)


def difference_label(outcome: str, words: Vocabulary) -> str:
    """Return the label of an axis with differences of an outcome."""
    unit = words.unit(outcome)
    return f"difference ({unit})" if unit else "difference"


def _difference_of(test: SignedRankRow, words: Vocabulary, width: int) -> str:
    return f"{lines(words.condition(test.a), width)}\n− {lines(words.condition(test.b), width)}"


def _ends(test: SignedRankRow, differences: Floats) -> tuple[float, float]:
    """Return the ends of the interval; one that is not bounded is the farthest difference."""
    shift = test.reported.shift if test.reported else None
    if shift is None or (shift.low is None and shift.high is None):
        return np.nan, np.nan
    low, high = shift.low, shift.high
    return (
        float(differences.min()) if low is None else low,
        float(differences.max()) if high is None else high,
    )


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
    with canvas(name, 5.2, 3.7) as (figure, drawing):
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
