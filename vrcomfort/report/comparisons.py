"""Comparisons by other tests than the signed-rank test: of pairs, and of groups of people.

Each test is one function and one line in `TESTS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.descriptives import describe
from vrcomfort.report.exposures import column_of
from vrcomfort.report.families import UNDECIDED, add_intervals
from vrcomfort.report.ordering import natural
from vrcomfort.report.pairs import Groups, Pairs, groups_of, pair_up
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.mann_whitney import mann_whitney
from vrcomfort.stats.proportions import sign_test
from vrcomfort.stats.t_tests import TTest, Variances, paired_t, two_sample_t

if TYPE_CHECKING:
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.stats.ranks import Alternative

Row = dict[str, Any]
NO_VARIANCE = "nothing varies, so that there is no t"


def run_comparisons(scored: Exposures, plan: Plan, contrasts: list[Compared]) -> list[Row]:
    """Compare every outcome in every contrast between groups, or with a test of its own."""
    return [
        _compare(scored, plan, contrast, outcome.name)
        for contrast in contrasts
        for outcome in scored.outcomes
    ]


def check_groups(plan: Plan, scored: Exposures) -> None:
    """Raise InputError where a contrast is between groups of a column that the data do not have."""
    for place, each in enumerate(plan.contrasts):
        if each.between:
            check_group(plan, scored, ("contrasts", place), each.between, each.a, each.b)


def check_group(
    plan: Plan, scored: Exposures, path: tuple[str, int], between: str, a: str, b: str
) -> None:
    """Raise InputError where the data do not have the column, or the groups, of an entry.

    Parameters
    ----------
    path
        Place of the entry in the plan.
    """
    said = {column for person in scored.people.values() for column in person}
    columns = {*said, "group", "sequence", "condition"} - {"status", "note", "enrolled_at"}
    if between not in columns:
        hint = did_you_mean(between, columns)
        message = f"`{between}` is no column that groups participants; {hint}"
        raise plan.fault(message, *path, "between")
    there = set(column_of(scored, scored.table, between).dropna().astype(str))
    for side, level in (("a", a), ("b", b)):
        if level not in there:
            known = ", ".join(sorted(there, key=natural)) or "nobody with a score"
            message = f"`{between}` is never `{level}`; the data have {known}"
            raise plan.fault(message, *path, side)


def _compare(scored: Exposures, plan: Plan, contrast: Compared, outcome: str) -> Row:
    a, b = contrast.a, contrast.b
    result: Row = {
        "a": a.name, "b": b.name, "outcome": outcome, "test": contrast.test,
        "design": "independent" if contrast.between else "paired",
        "sides": [asdict(a), asdict(b)], "alternative": contrast.alternative,
        "n_a": 0, "n_b": 0, "participants": [], "p": None, "not_tested": None, **UNDECIDED,
    }  # fmt: skip
    samples = _samples(scored, plan, contrast, outcome)
    if isinstance(samples, Groups):
        people = [*samples.people_a, *samples.people_b]
    else:
        people = list(samples.participants)
    result |= {"n_a": samples.a.size, "n_b": samples.b.size, "participants": people}
    if problem := too_few(samples):
        return result | {"not_tested": problem}
    test = TESTS[contrast.test]
    found = test(samples, plan, contrast.alternative, plan.confidence)
    if found is None:
        return result | {"not_tested": NO_VARIANCE}
    sides = {"a": describe(samples.a * samples.unit), "b": describe(samples.b * samples.unit)}
    smallest = SMALLEST_P.get(contrast.test, _any_p)(samples, plan, contrast.alternative)
    return result | {"descriptives": sides, "smallest_p": smallest} | found


def _samples(scored: Exposures, plan: Plan, contrast: Compared, outcome: str) -> Pairs | Groups:
    make = groups_of if contrast.between else pair_up
    return make(scored, outcome, contrast.a, contrast.b, complete=plan.needs_every_score)


def add_intervals_of_comparisons(
    scored: Exposures, plan: Plan, contrasts: list[Compared], rows: list[Row]
) -> None:
    """Add to every comparison in a family the intervals of the level at which it decides.

    Parameters
    ----------
    rows
        As `run_comparisons` returns them.
    """
    of_each = (contrast for contrast in contrasts for _ in scored.outcomes)
    for contrast, row in zip(of_each, rows, strict=True):

        def again(confidence: float, contrast: Compared = contrast, row: Row = row) -> Row:
            samples = _samples(scored, plan, contrast, row["outcome"])
            return TESTS[contrast.test](samples, plan, contrast.alternative, confidence) or {}

        add_intervals(row, 1 - plan.confidence, again)


def too_few(samples: Pairs | Groups) -> str | None:
    """Say why samples cannot be compared; None where they can."""
    if isinstance(samples, Pairs):
        n = len(samples.participants)
        return f"{n} complete pairs: too few for a test" if n < 2 else None
    if samples.in_both and min(samples.a.size, samples.b.size) < 2:
        return "the same people are on both sides: leave `between` away to compare pairs"
    if min(samples.a.size, samples.b.size) < 2:
        return f"{samples.a.size} and {samples.b.size} people: too few for a test"
    return None


def _mann_whitney(
    samples: Any, plan: Plan, alternative: Alternative, confidence: float
) -> Row | None:
    test = mann_whitney(
        samples.a, samples.b, samples.unit, alternative=alternative, p_value=plan.p_value,
        confidence=confidence,
    )  # fmt: skip
    if test is None or test.shift is None or test.effect is None:
        return None
    return {
        "statistic": "U", "value": test.u, "df": None, "z": test.z, "ties": test.ties,
        "p": test.p, "method": test.method, "p_asymptotic": test.p_asymptotic,
        "difference": {"what": "Hodges–Lehmann shift", **asdict(test.shift)},
        "effect": {"what": "rank-biserial r", **asdict(test.effect)},
        "bayes_factor_10": None, "higher": test.u > samples.a.size * samples.b.size / 2,
    }  # fmt: skip


def _sign(samples: Any, _: Plan, alternative: Alternative, confidence: float) -> Row:
    test = sign_test(
        samples.differences, samples.unit, alternative=alternative, confidence=confidence
    )
    return {
        "statistic": "positive", "value": test.positive, "df": None, "z": None,
        "ties": test.zeros, "p": test.p, "method": "exact", "p_asymptotic": None,
        "difference": {"what": "median difference", **asdict(test.median)} if test.median else None,
        "effect": {"what": "share above", **asdict(test.share)} if test.share else None,
        "bayes_factor_10": None, "higher": test.positive > test.negative,
    }  # fmt: skip


def _t(test: TTest | None) -> Row | None:
    if test is None:
        return None
    return {
        "statistic": "t", "value": test.t, "df": test.df, "z": None, "ties": None, "p": test.p,
        "method": "t", "p_asymptotic": None,
        "difference": {
            "what": "mean difference", "estimate": test.mean, "low": test.low, "high": test.high,
            "confidence": test.confidence,
        },
        "effect": {"what": "Hedges’ g", **asdict(test.hedges_g)},
        "bayes_factor_10": test.bayes_factor_10, "higher": test.mean > 0,
    }  # fmt: skip


def _paired_t(samples: Any, _: Plan, alternative: Alternative, confidence: float) -> Row | None:
    found = paired_t(
        samples.differences, samples.unit, alternative=alternative, confidence=confidence
    )
    return _t(found)


def _groups_t(
    samples: Any, _: Plan, alternative: Alternative, confidence: float, variances: Variances
) -> Row | None:
    found = two_sample_t(
        samples.a, samples.b, samples.unit, variances=variances, alternative=alternative,
        confidence=confidence,
    )  # fmt: skip
    return _t(found)


TESTS: dict[str, Callable[[Any, Plan, Alternative, float], Row | None]] = {
    "mann_whitney": _mann_whitney,
    "welch_t": partial(_groups_t, variances="welch"),
    "student_t": partial(_groups_t, variances="pooled"),
    "paired_t": _paired_t,
    "sign": _sign,
}


def _smallest_of_ranks(samples: Any, plan: Plan, alternative: Alternative) -> float:
    """Return p as it would be if everybody of one group were above everybody of the other."""
    ordered, n, m = np.sort(np.concatenate([samples.a, samples.b])), samples.a.size, samples.b.size
    ways = [(ordered[:n], ordered[n:]), (ordered[m:], ordered[:m])]
    tests = [
        mann_whitney(a, b, alternative=alternative, p_value=plan.p_value, intervals=False)
        for a, b in ways
    ]
    return min(test.p for test in tests if test is not None)


def _smallest_of_signs(samples: Any, _: Plan, alternative: Alternative) -> float:
    """Return p as it would be if all who differ did so in one direction."""
    one_way = np.abs(samples.differences) * (-1 if alternative == "less" else 1)
    return sign_test(one_way, alternative=alternative).p


def _any_p(*_: object) -> float:
    return 0.0


SMALLEST_P: dict[str, Callable[[Any, Plan, Alternative], float]] = {
    "mann_whitney": _smallest_of_ranks,
    "sign": _smallest_of_signs,
}
"""The smallest p that so many people can give; t tests have none."""
