"""Crossover analyses: condition, position and sequence of two conditions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    estimable,
)
from vrcomfort.report.factors import points
from vrcomfort.report.rows import INLINE
from vrcomfort.stats.mixed import Crossover, crossover

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.rows import Cells


@dataclass(frozen=True)
class CrossoverFit:
    """The three effects, and the exposures that each participant was to have."""

    effects: Crossover = field(metadata=INLINE)
    left_out: tuple[str, ...]
    planned: dict[str, int]


@dataclass(frozen=True)
class CrossoverRow:
    """The crossover analysis of one pair of conditions on one outcome."""

    a: str
    b: str
    outcome: str
    not_tested: str | None
    fit: CrossoverFit | None = field(metadata=INLINE)


def _compute(data: AnalysisData, _: Sequence[object]) -> list[CrossoverRow]:
    return [
        _row(data, each.a.name, each.b.name, outcome.name)
        for each in data.contrasts
        if each.of_conditions and each.test == "signed_rank"
        for outcome in data.scored.outcomes
    ]


def _row(data: AnalysisData, a: str, b: str, outcome: str) -> CrossoverRow:
    return CrossoverRow(a, b, outcome, *estimable(lambda: _fit(data, a, b, outcome)))


def _fit(data: AnalysisData, a: str, b: str, outcome: str) -> CrossoverFit:
    table = points(data.scored.table, data.scored, outcome)
    planned = data.scored.planned_of[outcome]
    if not data.complete:
        planned = dict.fromkeys(planned, 1)
    pair = table[table["condition"].isin([a, b])]
    if pair["condition"].nunique() < 2:
        raise InputError("nobody finished both conditions")
    if (pair["position"] == 0).any():
        raise InputError("the data do not say in which order the conditions came")
    left_out = _without_one_place(pair)
    pair = pair[~pair["participant"].isin(left_out)]
    if pair["position"].nunique() != 2:
        raise InputError("not a two-position crossover: conditions come in more than two places")
    grouped = pair.groupby(["participant", "condition"])
    score, count = grouped["score"].mean().unstack(), grouped.size().unstack()  # noqa: PD010
    place = grouped["position"].first().unstack()  # noqa: PD010
    complete = (count >= count.columns.map(planned)).all(axis=1)
    score, place = score[complete], place[complete]
    a_first = (place[a] < place[b]).to_numpy()
    first = np.where(a_first, score[a], score[b])
    second = np.where(a_first, score[b], score[a])
    found = crossover(first, second, a_first)
    return CrossoverFit(found, tuple(left_out), {a: planned[a], b: planned[b]})


def _without_one_place(pair: pd.DataFrame) -> list[str]:
    """Return the few participants with one condition in several positions, as when repeated."""
    places = pair.groupby(["participant", "condition"])["position"].nunique()
    people = places[places > 1].index.get_level_values("participant").unique()
    if 2 * len(people) > pair["participant"].nunique():
        raise InputError("most participants met one condition in different positions")
    return sorted(map(str, people), key=natural)


def _methods(rows: Sequence[CrossoverRow]) -> Iterator[MethodsParagraph]:
    if any(row.fit for row in rows):
        yield MethodsParagraph(
            "Crossover",
            "The crossover analysis tests condition and position on differences and sums of the "
            "two positions within the two orders, and the order (carry-over) on the means of "
            "participants (Hills & Armitage, 1979).",
            ("hills_1979",),
        )


def _csv(row: CrossoverRow) -> Iterator[Cells]:
    """Yield the effects, one line each."""
    keys = {"a": row.a, "b": row.b, "outcome": row.outcome}
    fit = row.fit
    if fit is None:
        yield {**keys, "not_tested": row.not_tested}
        return
    found = fit.effects
    sizes = {
        "n_ab": found.n_ab, "n_ba": found.n_ba,
        "planned_a": fit.planned[row.a], "planned_b": fit.planned[row.b],
    }  # fmt: skip
    effects = {"condition": found.condition, "period": found.period, "sequence": found.sequence}
    for name, effect in effects.items():
        yield {**keys, **sizes, "effect": name, **asdict(effect)}


CROSSOVER: Analysis[CrossoverRow] = Analysis(
    "crossover",
    AnalysisSet.COMPLETE_PAIRS,
    _compute,
    section="order",
    tables=(AnalysisTable("crossover", template="report/crossover.html.j2", csv=_csv),),
    methods=_methods,
)
