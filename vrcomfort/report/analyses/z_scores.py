"""Outcomes standardised within each person, by condition."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisFigure,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    ReportContext,
    TableColumn,
    unknown_outcome,
    with_dot,
)
from vrcomfort.report.canvas import INK, Drawing, canvas, lines
from vrcomfort.report.exposures import with_scores
from vrcomfort.report.palette import colour_of, marker_of
from vrcomfort.report.words import number
from vrcomfort.settings import Problem, repeated
from vrcomfort.stats.means import z_scored

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.vocabulary import Vocabulary


@dataclass(frozen=True)
class ZScoreRow:
    """The mean z score of a condition, with its standard errors of values and of people."""

    outcome: str
    condition: str
    mean: float
    standard_error: float | None
    n: int
    people: int
    standard_error_of_people: float | None


def _problems(plan: Plan, asked: Sequence[str]) -> Iterator[Problem]:
    yield from repeated(("z_scores",), asked)
    for place, name in enumerate(asked):
        yield from unknown_outcome(plan, name, "z_scores", place)


def _compute(data: AnalysisData, asked: Sequence[str]) -> list[ZScoreRow]:
    return [row for outcome in asked if data.has(outcome) for row in _of_outcome(data, outcome)]


def _of_outcome(data: AnalysisData, outcome: str) -> list[ZScoreRow]:
    table = with_scores(data.scored.table, outcome)
    values = [float(value) * data.scored.units[outcome] for value in table[outcome]]
    found = z_scored(list(table["participant"]), list(table["condition"]), values)
    return [ZScoreRow(outcome, name, *found[name]) for name in data.conditions if name in found]


def _methods(rows: Sequence[ZScoreRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    if rows:
        yield MethodsParagraph(
            "Standardised scores",
            "z scores are scores minus their person’s mean over all exposures, over that person’s "
            "standard deviation. Standard errors over values, as Mantiuk et al. (2011) print them, "
            "take a person’s scores for independent; those over people do not.",
            ("mantiuk_2011",),
        )


def _draw(rows: Sequence[ZScoreRow], words: Vocabulary) -> Drawing | None:
    """Draw the mean of each condition with its standard error, of each outcome side by side."""
    outcomes = list(dict.fromkeys(row.outcome for row in rows))
    if not outcomes:
        return None
    conditions = list(dict.fromkeys(row.condition for row in rows))
    labels = [lines(words.condition(each), 26) for each in conditions]
    height = 0.9 + sum(0.25 + 0.17 * (label.count("\n") + 1) for label in labels)
    with canvas("z-scores", 2.4 + 2.4 * len(outcomes), height, "z_scores") as (figure, drawing):
        panels = np.atleast_1d(figure.subplots(1, len(outcomes), sharex=True, sharey=True))
        for axes, outcome in zip(panels, outcomes, strict=True):
            axes.axvline(0, color=INK, lw=0.6)
            for row in (row for row in rows if row.outcome == outcome):
                place = words.place(row.condition)
                axes.errorbar(
                    row.mean, conditions.index(row.condition), xerr=row.standard_error or 0,
                    fmt=marker_of(place), ms=6, color=colour_of(place), capsize=4,
                )  # fmt: skip
            axes.set_yticks(range(len(conditions)), labels)
            axes.set(title=lines(words.outcome(outcome), 30), ylim=(len(conditions) - 0.4, -0.6))
        panels[len(outcomes) // 2].set_xlabel("z score within people")
    return drawing


def _figures(rows: Sequence[ZScoreRow], report: ReportContext) -> Iterator[AnalysisFigure]:
    yield AnalysisFigure(
        "standardised",
        "standardised",
        "Means of z scores with their standard errors over all values (cf. Figure 4 of Mantiuk et "
        "al. 2011).",
        lambda _: _draw(rows, report.words),
    )


_Column = TableColumn[ZScoreRow]
_TABLE: AnalysisTable[ZScoreRow, ZScoreRow] = AnalysisTable(
    "z_scores",
    "Outcomes standardised within each person",
    (
        _Column("Outcome", lambda row, words: words.outcome(row.outcome)),
        _Column("Condition", lambda row, words: with_dot(row.condition, words), of_words=True),
        _Column(Markup("mean <i>z</i>"), lambda row, _: number(row.mean)),
        _Column(Markup("<i>SE</i> of values"), lambda row, _: number(row.standard_error, 3)),
        _Column("values", lambda row, _: str(row.n)),
        _Column(
            Markup("<i>SE</i> of people"), lambda row, _: number(row.standard_error_of_people, 3)
        ),
        _Column("people", lambda row, _: str(row.people)),
    ),
)

Z_SCORES = Analysis(
    "z_scores",
    AnalysisSet.ALL_AVAILABLE,
    _compute,
    asked=str,
    about="Outcomes that are standardised within each person as well.",
    problems=_problems,
    tables=(_TABLE,),
    figures=_figures,
    figure_kinds=("standardised",),
    place=60,
    order=80,
    methods=_methods,
)
