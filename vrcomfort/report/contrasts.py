"""The paired tests of a plan: primary, and what they become under other choices."""

from __future__ import annotations

from dataclasses import asdict
from itertools import combinations
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.descriptives import describe, describe_with_interval
from vrcomfort.report.ordering import natural
from vrcomfort.report.pairs import pair_up
from vrcomfort.report.plan import Contrast
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.signed_rank import signed_rank
from vrcomfort.stats.withdrawal import worst_rank

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.pairs import Pairs
    from vrcomfort.report.plan import Plan
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.signed_rank import SignedRank, Zeros

FEWEST_PAIRS = 2
AVAILABLE = "all with a score in both conditions (means of unequal numbers)"
WORST_RANK = "withdrawal ranked as the worst outcome of its condition"
WORST_CASE = "worst case: every withdrawal counted against the observed direction"

TAKEN = "item"


def conditions_of(table: pd.DataFrame, labels: dict[str, str]) -> list[str]:
    """Return the conditions in the data, in the protocol's order, then alphabetical.

    Raises
    ------
    InputError
        If one has the name of a column that stands beside those of the conditions.
    """
    order = {name: place for place, name in enumerate(labels)}
    found = {str(name) for name in table["condition"].unique()}
    if TAKEN in found:
        message = f"a condition is called `{TAKEN}`, as a column of the table of symptoms is"
        raise InputError(f"{message}; give it another name")
    return sorted(found, key=lambda name: (order.get(name, len(order)), natural(name)))


def contrasts_of(plan: Plan, conditions: list[str], labels: dict[str, str]) -> list[Contrast]:
    """Return the plan's contrasts, or every pair of the conditions in the data.

    A condition of the study (`labels`) that nobody finished is compared all the same, so that the
    report says why there is no test.

    Raises
    ------
    InputError
        If the plan compares a condition that neither the data nor the study have.
    """
    there = list(dict.fromkeys([*conditions, *labels]))
    for contrast in plan.contrasts:
        absent = [name for name in (contrast.a, contrast.b) if name not in there]
        if absent:
            known = ", ".join(there)
            raise InputError(
                f"the analysis plan compares condition `{absent[0]}`; the data have {known}"
            )
    return list(plan.contrasts) or [Contrast(a=a, b=b) for a, b in combinations(conditions, 2)]


def run_tests(scored: Exposures, plan: Plan, contrasts: list[Contrast]) -> list[dict[str, Any]]:
    """Test every outcome in every contrast on participants with all exposures; adjust (Holm)."""
    tests = [
        _test(scored, plan, contrast, outcome)
        for contrast in contrasts
        for outcome in plan.outcomes
    ]
    family = [t["p"] if t["outcome"] in plan.family else None for t in tests]
    for test, adjusted in zip(tests, holm(family), strict=True):
        test["p_holm"] = adjusted
    return tests


def _test(scored: Exposures, plan: Plan, contrast: Contrast, outcome: str) -> dict[str, Any]:
    planned = scored.planned
    pairs = pair_up(scored, outcome, contrast.a, contrast.b, complete=planned)
    result: dict[str, Any] = {
        "a": contrast.a,
        "b": contrast.b,
        "outcome": outcome,
        "n": len(pairs.participants),
        "participants": list(pairs.participants),
        "exposures_per_condition": {c: planned.get(c, 0) for c in (contrast.a, contrast.b)},
        "p": None,
        "not_tested": None,
        "confounded": _confounded(scored.table, contrast, pairs.participants),
    }
    if len(pairs.participants) < FEWEST_PAIRS:
        result["not_tested"] = f"{len(pairs.participants)} complete pairs: too few for a test"
        return result
    test = signed_rank(
        pairs.differences,
        pairs.unit,
        zeros=plan.zeros,
        alternative=plan.alternative,
        confidence=plan.confidence,
        shift_interval=plan.shift_interval,
        effect_interval=(
            "normal_shift" if plan.rank_biserial_interval == "normal_shift" else "fisher_z"
        ),
        interval_n=_interval_n(pairs, plan),
    )
    return {
        **result,
        **describe_test(test),
        "descriptives": describe_pairs(pairs, contrast, plan.confidence),
        "other_zeros": _other_zeros(pairs, plan),
    }


def _confounded(
    table: pd.DataFrame, contrast: Contrast, participants: tuple[str, ...]
) -> str | None:
    """Say so if everybody in a test met one condition before the other: it may be their order."""
    part = table[table["participant"].isin(participants) & (table["position"] > 0)]
    part = part.sort_values(
        ["session", "position"],
        key=lambda column: column.map(natural) if column.name == "session" else column,
    )
    part = part.assign(place=part.groupby("participant").cumcount())
    places = part.groupby(["participant", "condition"])["place"].mean().unstack()  # noqa: PD010
    if not {contrast.a, contrast.b} <= set(places.columns):
        return None
    gaps = (places[contrast.a] - places[contrast.b]).dropna()
    if gaps.empty or gaps.min() <= 0 <= gaps.max():
        return None
    first, second = (contrast.a, contrast.b) if gaps.max() < 0 else (contrast.b, contrast.a)
    return (
        f"everybody met {first} before {second}, so that their difference cannot be told from one "
        "of order"
    )


def _interval_n(pairs: Pairs, plan: Plan) -> int | None:
    return int(np.count_nonzero(pairs.a)) if plan.rank_biserial_interval == "effectsize" else None


def _other_zeros(pairs: Pairs, plan: Plan) -> dict[str, Any]:
    other: Zeros = "wilcox" if plan.zeros == "pratt" else "pratt"
    test = signed_rank(
        pairs.differences, zeros=other, alternative=plan.alternative, intervals=False
    )
    return describe_test(test)


def describe_test(test: SignedRank) -> dict[str, Any]:
    """Return a test as the plain values of results.json."""
    found = asdict(test)
    return {**found, "p": test.p, "method": test.method}


def describe_pairs(
    pairs: Pairs, contrast: Contrast, confidence: float
) -> dict[str, dict[str, float | None]]:
    """Return mean, spread and quartiles of both conditions and of the differences, in points."""
    return {
        contrast.a: describe(pairs.a * pairs.unit),
        contrast.b: describe(pairs.b * pairs.unit),
        "difference": describe_with_interval(pairs.differences * pairs.unit, confidence),
    }


def sensitivity(
    scored: Exposures, plan: Plan, test: dict[str, Any], lost: dict[str, int]
) -> list[dict[str, Any]]:
    """Repeat one test on other sets of people.

    Parameters
    ----------
    lost
        Participants without a pair who withdrew: 1 if under a, −1 if under b, 0 if unknown.
    """
    if test["not_tested"]:
        return []
    a, b, outcome = test["a"], test["b"], test["outcome"]
    primary = pair_up(scored, outcome, a, b, complete=scored.planned)
    available = pair_up(scored, outcome, a, b)
    found = {AVAILABLE: signed_rank(available.differences, **_options(plan))}
    gone = [sign for person, sign in lost.items() if person not in primary.participants]
    if gone:
        against = -1 if test["w_plus"] >= test["w_minus"] else 1
        assumed = {WORST_RANK: gone, WORST_CASE: [against] * len(gone)}
        found |= {
            what: worst_rank(
                primary.differences, signs, zeros=plan.zeros, alternative=plan.alternative
            )
            for what, signs in assumed.items()
        }
    return [_line(what, result, test) for what, result in found.items()]


class _Options(TypedDict):
    zeros: Zeros
    alternative: Alternative
    intervals: bool


def _options(plan: Plan) -> _Options:
    return {"zeros": plan.zeros, "alternative": plan.alternative, "intervals": False}


def _line(what: str, result: SignedRank, test: dict[str, Any]) -> dict[str, Any]:
    same = {key: test[key] for key in ("a", "b", "outcome")}
    return {**same, "analysis": what, "n": result.n, "z": result.z, "p": result.p}
