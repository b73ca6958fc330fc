"""Friedman's test of more than two conditions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from markupsafe import Markup

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
    html,
)
from vrcomfort.report.pairs import Side, side_sums
from vrcomfort.report.rows import INLINE
from vrcomfort.report.words import fraction, number, p_value
from vrcomfort.stats.rank_anova import Friedman, friedman


@dataclass(frozen=True)
class FriedmanFound:
    """The test, and its participants."""

    participants: tuple[str, ...]
    test: Friedman = field(metadata=INLINE)


@dataclass(frozen=True)
class FriedmanRow:
    """All conditions, compared on one outcome."""

    outcome: str
    not_tested: str | None
    found: FriedmanFound | None = field(metadata=INLINE)


def _compute(data: AnalysisData, _: Sequence[object]) -> list[FriedmanRow]:
    # Of two conditions it is a sign test, and the signed-rank test sees more.
    outcomes = data.scored.outcomes if len(data.conditions) > 2 else ()
    return [_row(data, each.name) for each in outcomes]


def _row(data: AnalysisData, outcome: str) -> FriedmanRow:
    return FriedmanRow(outcome, *estimable(lambda: _found(data, outcome)))


def _found(data: AnalysisData, outcome: str) -> FriedmanFound:
    """Test the integer sums of the planned scores: of weighted scores, ties would be lost."""
    sides = [Side(condition) for condition in data.conditions]
    people, sums, _ = side_sums(data.scored, outcome, sides, complete=data.complete)
    return FriedmanFound(tuple(people), friedman(sums))


def _methods(rows: Sequence[FriedmanRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    if any(row.found for row in rows):
        yield MethodsParagraph(
            "More than two conditions",
            "All conditions together were compared with Friedman’s (1937) test, corrected for "
            "ties, on integer sums of participants with every exposure; Kendall’s W is its effect "
            "size (Kendall & Babington Smith, 1939).",
            ("friedman_1937", "kendall_1939"),
        )


def _note(_: Sequence[FriedmanRow], report: ReportContext) -> str:
    scores = "every planned" if report.plan.needs_every_score else "a"
    return html("<i>n</i>: participants with {} score of all conditions.", scores)


def _tested(write: Callable[[Friedman], str]) -> Callable[[FriedmanRow, object], str]:
    return lambda row, _: write(row.found.test) if row.found else ""


_Column = TableColumn[FriedmanRow]
_TABLE: AnalysisTable[FriedmanRow, FriedmanRow] = AnalysisTable(
    "",
    "Friedman tests over all conditions",
    (
        _Column("Score", lambda row, words: words.outcome(row.outcome)),
        _Column(ITALIC_N, _tested(lambda test: str(test.n))),
        _Column("χ²", _tested(lambda test: number(test.chi_square))),
        _Column("df", _tested(lambda test: str(test.df))),
        _Column(ITALIC_P, _tested(lambda test: p_value(test.p))),
        _Column(Markup("Kendall’s <i>W</i>"), _tested(lambda test: fraction(test.kendall_w, 3))),
    ),
    spanning=lambda row: row.not_tested,
    note=_note,
    csv=lambda _: (),
)

FRIEDMAN = Analysis(
    "friedman",
    AnalysisSet.COMPLETE_BLOCKS,
    _compute,
    section="models",
    place=110,
    order=110,
    tables=(_TABLE,),
    methods=_methods,
)
