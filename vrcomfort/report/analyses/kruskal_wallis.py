"""Kruskal and Wallis' test of more than two groups: each factor of the ANOVA between people."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import (
    ITALIC_N,
    ITALIC_P,
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    ReportContext,
    TableColumn,
    estimable,
    starred_p,
)
from vrcomfort.report.factors import is_between, level_of, points
from vrcomfort.report.pairs import Side, side_sums, with_every_score
from vrcomfort.report.rows import INLINE, cells
from vrcomfort.report.words import fraction, number
from vrcomfort.stats.rank_anova import KruskalWallis, kruskal_wallis

if TYPE_CHECKING:
    from vrcomfort.report.plan import Factor
    from vrcomfort.report.rows import Cells


@dataclass(frozen=True)
class KruskalWallisFound:
    """The test, and its groups."""

    levels: tuple[str, ...]
    participants: tuple[str, ...]
    test: KruskalWallis = field(metadata=INLINE)


@dataclass(frozen=True)
class KruskalWallisRow:
    """The groups of one factor, compared on one outcome."""

    factor: str
    outcome: str
    not_tested: str | None
    found: KruskalWallisFound | None = field(metadata=INLINE)


def _compute(data: AnalysisData, _: Sequence[object]) -> list[KruskalWallisRow]:
    return [
        _row(data, factor, each.name)
        for factor in data.plan.anova
        if is_between(factor) and _levels(data, factor) > 2
        for each in data.scored.outcomes
    ]


def _row(data: AnalysisData, factor: Factor, outcome: str) -> KruskalWallisRow:
    why_not, found = estimable(lambda: _found(data, factor, outcome))
    return KruskalWallisRow(factor.name, outcome, why_not, found)


def _levels(data: AnalysisData, factor: Factor) -> int:
    return len(level_of(data.scored, data.scored.table, factor).dropna().unique())


def _found(data: AnalysisData, factor: Factor, outcome: str) -> KruskalWallisFound:
    """Test the groups on each person's integer sums, brought to one number of exposures."""
    scored = data.scored
    rows = points(scored.table, scored, outcome)
    rows = rows.assign(level=level_of(scored, rows, factor)).dropna(subset=["level"])
    if data.complete:
        rows = with_every_score(rows, ["level"])
    group = dict(zip(rows["participant"], rows["level"], strict=True))
    names = sorted({str(level) for level in rows["level"].unique()}, key=natural)
    # A side without a condition is every exposure; who lacks a planned one is out of `group` above.
    people, sums, _ = side_sums(scored, outcome, [Side()], complete=False)
    of = dict(zip(people, sums[:, 0], strict=True))
    groups = [np.array([v for who, v in of.items() if group.get(who) == name]) for name in names]
    test = kruskal_wallis(groups, p_value=data.plan.p_value)
    return KruskalWallisFound(tuple(names), tuple(sorted(group, key=natural)), test)


def _methods(rows: Sequence[KruskalWallisRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    if any(row.found for row in rows):
        yield MethodsParagraph(
            "More than two groups",
            "More than two groups were compared with the test of Kruskal & Wallis (1952), "
            "corrected for ties, on each person’s mean over exposures; ε² = H / (N − 1) is its "
            "effect size. p is exact given the ties where it is not marked.",
            ("kruskal_1952",),
        )


def _csv(row: KruskalWallisRow) -> Iterator[Cells]:
    found = row.found
    sizes = zip(found.levels, found.test.sizes, strict=True) if found else ()
    yield cells(row, ("levels", "sizes", "participants")) | {
        "people_in_it": list(found.participants) if found else None,
        "groups": "; ".join(f"{name}: {n}" for name, n in sizes),
    }


def _note(rows: Sequence[KruskalWallisRow], _: ReportContext) -> str:
    asymptotic = any(row.found and row.found.test.method == "asymptotic" for row in rows)
    return "* asymptotic: too many people for the exact p." if asymptotic else ""


_Column = TableColumn[KruskalWallisRow]


def _tested(write: Callable[[KruskalWallis], str]) -> Callable[[KruskalWallisRow, object], str]:
    return lambda row, _: write(row.found.test) if row.found else ""


_TABLE: AnalysisTable[KruskalWallisRow, KruskalWallisRow] = AnalysisTable(
    "kruskal_wallis",
    "Kruskal–Wallis tests of more than two groups",
    (
        _Column("Outcome", lambda row, words: words.outcome(row.outcome)),
        _Column("Factor", lambda row, _: row.factor, of_words=True),
        _Column(ITALIC_N, _tested(lambda test: ", ".join(map(str, test.sizes)))),
        _Column(Markup("<i>H</i>"), _tested(lambda test: number(test.h))),
        _Column("df", _tested(lambda test: str(test.df))),
        _Column(ITALIC_P, _tested(lambda test: starred_p(test.p, test.method))),
        _Column("ε²", _tested(lambda test: fraction(test.epsilon_squared, 3))),
    ),
    spanning=lambda row: row.not_tested,
    labels=2,
    note=_note,
    csv=_csv,
)

_R_LINES = r"""
# Kruskal and Wallis: H of each person's mean, by the levels that the ANOVA has.
found <- read_if_there("kruskal_wallis")
for (k in seq_len(if (is.null(found)) 0 else nrow(found))) {
  line <- found[k, ]; column <- paste0("anova: ", line$factor)
  if (!column %in% names(scores)) next
  people <- names_in(line$people_in_it)
  level <- scores[[column]][match(people, scores$participant)]
  mean <- means_of(line$outcome, people, NA)
  test <- kruskal.test(signif(mean, 12)[!is.na(level)], factor(level[!is.na(level)]))
  about <- paste("Kruskal-Wallis,", line$factor)
  compare(line, "H", line$h, unname(test$statistic), about)
  compare(line, "p, asymptotic", line$p_asymptotic, test$p.value, about)
  others <- others + 1
}
"""

KRUSKAL_WALLIS = Analysis(
    "kruskal_wallis",
    AnalysisSet.COMPLETE_CASES,
    _compute,
    tables=(_TABLE,),
    place=10,
    order=60,
    methods=_methods,
    r_lines=_R_LINES,
)
