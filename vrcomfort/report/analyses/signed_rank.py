"""Wilcoxon's signed-rank tests of a plan's contrasts of pairs, with t tests of the same pairs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    Sentence,
)
from vrcomfort.report.descriptives import Description, DescriptionWithInterval, describe
from vrcomfort.report.families import (
    Decision,
    difference_in_words,
    disagreement,
    interval_title,
    mean_and_sd,
    p_in_words,
    too_few_in_words,
)
from vrcomfort.report.orders import OneOrder, in_words, one_order
from vrcomfort.report.pairs import Pairs, Side, needed_of, pair_up
from vrcomfort.report.rows import HIDDEN, INLINE
from vrcomfort.report.withdrawals import lost_signs
from vrcomfort.report.words import NONE, fraction, interval, number
from vrcomfort.stats.ranks import fewest_for_interval
from vrcomfort.stats.signed_rank import SignedRank, signed_rank, worst_rank
from vrcomfort.stats.t_tests import paired_t

if TYPE_CHECKING:
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.effects import EffectSize
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.shift import Shift
    from vrcomfort.stats.signed_rank import Zeros

FEWEST_PAIRS = 2
_DESCRIBED = ("mean", "mean_low", "mean_high", "sd", "median", "q1", "q3")


@dataclass(frozen=True)
class SignedRankIntervals:
    """The estimates with intervals of one level."""

    shift: Shift | None
    effect: EffectSize | None


@dataclass(frozen=True)
class OtherZeros:
    """The test with the other rule for pairs without a difference."""

    test: SignedRank = field(metadata=INLINE)
    p: float
    method: str


@dataclass(frozen=True)
class PairedTTest:
    """The t test of the same pairs."""

    n: int
    mean: float
    standard_error: float
    df: int
    t: float
    p: float
    low: float | None
    high: float | None
    confidence: float
    alternative: str
    cohen_dz: float
    bayes_factor_10: float


@dataclass(frozen=True)
class SignedRankFound:
    """The numbers of a test.

    Parameters
    ----------
    descriptives
        Of both sides, by name, and of the difference.
    t_test
        None where no difference varies.
    """

    zeros: int
    ties: int
    zero_method: str
    w_plus: float
    w_minus: float
    z: float | None
    p_exact: float | None
    p_asymptotic: float
    shift: Shift | None
    effect: EffectSize | None
    method: str
    descriptives: dict[str, Description]
    other_zeros: OtherZeros
    t_test: PairedTTest | None


@dataclass(frozen=True)
class SignedRankRow:
    """One contrast, tested on one outcome.

    Parameters
    ----------
    ranked_worst
        Participants who withdrew, and are ranked as worst.
    confounded
        The order in which nearly all met the two conditions, if it is one.
    needed, confidence, shift_interval
        Scores of each side that a participant needs; the plan's choices.
    """

    a: str
    b: str
    outcome: str
    kind: str
    sides: tuple[Side, Side]
    n: int
    participants: tuple[str, ...]
    ranked_worst: tuple[str, ...]
    exposures_per_condition: dict[str, int]
    alternative: Alternative
    p: float | None
    not_tested: str | None
    confounded: OneOrder | None
    decision: Decision[SignedRankIntervals] = field(metadata=INLINE)
    found: SignedRankFound | None = field(metadata=INLINE)
    needed: tuple[int, int] = field(metadata=HIDDEN)
    confidence: float = field(metadata=HIDDEN)
    shift_interval: str = field(metadata=HIDDEN)

    @property
    def reported(self) -> SignedRankIntervals | SignedRankFound | None:
        """Return the estimates with the intervals that belong to the p that decides."""
        return self.decision.simultaneous or self.found


def _compute(data: AnalysisData, _: Sequence[object]) -> list[SignedRankRow]:
    return [
        _row(data, contrast, outcome.name)
        for contrast in data.contrasts
        if contrast.test == "signed_rank"
        for outcome in data.scored.outcomes
    ]


def _row(data: AnalysisData, contrast: Compared, outcome: str) -> SignedRankRow:
    scored, plan, a, b = data.scored, data.plan, contrast.a, contrast.b
    pairs = pair_up(scored, outcome, a, b, complete=data.complete)
    signs = _ranked_worst(pairs, plan, lost_signs(data.withdrawals, a.name, b.name))
    planned = {side.name: needed_of(scored, outcome, side) for side in (a, b)}
    needed = (planned[a.name], planned[b.name]) if data.complete else (1, 1)
    confounded = None
    if contrast.of_conditions:
        people = pairs.participants
        confounded = scored.looked_up(
            ("confounded", a, b, people),
            lambda: one_order(scored.table, a.name, b.name, people),
        )
    row = SignedRankRow(
        a.name, b.name, outcome, "paired", (a, b), len(pairs.participants) + len(signs),
        (*pairs.participants, *signs), tuple(signs), planned, contrast.alternative, None, None,
        confounded, Decision(), None, needed, plan.confidence, plan.shift_interval,
    )  # fmt: skip
    if len(pairs.participants) < FEWEST_PAIRS:
        return replace(row, not_tested=_too_few(scored, outcome, contrast, len(pairs.participants)))
    return _tested(row, pairs, plan, list(signs.values()))


def _tested(row: SignedRankRow, pairs: Pairs, plan: Plan, signs: list[int]) -> SignedRankRow:
    """Return a row with its test; with withdrawals, shift and r stay those of who answered."""
    test = _signed_rank(pairs, plan, row.alternative, plan.confidence)
    ranked = test
    if signs:
        ranked = worst_rank(
            pairs.differences, signs, zeros=plan.zeros, alternative=row.alternative,
            p_value=plan.p_value,
        )  # fmt: skip
    t_test = _t_test(pairs, plan, row.alternative)
    found = SignedRankFound(
        ranked.zeros, ranked.ties, test.zero_method, ranked.w_plus, ranked.w_minus, ranked.z,
        ranked.p_exact, ranked.p_asymptotic, test.shift, test.effect, ranked.method,
        describe_pairs(pairs, (row.a, row.b), t_test),
        _other_zeros(pairs, plan, row.alternative), t_test,
    )  # fmt: skip
    decision: Decision[SignedRankIntervals] = Decision(
        smallest_p=_smallest_p(pairs, len(signs), plan, row.alternative),
        higher=ranked.w_plus > ranked.w_minus,
    )
    return replace(row, p=ranked.p, decision=decision, found=found)


def with_intervals(data: AnalysisData, rows: Sequence[SignedRankRow]) -> list[SignedRankRow]:
    """Return rows with the intervals of the level at which each decides in its family."""
    return [_with_intervals(data, row) for row in rows]


def _with_intervals(data: AnalysisData, row: SignedRankRow) -> SignedRankRow:
    level, plan = row.decision.level, data.plan
    if level is None or level >= 1 - plan.confidence:
        return row
    pairs = pair_up(data.scored, row.outcome, *row.sides, complete=plan.needs_every_score)
    test = _signed_rank(pairs, plan, row.alternative, 1 - level)
    intervals = SignedRankIntervals(test.shift, test.effect)
    return replace(row, decision=replace(row.decision, simultaneous=intervals))


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


def _other_zeros(pairs: Pairs, plan: Plan, alternative: Alternative) -> OtherZeros:
    other: Zeros = "wilcox" if plan.zeros == "pratt" else "pratt"
    test = signed_rank(
        pairs.differences,
        zeros=other,
        alternative=alternative,
        p_value=plan.p_value,
        intervals=False,
    )
    return OtherZeros(test, test.p, test.method)


def _t_test(pairs: Pairs, plan: Plan, alternative: Alternative) -> PairedTTest | None:
    found = paired_t(
        pairs.differences, pairs.unit, alternative=alternative, confidence=plan.confidence
    )
    if found is None:
        return None
    return PairedTTest(
        found.n, found.mean, found.standard_error, int(found.df), found.t, found.p, found.low,
        found.high, found.confidence, found.alternative, found.cohen_d, found.bayes_factor_10,
    )  # fmt: skip


def describe_pairs(
    pairs: Pairs, names: tuple[str, str], t_test: PairedTTest | None
) -> dict[str, Description]:
    """Return mean, spread and quartiles of both conditions and of the differences, in points.

    The interval of the mean difference is that of its t test: a report has no other.
    """
    low, high = (t_test.low, t_test.high) if t_test else (None, None)
    return {
        names[0]: describe(pairs.a * pairs.unit),
        names[1]: describe(pairs.b * pairs.unit),
        "difference": DescriptionWithInterval(
            **vars(describe(pairs.differences * pairs.unit)), mean_low=low, mean_high=high
        ),
    }


def _sentences(row: SignedRankRow, words: Vocabulary) -> Iterator[Sentence]:
    a, b = words.condition(row.a), words.condition(row.b)
    name, found = words.outcome(row.outcome), row.found
    if found is None:
        yield Sentence(f"{name}: {a} and {b} could not be compared ({row.not_tested}).")
        return
    if found.effect is None and not row.ranked_worst:
        yield Sentence(f"{name}: nobody’s score differed between {a} and {b} (n = {row.n}).")
        return
    size, few = found.descriptives, too_few_in_words(row.decision, row.confidence, found.zeros)
    of_a, of_b = f"{a} ({mean_and_sd(size[row.a])})", f"{b} ({mean_and_sd(size[row.b])})"
    said = difference_in_words(row.decision, of_a, of_b, "under", few)
    order = f" But {in_words(row.confounded, words.condition)}." if row.confounded else ""
    yield Sentence(
        f"{name}: {said}; {_shift(row, words)}, n\u00a0=\u00a0{row.n}.",
        f"{found.method.capitalize()} {p_in_words(row.p, row.decision)}; Z\u00a0=\u00a0"
        f"{number(found.z)}, r\u00a0=\u00a0{_rank_biserial(row, words)}.{order}",
    )


def _shift(row: SignedRankRow, words: Vocabulary) -> str:
    shift = row.reported.shift if row.reported else None
    whose = ""
    if row.ranked_worst:
        stayed = row.n - len(row.ranked_worst)
        whose = f" of the {stayed} who stayed (the test ranks those who left as worst)"
    percent, found = interval_title(row.decision, row.confidence), interval(shift)
    estimate = number(shift.estimate if shift else None)
    of = f"difference{whose} {estimate} {words.unit(row.outcome)}".rstrip()
    if found == NONE:
        return f"{of} (no {percent}: too few differences)"
    return f"{of}, {percent} {found}{disagreement(row.decision.verdict, shift)}"


def _rank_biserial(row: SignedRankRow, words: Vocabulary) -> str:
    effect = row.reported.effect if row.reported else None
    if effect is None:
        return f"{NONE} (nobody’s score differed)"
    r = fraction(effect.estimate)
    if effect.low is not None:
        return f"{r} {interval(effect, bounded=True)}{disagreement(row.decision.verdict, effect)}"
    few = row.n - (row.found.zeros if row.found else 0) < fewest_for_interval(effect.confidence)
    a = words.condition(row.a)
    reason = "too few differences other than 0" if few else f"{a} has no score but 0"
    return f"{r} (no {interval_title(row.decision, row.confidence)}: {reason})"


def _csv(row: SignedRankRow) -> Iterator[Cells]:
    found, decision = row.found, row.decision
    shift = found.shift if found else None
    effect = found.effect if found else None
    holm = decision.simultaneous
    cells: dict[str, object] = {
        "a": row.a, "b": row.b, "outcome": row.outcome, "n": row.n,
        "zeros": found and found.zeros, "ties": found and found.ties,
        "zero_method": found and found.zero_method, "alternative": row.alternative,
        "w_plus": found and found.w_plus, "w_minus": found and found.w_minus,
        "z": found and found.z, "p_exact": found and found.p_exact,
        "p_asymptotic": found and found.p_asymptotic, "p": row.p,
        "method": found and found.method, "p_holm": decision.p_holm,
        **_interval("hodges_lehmann", shift),
        "hodges_lehmann_low_closed": shift and shift.low_closed,
        "hodges_lehmann_high_closed": shift and shift.high_closed,
        "hodges_lehmann_holds_rejected_zero": shift and shift.holds_rejected_zero,
        **_interval("rank_biserial", effect),
        "verdict": decision.verdict, "smallest_p": decision.smallest_p, "level": decision.level,
        **_ends("hodges_lehmann_holm", holm.shift if holm else None),
        **_ends("rank_biserial_holm", holm.effect if holm else None),
    }  # fmt: skip
    for name, described in (found.descriptives if found else {}).items():
        cells |= {
            f"{stat}_{name}": getattr(described, stat)
            for stat in _DESCRIBED
            if hasattr(described, stat)
        }
    yield {
        **cells,
        "planned_a": row.needed[0],
        "planned_b": row.needed[1],
        "timepoint_a": row.sides[0].timepoint or None,
        "timepoint_b": row.sides[1].timepoint or None,
        "ranked_worst": len(row.ranked_worst),
        "confidence": row.confidence,
        "shift_interval": row.shift_interval,
        "family": decision.family,
        "not_tested": row.not_tested,
    }


def _interval(name: str, found: Shift | EffectSize | None) -> Cells:
    return {name: found and found.estimate, **_ends(name, found)}


def _ends(name: str, found: Shift | EffectSize | None) -> Cells:
    return {f"{name}_low": found and found.low, f"{name}_high": found and found.high}


def _csv_of_t(row: SignedRankRow) -> Iterator[Cells]:
    if row.found and row.found.t_test:
        yield {"a": row.a, "b": row.b, "outcome": row.outcome, **asdict(row.found.t_test)}


TESTS: Analysis[SignedRankRow] = Analysis(
    "tests",
    AnalysisSet.COMPLETE_PAIRS,
    _compute,
    tables=(AnalysisTable("tests", csv=_csv), AnalysisTable("t_tests", csv=_csv_of_t)),
    place=0,
    by_outcome=True,
    sentences=_sentences,
    analysed=lambda row: row.participants,
)
