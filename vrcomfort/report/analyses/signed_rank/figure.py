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
    Drawing,
    canvas,
    dots,
    lines,
    spread,
)
from vrcomfort.report.estimation import (
    difference_label,
    dot_size,
    draw_difference,
    draw_people,
    draw_side,
    draw_zero,
    thinned,
)
from vrcomfort.report.exposures import with_scores
from vrcomfort.report.pairs import Side, in_a_test, pair_up

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from vrcomfort.report.analyses.signed_rank.computation import SignedRankRow
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.vocabulary import Vocabulary

    Floats = NDArray[np.float64]

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
    with canvas(f"estimation-{outcome}", *size, "scores", "tests") as (figure, drawing):
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
        rows = with_scores(side.rows(scored), outcome)
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
