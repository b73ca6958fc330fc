"""Friedman's test of more than two conditions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    estimable,
)
from vrcomfort.report.pairs import Side, side_sums
from vrcomfort.report.rows import INLINE
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
    outcomes = data.scored.outcomes if len(data.conditions) > 2 else ()
    return [_row(data, each.name) for each in outcomes]


def _row(data: AnalysisData, outcome: str) -> FriedmanRow:
    return FriedmanRow(outcome, *estimable(lambda: _found(data, outcome)))


def _found(data: AnalysisData, outcome: str) -> FriedmanFound:
    """Test the integer sums of the planned scores."""
    sides = [Side(condition) for condition in data.conditions]
    people, sums, _ = side_sums(data.scored, outcome, sides, complete=data.complete)
    return FriedmanFound(tuple(people), friedman(sums))


def _methods(rows: Sequence[FriedmanRow]) -> Iterator[MethodsParagraph]:
    if any(row.found for row in rows):
        yield MethodsParagraph(
            "More than two conditions",
            "All conditions together were compared with Friedman’s (1937) test, corrected for "
            "ties, on integer sums of participants with every exposure; Kendall’s W is its effect "
            "size (Kendall & Babington Smith, 1939).",
            ("friedman_1937", "kendall_1939"),
        )


FRIEDMAN: Analysis[FriedmanRow] = Analysis(
    "friedman",
    AnalysisSet.COMPLETE_BLOCKS,
    _compute,
    section="models",
    tables=(AnalysisTable("", template="report/friedman.html.j2", csv=lambda _: ()),),
    methods=_methods,
)
