"""Equivalence: two one-sided t tests of a difference against the bounds of the plan."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

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
    Sentence,
    TableColumn,
    percent,
    unknown_outcome,
)
from vrcomfort.report.contrasts import check_group
from vrcomfort.report.measures import Limit
from vrcomfort.report.pairs import (
    NO_VARIANCE,
    Groups,
    Pairs,
    Side,
    groups_of,
    pair_up,
    sides_of,
    too_few,
)
from vrcomfort.report.plan import Entry
from vrcomfort.report.possible import limited
from vrcomfort.report.rows import INLINE, cells
from vrcomfort.report.words import degrees, interval, number, p_equals, p_value
from vrcomfort.settings import Problem
from vrcomfort.stats.ranks import level_of
from vrcomfort.stats.t_tests import equivalence_of_groups, equivalence_of_pairs

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.t_tests import Equivalence


class Equivalent(Entry):
    """A difference that is to be shown to lie within bounds."""

    outcome: str
    a: str
    b: str
    between: str = ""
    """Blank: of the same people; else as in a contrast."""
    condition: str = ""
    low: Limit
    high: Limit
    """Bounds of the difference of means, in points of the outcome."""


@dataclass(frozen=True)
class EquivalenceFound:
    """The two one-sided tests."""

    mean: float
    df: float
    t_low: float
    t_high: float
    p_low: float
    p_high: float
    p: float
    confidence: float
    equivalent: bool


@dataclass(frozen=True)
class EquivalenceRow:
    """One test of equivalence; low and high are the bounds where there is no interval."""

    outcome: str
    a: str
    b: str
    between: str
    condition: str
    low: float
    high: float
    bounds: tuple[float, float]
    not_tested: str | None
    n: int
    people_a: tuple[str, ...]
    people_b: tuple[str, ...]
    found: EquivalenceFound | None = field(metadata=INLINE)


def _problems(plan: Plan, asked: Sequence[Equivalent]) -> Iterator[Problem]:
    for place, each in enumerate(asked):
        yield from unknown_outcome(plan, each.outcome, "equivalence", place, "outcome")
        if each.low >= each.high:
            message = f"low ({each.low:g}) is not below high ({each.high:g})"
            yield Problem(("equivalence", place, "low"), message)


def _compute(data: AnalysisData, asked: Sequence[Equivalent]) -> list[EquivalenceRow]:
    for place, each in enumerate(asked):
        if each.between:
            path = ("equivalence", place)
            check_group(data.plan, data.scored, path, each.between, each.a, each.b)
    return [_row(data, each) for each in asked if data.has(each.outcome)]


def _row(data: AnalysisData, asked: Equivalent) -> EquivalenceRow:
    samples = _samples(data, asked)
    level = level_of(data.plan.confidence)
    problem = too_few(samples)
    test = None if problem else _test(samples, asked, level)
    test = limited(test, data.scored.possible_scores(asked.outcome).difference)
    if isinstance(samples, Pairs):
        n, people = len(samples.participants), (samples.participants, samples.participants)
    else:
        n = samples.a.size + samples.b.size
        people = (samples.people_a, samples.people_b)
    bounds = (asked.low, asked.high)
    low, high = (test.low, test.high) if test else bounds  # results.json has the keys in any case
    found = None
    if test:
        found = EquivalenceFound(
            test.mean, test.df, test.t_low, test.t_high, test.p_low, test.p_high, test.p,
            test.confidence, equivalent=test.p <= level,
        )  # fmt: skip
    elif not problem:
        problem = NO_VARIANCE
    return EquivalenceRow(
        asked.outcome, asked.a, asked.b, asked.between, asked.condition, low, high, bounds,
        problem, int(n), *people, found,
    )  # fmt: skip


def _samples(data: AnalysisData, asked: Equivalent) -> Pairs | Groups:
    if asked.between:
        sides = sides_of(asked.between, asked.a, asked.b, asked.condition)
        return groups_of(data.scored, asked.outcome, *sides, complete=data.complete)
    a, b = Side(asked.a), Side(asked.b)
    return pair_up(data.scored, asked.outcome, a, b, complete=data.complete)


def _test(samples: Pairs | Groups, asked: Equivalent, level: float) -> Equivalence | None:
    bounds = (asked.low, asked.high)
    if isinstance(samples, Pairs):
        return equivalence_of_pairs(samples.differences * samples.unit, bounds, level=level)
    a, b = samples.a * samples.unit, samples.b * samples.unit
    return equivalence_of_groups(a, b, bounds, level=level)


def _sentences(row: EquivalenceRow, words: Vocabulary) -> Iterator[Sentence]:
    a, b, name = words.condition(row.a), words.condition(row.b), words.outcome(row.outcome)
    low, high = (number(bound) for bound in row.bounds)
    found = row.found
    if found is None:
        yield Sentence(f"{name}: equivalence could not be tested ({row.not_tested}).")
        return
    shown = "lies" if found.equivalent else "was not shown to lie"
    yield Sentence(
        f"{name}: the difference of {a} and {b}, "
        f"{number(found.mean)} {words.unit(row.outcome)}".rstrip()
        + f", {shown} within {low} and {high}, n\u00a0=\u00a0{row.n}.",
        f"Two one-sided t tests: {p_equals(found.p)}; {100 * found.confidence:g}\u00a0% CI "
        f"{interval(row)}.",
    )


def _methods(rows: Sequence[EquivalenceRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    if any(row.found for row in rows):
        yield MethodsParagraph(
            "Equivalence",
            "Equivalence was tested with two one-sided t tests (Schuirmann, 1987) against the "
            "bounds of the plan; p is the larger of both. Groups may differ in variance.",
            ("schuirmann_1987",),
        )


def _csv(row: EquivalenceRow) -> Iterator[Cells]:
    low, high = row.bounds
    yield cells(row, ("bounds",)) | {"bound_low": low, "bound_high": high}


def _difference(row: EquivalenceRow, words: Vocabulary) -> str:
    return f"{words.condition(row.a)} minus {words.condition(row.b)}"


def _heading(_: Sequence[EquivalenceRow], report: ReportContext) -> str:
    # Two one-sided tests at α have an interval of the confidence 1 − 2α.
    return f"{percent(2 * report.plan.confidence - 1)} CI"


def _bounds(row: EquivalenceRow, _: Vocabulary) -> str:
    return " to ".join(map(number, row.bounds))


_Column = TableColumn[EquivalenceRow]


def _tested(write: Callable[[EquivalenceFound], str]) -> Callable[[EquivalenceRow, object], str]:
    return lambda row, _: write(row.found) if row.found else ""


_TABLE: AnalysisTable[EquivalenceRow, EquivalenceRow] = AnalysisTable(
    "equivalence",
    "Equivalence: two one-sided t tests against the bounds of the plan",
    (
        _Column("Outcome", lambda row, words: words.outcome(row.outcome)),
        _Column("Difference", _difference, of_words=True),
        _Column(ITALIC_N, lambda row, _: str(row.n)),
        _Column("bounds", _bounds),
        _Column("mean", _tested(lambda test: number(test.mean))),
        _Column(_heading, lambda row, _: interval(row)),
        _Column("df", _tested(lambda test: degrees(test.df))),
        _Column(Markup("<i>t</i> low"), _tested(lambda test: number(test.t_low))),
        _Column(Markup("<i>t</i> high"), _tested(lambda test: number(test.t_high))),
        _Column(ITALIC_P, _tested(lambda test: p_value(test.p))),
    ),
    spanning=lambda row: row.not_tested,
    labels=4,
    csv=_csv,
)

_R_LINES = r"""
# Two one-sided t tests against the bounds of the plan.
found <- read_if_there("equivalence")
for (k in seq_len(if (is.null(found)) 0 else nrow(found))) {
  line <- found[k, ]
  paired <- is.na(line$between)
  a <- means_of(line$outcome, names_in(line$people_a), if (paired) line$a else line$condition)
  b <- means_of(line$outcome, names_in(line$people_b), if (paired) line$b else line$condition)
  above <- t.test(a, b, paired = paired, mu = as.numeric(line$bound_low), alternative = "greater")
  below <- t.test(a, b, paired = paired, mu = as.numeric(line$bound_high), alternative = "less")
  about <- paste("equivalence of", line$a, "and", line$b)
  compare(line, "t, low", line$t_low, unname(above$statistic), about, size = 1e-6)
  compare(line, "t, high", line$t_high, unname(below$statistic), about, size = 1e-6)
  compare(line, "p", line$p, max(above$p.value, below$p.value), about)
  others <- others + 1
}
"""

EQUIVALENCE = Analysis(
    "equivalence",
    AnalysisSet.COMPLETE_PAIRS,
    _compute,
    asked=Equivalent,
    about="Two one-sided t tests at 1 − `confidence` each.",
    problems=_problems,
    tables=(_TABLE,),
    place=20,
    order=30,
    sentences=_sentences,
    methods=_methods,
    r_lines=_R_LINES,
)
