"""Computation of comparisons: each test is one function and one line in `_TESTS`."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.analyses.contract import (
    AnalysisData,
)
from vrcomfort.report.descriptives import Description, describe
from vrcomfort.report.families import (
    Decision,
)
from vrcomfort.report.pairs import (
    NO_VARIANCE,
    Groups,
    Pairs,
    Side,
    groups_of,
    pair_up,
    possible_difference,
    too_few,
)
from vrcomfort.report.possible import limited
from vrcomfort.report.rows import HIDDEN, INLINE
from vrcomfort.stats.mann_whitney import mann_whitney
from vrcomfort.stats.proportions import sign_test
from vrcomfort.stats.t_tests import TTest, Variances, paired_t, two_sample_t

if TYPE_CHECKING:
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.plan import Plan
    from vrcomfort.stats.effects import EffectSize
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.shift import Shift


@dataclass(frozen=True)
class MeanDifference:
    """A difference of means with its t interval."""

    estimate: float
    low: float | None
    high: float | None
    confidence: float


@dataclass(frozen=True)
class NamedEstimate:
    """An estimate with its interval, and its name."""

    what: str
    of: Shift | EffectSize | MeanDifference = field(metadata=INLINE)


@dataclass(frozen=True)
class ComparisonIntervals:
    """The estimates with intervals of one level."""

    difference: NamedEstimate | None
    effect: NamedEstimate | None


@dataclass(frozen=True)
class ComparisonNumbers:
    """The numbers of a test."""

    statistic: str
    value: float
    df: float | None
    z: float | None
    ties: int | None
    method: str
    p_asymptotic: float | None
    difference: NamedEstimate | None
    effect: NamedEstimate | None
    bayes_factor_10: float | None


@dataclass(frozen=True)
class ComparisonFound:
    """A test, with the description of both sides."""

    descriptives: dict[str, Description]
    numbers: ComparisonNumbers = field(metadata=INLINE)


@dataclass(frozen=True)
class ComparisonRow:
    """One contrast, compared on one outcome."""

    a: str
    b: str
    outcome: str
    test: str
    design: str
    sides: tuple[Side, Side]
    alternative: Alternative
    n_a: int
    n_b: int
    participants: tuple[str, ...]
    p: float | None
    not_tested: str | None
    decision: Decision[ComparisonIntervals] = field(metadata=INLINE)
    found: ComparisonFound | None = field(metadata=INLINE)
    largest_difference: float | None = field(metadata=HIDDEN)
    """That two such scores can have; None where it is not known."""

    @property
    def reported(self) -> ComparisonIntervals | ComparisonNumbers | None:
        """Return the estimates with the intervals that belong to the p that decides."""
        return self.decision.simultaneous or (self.found.numbers if self.found else None)

    @property
    def size(self) -> str:
        """Return the number of people, of groups that of each."""
        return str(self.n_a) if self.design == "paired" else f"{self.n_a}, {self.n_b}"


@dataclass(frozen=True)
class _Test:
    """The result of one kind of test."""

    p: float
    higher: bool
    numbers: ComparisonNumbers


def compute(data: AnalysisData, _: Sequence[object]) -> list[ComparisonRow]:
    """Compare both sides of each contrast that names another test, on each outcome."""
    return [
        _row(data, contrast, outcome.name)
        for contrast in data.contrasts
        if contrast.test != "signed_rank"
        for outcome in data.scored.outcomes
    ]


def people_of_tests(rows: Sequence[ComparisonRow]) -> Iterator[Collection[str]]:
    """Yield the participants of each test; contrasts between the same groups are one test.

    Nobody is in each pair of three groups, and nobody is missing there.
    """
    groups: dict[tuple[str, str, str], set[str]] = defaultdict(set)
    for row in rows:
        if row.design == "paired":
            yield row.participants
        elif row.participants:
            side = row.sides[0]
            condition = side.condition if side.column else ""
            groups[row.outcome, side.column, condition].update(row.participants)
    yield from groups.values()


def _row(data: AnalysisData, contrast: Compared, outcome: str) -> ComparisonRow:
    a, b, plan = contrast.a, contrast.b, data.plan
    design = "independent" if contrast.between else "paired"
    samples = _samples(data, design, outcome, a, b)
    if isinstance(samples, Groups):
        people = (*samples.people_a, *samples.people_b)
    else:
        people = samples.participants
    row = ComparisonRow(
        a.name, b.name, outcome, contrast.test, design, (a, b), contrast.alternative,
        samples.a.size, samples.b.size, people, None, too_few(samples), Decision(), None,
        possible_difference(data.scored, outcome, a, b).high,
    )  # fmt: skip
    if row.not_tested:
        return row
    test = _tested(data, row, samples, plan.confidence)
    if test is None:
        return replace(row, not_tested=NO_VARIANCE)
    sides = {"a": describe(samples.a * samples.unit), "b": describe(samples.b * samples.unit)}
    smallest = _SMALLEST_P.get(row.test, _any_p)(samples, plan, row.alternative)
    decision: Decision[ComparisonIntervals] = Decision(smallest_p=smallest, higher=test.higher)
    return replace(row, p=test.p, decision=decision, found=ComparisonFound(sides, test.numbers))


def _tested(
    data: AnalysisData, row: ComparisonRow, samples: Pairs | Groups, confidence: float
) -> _Test | None:
    """Test two sides; the interval of their difference ends within the possible range."""
    test = _TESTS[row.test](samples, data.plan, row.alternative, confidence)
    if test is None or test.numbers.difference is None:
        return test
    possible = possible_difference(data.scored, row.outcome, *row.sides)
    difference = replace(test.numbers.difference, of=limited(test.numbers.difference.of, possible))
    return replace(test, numbers=replace(test.numbers, difference=difference))


def _samples(data: AnalysisData, design: str, outcome: str, a: Side, b: Side) -> Pairs | Groups:
    make = pair_up if design == "paired" else groups_of
    return make(data.scored, outcome, a, b, complete=data.complete)


def intervals(data: AnalysisData, row: ComparisonRow, level: float) -> ComparisonIntervals | None:
    """Return the estimates with the intervals of a level; None without a test."""
    samples = _samples(data, row.design, row.outcome, *row.sides)
    test = _tested(data, row, samples, 1 - level)
    if test is None:
        return None
    return ComparisonIntervals(test.numbers.difference, test.numbers.effect)


def _mann_whitney(
    samples: Any, plan: Plan, alternative: Alternative, confidence: float
) -> _Test | None:
    test = mann_whitney(
        samples.a, samples.b, samples.unit, alternative=alternative, p_value=plan.p_value,
        confidence=confidence,
    )  # fmt: skip
    if test is None or test.shift is None or test.effect is None:
        return None
    numbers = ComparisonNumbers(
        "U", test.u, None, test.z, test.ties, test.method, test.p_asymptotic,
        NamedEstimate("Hodges–Lehmann shift", test.shift),
        NamedEstimate("rank-biserial r", test.effect), None,
    )  # fmt: skip
    return _Test(test.p, bool(test.u > samples.a.size * samples.b.size / 2), numbers)


def _sign(samples: Any, _: Plan, alternative: Alternative, confidence: float) -> _Test:
    test = sign_test(
        samples.differences, samples.unit, alternative=alternative, confidence=confidence
    )
    numbers = ComparisonNumbers(
        "positive", test.positive, None, None, test.zeros, "exact", None,
        NamedEstimate("median difference", test.median) if test.median else None,
        NamedEstimate("share above", test.share) if test.share else None, None,
    )  # fmt: skip
    return _Test(test.p, test.positive > test.negative, numbers)


def _t(test: TTest | None) -> _Test | None:
    if test is None:
        return None
    difference = MeanDifference(test.mean, test.low, test.high, test.confidence)
    numbers = ComparisonNumbers(
        "t", test.t, test.df, None, None, "t", None, NamedEstimate("mean difference", difference),
        NamedEstimate("Hedges’ g", test.hedges_g), test.bayes_factor_10,
    )  # fmt: skip
    return _Test(test.p, test.mean > 0, numbers)


def _paired_t(samples: Any, _: Plan, alternative: Alternative, confidence: float) -> _Test | None:
    found = paired_t(
        samples.differences, samples.unit, alternative=alternative, confidence=confidence
    )
    return _t(found)


def _groups_t(
    samples: Any, _: Plan, alternative: Alternative, confidence: float, variances: Variances
) -> _Test | None:
    found = two_sample_t(
        samples.a, samples.b, samples.unit, variances=variances, alternative=alternative,
        confidence=confidence,
    )  # fmt: skip
    return _t(found)


_TESTS: dict[str, Callable[[Any, Plan, Alternative, float], _Test | None]] = {
    "mann_whitney": _mann_whitney,
    "welch_t": partial(_groups_t, variances="welch"),
    "student_t": partial(_groups_t, variances="pooled"),
    "paired_t": _paired_t,
    "sign": _sign,
}


def _smallest_of_ranks(samples: Any, plan: Plan, alternative: Alternative) -> float:
    """Return the smallest p of these ranks: one group entirely above the other."""
    # Ties fall differently at the two ends, so that either group's being higher has a p of its own.
    ordered, n, m = np.sort(np.concatenate([samples.a, samples.b])), samples.a.size, samples.b.size
    ways = [(ordered[:n], ordered[n:]), (ordered[m:], ordered[:m])]
    tests = [
        mann_whitney(a, b, alternative=alternative, p_value=plan.p_value, intervals=False)
        for a, b in ways
    ]
    return min(test.p for test in tests if test is not None)


def _smallest_of_signs(samples: Any, _: Plan, alternative: Alternative) -> float:
    """Return the smallest p of these differences: all in one direction."""
    one_way = np.abs(samples.differences) * (-1 if alternative == "less" else 1)
    return sign_test(one_way, alternative=alternative).p


def _any_p(*_: object) -> float:
    return 0.0


_SMALLEST_P: dict[str, Callable[[Any, Plan, Alternative], float]] = {
    "mann_whitney": _smallest_of_ranks,
    "sign": _smallest_of_signs,
}
"""The smallest p that so many people can give; t tests have none."""
