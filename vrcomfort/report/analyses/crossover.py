"""Crossover analyses: condition, position and sequence of two conditions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.plurals import counted
from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import (
    MOST_NAMED,
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    Remark,
    ReportContext,
    TableColumn,
    by_reason,
    estimable,
    estimate_columns,
)
from vrcomfort.report.factors import points
from vrcomfort.report.possible import limited
from vrcomfort.report.rows import INLINE
from vrcomfort.stats.mixed import Crossover, Estimate, crossover

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary


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
    if not data.complete:  # any number of exposures will do
        planned = dict.fromkeys(planned, 1)
    pair = table[table["condition"].isin([a, b])]
    if pair["condition"].nunique() < 2:
        raise InputError("no participant finished both conditions")
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
    found = crossover(first, second, a_first, confidence=data.plan.confidence)
    apart = data.scored.possible_scores(outcome).difference
    names = ("condition", "period", "sequence")
    found = replace(found, **{name: limited(getattr(found, name), apart) for name in names})
    return CrossoverFit(found, tuple(left_out), {a: planned[a], b: planned[b]})


def _without_one_place(pair: pd.DataFrame) -> list[str]:
    """Return the few participants with one condition in several positions, as when repeated."""
    places = pair.groupby(["participant", "condition"])["position"].nunique()
    people = places[places > 1].index.get_level_values("participant").unique()
    # A few came back to a condition; if most did, positions are no part of the design.
    if 2 * len(people) > pair["participant"].nunique():
        raise InputError("most participants met one condition in different positions")
    return sorted(map(str, people), key=natural)


def _methods(rows: Sequence[CrossoverRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    if any(row.fit for row in rows):
        yield MethodsParagraph(
            "Crossover",
            "The crossover analysis (Hills & Armitage, 1979) tests condition and position within "
            "participants, on differences between the two positions. It tests order (carry-over) "
            "between participants, on their means.",
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


def _remarks(rows: Sequence[CrossoverRow], _: ReportContext) -> Iterator[Remark]:
    made = any(row.fit for row in rows)
    for reason, missing in by_reason(rows, lambda row: row.not_tested).items():
        of = f" of {counted(len(missing), 'comparisons')}" if made else ""
        yield Remark(f"No crossover analysis{of}: {reason}.")


def _title(row: CrossoverRow, _: Sequence[CrossoverRow], report: ReportContext) -> str:
    if row.fit is None:
        return ""
    words, found, people = report.words, row.fit.effects, row.fit.left_out
    named = ", ".join(people[:MOST_NAMED])
    left_out = f"; excluded for one condition in different positions: {named}" if people else ""
    return (
        f"{words.outcome(row.outcome)}; {words.condition(row.a)} first: n = {found.n_ab}, "
        f"{words.condition(row.b)} first: n = {found.n_ba}{left_out}"
    )


@dataclass(frozen=True)
class _Line:
    """A line on one of the three effects."""

    row: CrossoverRow
    effect: Literal["condition", "period", "sequence"]
    found: Estimate


def _lines(row: CrossoverRow) -> Iterator[_Line]:
    if row.fit:
        effects = row.fit.effects
        yield _Line(row, "condition", effects.condition)
        yield _Line(row, "period", effects.period)
        yield _Line(row, "sequence", effects.sequence)


def _effect(line: _Line, words: Vocabulary) -> str:
    a, b = words.condition(line.row.a), words.condition(line.row.b)
    return {
        "condition": f"{a} minus {b}",
        "period": "second position minus first",
        "sequence": f"{b} first minus {a} first (carry-over)",
    }[line.effect]


def _estimate_of(line: _Line) -> Estimate:
    return line.found


_Column = TableColumn[_Line]
_TABLE: AnalysisTable[CrossoverRow, _Line] = AnalysisTable(
    "crossover",
    "Crossover analysis: condition, position and sequence (points)",
    (
        _Column("Effect", _effect, of_words=True),
        *estimate_columns(_estimate_of, "95 % CI"),  # whatever the plan's confidence
    ),
    lines=_lines,
    group=_title,
    note=lambda _rows, _report: (
        "The difference between conditions is adjusted for position, so its interval is not that "
        "of the unadjusted mean difference. Sequence is tested between participants and has little "
        "power; a difference may be carry-over or chance."
    ),
    csv=_csv,
)

_R_LINES = r"""
# The two-period crossover: t tests of half differences and of means of the periods, by sequence.
crossover <- function(found) {
  mine <- scores[scores$condition %in% c(found$a[1], found$b[1]) &
                 !is.na(scores[[found$outcome[1]]]), ]
  mine$score <- as.numeric(mine[[found$outcome[1]]])
  cell <- list(mine$participant, factor(mine$condition, c(found$a[1], found$b[1])))
  places <- tapply(mine$position, cell, function(p) length(unique(p)))
  count <- tapply(mine$score, cell, length)
  enough <- t(t(count) >= as.numeric(c(found$planned_a[1], found$planned_b[1])))
  kept <- rowSums(enough & places == 1) %in% 2
  score <- tapply(mine$score, cell, mean)[kept, , drop = FALSE]
  place <- tapply(as.numeric(mine$position), cell, min)[kept, , drop = FALSE]
  ab <- place[, 1] < place[, 2]
  one <- ifelse(ab, score[, 1], score[, 2]); two <- ifelse(ab, score[, 2], score[, 1])
  half <- (one - two) / 2; mean <- (one + two) / 2
  sides <- list(condition = list(half[ab], half[!ab]), period = list(-half[ab], half[!ab]),
                sequence = list(mean[!ab], mean[ab]))
  for (k in seq_len(nrow(found))) {
    line <- found[k, ]; side <- sides[[line$effect]]
    if (is.na(line$t)) next
    test <- t.test(side[[1]], side[[2]], var.equal = TRUE)
    about <- paste0("crossover, ", line$effect)
    compare(line, "estimate", line$estimate, unname(diff(rev(test$estimate))), about, size = 1e-6)
    compare(line, "standard error", line$standard_error, test$stderr, about)
    compare(line, "t", line$t, unname(test$statistic), about, size = 1e-6)
    compare(line, "p", line$p, test$p.value, about)
  }
}
found <- read_if_there("crossover")
if (!is.null(found)) {
  for (one in split(found, paste(found$a, found$b, found$outcome))) {
    crossover(one)
    models <- models + 1
  }
}
"""

CROSSOVER = Analysis(
    "crossover",
    AnalysisSet.COMPLETE_PAIRS,
    _compute,
    section="order",
    place=120,
    order=120,
    tables=(_TABLE,),
    remarks=_remarks,
    methods=_methods,
    r_lines=_R_LINES,
)
