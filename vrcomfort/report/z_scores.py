"""Outcomes standardised within each person, by condition: numbers and figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.canvas import INK, Drawing, canvas, lines
from vrcomfort.report.palette import colour_of, marker_of
from vrcomfort.stats.means import z_scored

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.vocabulary import Vocabulary

Row = dict[str, Any]


def standardised(scored: Exposures, plan: Plan, conditions: Iterable[str]) -> list[Row]:
    """Return a row for each outcome of the plan's `z_scores`, and condition."""
    return [
        {"outcome": outcome, "condition": condition, **found[condition]._asdict()}
        for outcome in plan.z_scores
        if outcome in scored.units
        for found in [_of_outcome(scored, outcome)]
        for condition in conditions
        if condition in found
    ]


def _of_outcome(scored: Exposures, outcome: str) -> dict[str, Any]:
    table = scored.table.dropna(subset=[outcome])
    values = [float(value) * scored.units[outcome] for value in table[outcome]]
    return z_scored(list(table["participant"]), list(table["condition"]), values)


def z_score_figure(rows: list[Row], words: Vocabulary) -> Drawing | None:
    """Draw the mean of each condition with its standard error, of each outcome side by side."""
    outcomes = list(dict.fromkeys(row["outcome"] for row in rows))
    if not outcomes:
        return None
    with canvas("z-scores", 1.2 + 2.4 * len(outcomes), 3.2) as (figure, drawing):
        panels = np.atleast_1d(figure.subplots(1, len(outcomes), sharey=True))
        for axes, outcome in zip(panels, outcomes, strict=True):
            mine = [row for row in rows if row["outcome"] == outcome]
            axes.axhline(0, color=INK, lw=0.6)
            for x, row in enumerate(mine):
                place = words.place(row["condition"])
                axes.errorbar(
                    x, row["mean"], row["standard_error"] or 0, fmt=marker_of(place), ms=6,
                    color=colour_of(place), capsize=4,
                )  # fmt: skip
            labels = [lines(words.condition(row["condition"]), 14) for row in mine]
            axes.set_xticks(range(len(mine)), labels, rotation=0 if len(mine) < 3 else 35)
            axes.set(title=lines(words.outcome(outcome), 30), xlim=(-0.6, len(mine) - 0.4))
        panels[0].set_ylabel("z score within people")
    return drawing
