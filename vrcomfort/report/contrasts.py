"""The paired tests of a plan."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.descriptives import describe
from vrcomfort.report.families import UNDECIDED, add_intervals
from vrcomfort.report.ordering import natural
from vrcomfort.report.orders import one_order
from vrcomfort.report.pairs import Pairs, Side, needed_of, pair_up, sides_of
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.signed_rank import signed_rank, worst_rank
from vrcomfort.stats.t_tests import paired_t

if TYPE_CHECKING:
    from collections.abc import Callable

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Contrast, Plan
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.signed_rank import SignedRank, Zeros

    Test = dict[str, Any]
    Lost = Callable[[str, str], dict[str, int]]

FEWEST_PAIRS = 2
TAKEN = {"item": "a column of the table of symptoms", "difference": "a column of the tests"}
"""What conditions cannot be called, and what is called so."""


@dataclass(frozen=True)
class Compared:
    """A contrast as it is made with the data."""

    a: Side
    b: Side
    alternative: Alternative
    between: str = ""
    """The column that groups people; blank: the same people met both sides."""
    test: str = "signed_rank"

    @property
    def of_conditions(self) -> bool:
        """Whether both sides are conditions at the plan's moment after exposure."""
        return not (self.a.timepoint or self.b.timepoint or self.between)


def conditions_of(scored: Exposures, labels: dict[str, str]) -> list[str]:
    """Return the conditions in the data, in the protocol's order, then alphabetical.

    Raises
    ------
    InputError
        If one has the name of a column that stands beside those of the conditions.
    """
    order = {name: place for place, name in enumerate(labels)}
    found = {str(name) for name in scored.table["condition"].unique()} - {""}
    for name in sorted(found & TAKEN.keys()):
        message = f"a condition is called `{name}`, as {TAKEN[name]} is"
        raise InputError(f"{message}; give it another name")
    return sorted(found, key=lambda name: (order.get(name, len(order)), natural(name)))


def contrasts_of(plan: Plan, conditions: list[str], there: list[str]) -> list[Compared]:
    """Return the plan's contrasts, or every pair of the conditions in the data.

    A condition of the study (`there`) that nobody finished is compared all the same, so that the
    report says why there is no test.

    Raises
    ------
    InputError
        If the plan compares a condition that neither the data nor the study have.
    """
    for index, contrast in enumerate(plan.contrasts):
        groups = contrast.between and contrast.between != "condition"
        sides = [] if groups else [("a", contrast.a), ("b", contrast.b)]
        for key, name in (*sides, ("condition", contrast.condition)):
            if name and name not in there:
                hint = did_you_mean(name, there)
                hint = f"; {hint}" if hint.startswith("did") else ""
                message = (
                    f"the analysis plan compares condition `{name}`; the data have "
                    f"{', '.join(there)}{hint}"
                )
                raise plan.fault(message, "contrasts", index, key)
    pairs = [Compared(Side(a), Side(b), plan.alternative) for a, b in combinations(conditions, 2)]
    return [_compared(each, plan) for each in plan.contrasts] or pairs


def _compared(contrast: Contrast, plan: Plan) -> Compared:
    """Return the sides; those at one moment after exposure have the scores of the plan."""
    alternative = contrast.alternative or plan.alternative
    if contrast.between:
        sides = sides_of(contrast.between, contrast.a, contrast.b, contrast.condition)
        test = contrast.test or "mann_whitney"
        return Compared(*sides, alternative, contrast.between, test)
    test = contrast.test or "signed_rank"
    moments = [
        name or plan.exposure_timepoint for name in (contrast.a_timepoint, contrast.b_timepoint)
    ]
    if set(moments) == {plan.exposure_timepoint}:
        return Compared(Side(contrast.a), Side(contrast.b), alternative, test=test)
    sides = Side(contrast.a, moments[0]), Side(contrast.b, moments[1])
    return Compared(*sides, alternative, test=test)


def run_tests(scored: Exposures, plan: Plan, contrasts: list[Compared], lost: Lost) -> list[Test]:
    """Test every outcome in every contrast.

    Parameters
    ----------
    lost
        Contrast's names of sides → participants who withdrew: 1 if under a, −1 if under b, 0 if
        unknown; for plans that rank them.
    """
    return [
        _test(scored, plan, contrast, outcome.name, lost)
        for contrast in contrasts
        for outcome in scored.outcomes
    ]


def _test(scored: Exposures, plan: Plan, contrast: Compared, outcome: str, lost: Lost) -> Test:
    a, b = contrast.a, contrast.b
    pairs = pair_up(scored, outcome, a, b, complete=plan.needs_every_score)
    signs = _ranked_worst(pairs, plan, lost(a.name, b.name))
    result: dict[str, Any] = {
        "a": a.name,
        "b": b.name,
        "outcome": outcome,
        "kind": "paired",
        "sides": [asdict(a), asdict(b)],
        "n": len(pairs.participants) + len(signs),
        "participants": [*pairs.participants, *signs],
        "ranked_worst": list(signs),
        "exposures_per_condition": {s.name: needed_of(scored, outcome, s) for s in (a, b)},
        "alternative": contrast.alternative,
        "p": None,
        "not_tested": None,
        "confounded": None,
        **UNDECIDED,
    }
    if contrast.of_conditions:
        people = pairs.participants
        result["confounded"] = scored.looked_up(
            ("confounded", a, b, people),
            lambda: one_order(scored.table, a.name, b.name, people),
        )
    if len(pairs.participants) < FEWEST_PAIRS:
        result["not_tested"] = _too_few(scored, outcome, contrast, len(pairs.participants))
        return result
    test = _signed_rank(pairs, plan, contrast.alternative, plan.confidence)
    worst = _worst_rank(pairs, list(signs.values()), plan, contrast.alternative) if signs else {}
    t_test = _t_test(pairs, plan, contrast.alternative)
    found = {
        **result,
        **describe_test(test),
        **worst,
        "n": result["n"],
        "smallest_p": _smallest_p(pairs, len(signs), plan, contrast.alternative),
        "descriptives": describe_pairs(pairs, contrast, t_test),
        "other_zeros": _other_zeros(pairs, plan, contrast.alternative),
        "t_test": t_test,
    }
    return {**found, "higher": found["w_plus"] > found["w_minus"]}


def add_intervals_of_tests(
    scored: Exposures, plan: Plan, contrasts: list[Compared], tests: list[Test]
) -> None:
    """Add to every test in a family the intervals of the level at which it decides.

    Parameters
    ----------
    tests
        As `run_tests` returns them.
    """
    of_each = (contrast for contrast in contrasts for _ in scored.outcomes)
    for contrast, test in zip(of_each, tests, strict=True):

        def again(confidence: float, contrast: Compared = contrast, test: Test = test) -> Test:
            sides, complete = (contrast.a, contrast.b), plan.needs_every_score
            pairs = pair_up(scored, test["outcome"], *sides, complete=complete)
            return asdict(_signed_rank(pairs, plan, contrast.alternative, confidence))

        add_intervals(test, 1 - plan.confidence, again)


def _too_few(scored: Exposures, outcome: str, contrast: Compared, n: int) -> str:
    """Say why there is no test; and, where different people met the sides, what there is."""
    said = f"{n} complete pairs: too few for a test"
    rows = [side.rows(scored).dropna(subset=[outcome]) for side in (contrast.a, contrast.b)]
    one, two = (set(table["participant"]) for table in rows)
    if one and two and one.isdisjoint(two):
        said += ' (different people met them: see the ANOVA with kind = "between")'
    return said


def _ranked_worst(pairs: Pairs, plan: Plan, lost: dict[str, int]) -> dict[str, int]:
    if plan.withdrawals != "worst_rank":
        return {}
    return {who: sign for who, sign in lost.items() if who not in pairs.participants}


def _signed_rank(
    pairs: Pairs, plan: Plan, alternative: Alternative, confidence: float
) -> SignedRank:
    return signed_rank(
        pairs.differences,
        pairs.unit,
        zeros=plan.zeros,
        alternative=alternative,
        p_value=plan.p_value,
        confidence=confidence,
        shift_interval=plan.shift_interval,
        effect_interval=(
            "normal_shift" if plan.rank_biserial_interval == "normal_shift" else "fisher_z"
        ),
        interval_n=_interval_n(pairs, plan),
    )


def _worst_rank(
    pairs: Pairs, signs: list[int], plan: Plan, alternative: Alternative
) -> dict[str, Any]:
    """Return the p of the test with withdrawals; shift and r stay those of who answered."""
    test = worst_rank(
        pairs.differences, signs, zeros=plan.zeros, alternative=alternative, p_value=plan.p_value
    )
    keep = ("w_plus", "w_minus", "z", "zeros", "ties", "p_exact", "p_asymptotic", "p", "method")
    return {name: value for name, value in describe_test(test).items() if name in keep}


def _smallest_p(pairs: Pairs, withdrawn: int, plan: Plan, alternative: Alternative) -> float:
    """Return p as it would be if all who differ did so in one direction."""
    one_way = np.abs(pairs.differences) * (-1 if alternative == "less" else 1)
    signs = [-1 if alternative == "less" else 1] * withdrawn
    if withdrawn:
        return worst_rank(
            one_way, signs, zeros=plan.zeros, alternative=alternative, p_value=plan.p_value
        ).p
    return signed_rank(
        one_way, zeros=plan.zeros, alternative=alternative, p_value=plan.p_value, intervals=False
    ).p


def _interval_n(pairs: Pairs, plan: Plan) -> int | None:
    return int(np.count_nonzero(pairs.a)) if plan.rank_biserial_interval == "effectsize" else None


def _other_zeros(pairs: Pairs, plan: Plan, alternative: Alternative) -> dict[str, Any]:
    other: Zeros = "wilcox" if plan.zeros == "pratt" else "pratt"
    test = signed_rank(
        pairs.differences,
        zeros=other,
        alternative=alternative,
        p_value=plan.p_value,
        intervals=False,
    )
    return describe_test(test)


def _t_test(pairs: Pairs, plan: Plan, alternative: Alternative) -> dict[str, Any] | None:
    """Return the t test of the same pairs; None where no difference varies."""
    found = paired_t(
        pairs.differences, pairs.unit, alternative=alternative, confidence=plan.confidence
    )
    if found is None:
        return None
    return {
        "n": found.n, "mean": found.mean, "standard_error": found.standard_error,
        "df": int(found.df), "t": found.t, "p": found.p, "low": found.low, "high": found.high,
        "confidence": found.confidence, "alternative": found.alternative,
        "cohen_dz": found.cohen_d, "bayes_factor_10": found.bayes_factor_10,
    }  # fmt: skip


def describe_test(test: SignedRank) -> dict[str, Any]:
    """Return a test as the plain values of results.json."""
    found = asdict(test)
    return {**found, "p": test.p, "method": test.method}


def describe_pairs(
    pairs: Pairs, contrast: Compared, t_test: Test | None
) -> dict[str, dict[str, float | None]]:
    """Return mean, spread and quartiles of both conditions and of the differences, in points.

    The interval of the mean difference is that of its t test: a report has no other.
    """
    low, high = (t_test["low"], t_test["high"]) if t_test else (None, None)
    return {
        contrast.a.name: describe(pairs.a * pairs.unit),
        contrast.b.name: describe(pairs.b * pairs.unit),
        "difference": {
            **describe(pairs.differences * pairs.unit),
            "mean_low": low,
            "mean_high": high,
        },
    }
