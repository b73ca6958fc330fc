"""Wilcoxon's signed-rank tests of a plan's contrasts of pairs, with t tests of the same pairs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from markupsafe import Markup

from vrcomfort.report.analyses.contract import (
    ITALIC_N,
    ITALIC_P,
    P_HOLM,
    WITHOUT_ZERO,
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    ReportContext,
    Sentence,
    TableColumn,
    decided_interval,
    html,
    interval_heading,
    is_holed,
    starred_p,
    with_dot,
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
from vrcomfort.report.words import (
    NONE,
    bayes_factor,
    degrees,
    fraction,
    interval,
    number,
    p_value,
)
from vrcomfort.stats.ranks import fewest_for_interval
from vrcomfort.stats.signed_rank import EXACT_UP_TO, SignedRank, signed_rank, worst_rank
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
    """Return a row with its test; shift and r leave out withdrawals that are ranked as worst."""
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


def _intervals(data: AnalysisData, row: SignedRankRow, level: float) -> SignedRankIntervals:
    pairs = pair_up(data.scored, row.outcome, *row.sides, complete=data.complete)
    test = _signed_rank(pairs, data.plan, row.alternative, 1 - level)
    return SignedRankIntervals(test.shift, test.effect)


def _too_few(scored: Exposures, outcome: str, contrast: Compared, n: int) -> str:
    """Return the reason for having no test, and the analysis to look at instead."""
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
    """Return the smallest p of these differences: all in one direction."""
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


_SIDES = {
    "two-sided": "two-sided",
    "greater": "one-sided (higher scores under the first condition)",
    "less": "one-sided (lower scores under the first condition)",
}


def _methods(rows: Sequence[SignedRankRow], report: ReportContext) -> Iterator[MethodsParagraph]:
    if any(row.found for row in rows):
        yield from (
            _test_paragraph(rows, report),
            _shift_paragraph(report.plan),
            _effect_paragraph(report.plan),
        )
    if any(row.found and row.found.t_test for row in rows):
        yield _t_test_paragraph()


def _test_paragraph(rows: Sequence[SignedRankRow], report: ReportContext) -> MethodsParagraph:
    plan = report.plan
    pratt = plan.zeros == "pratt"
    zeros = (
        "pairs without a difference were ranked and then dropped (Pratt, 1959)"
        if pratt
        else "pairs without a difference were dropped before ranking (Wilcoxon, 1945)"
    )
    asked = dict.fromkeys(row.alternative for row in rows)
    sides = _SIDES[next(iter(asked))] if len(asked) == 1 else "two-sided or one-sided as marked"
    text = (
        f"Conditions were compared with Wilcoxon signed-rank tests, {sides}. Ranks were taken on "
        f"integer raw sums, so ties are exact; {zeros}; p is {_exactness(rows)} (Hollander et "
        "al., 2014); Z is tie-corrected, without continuity correction. "
        f"{_families(plan, report.words)}"
    )
    first = "pratt_1959" if pratt else "wilcoxon_1945"
    holm = ("holm_1979",) if _is_adjusted(plan) else ()
    return MethodsParagraph("Tests", text, (first, "wilcoxon_1945", "hollander_2014", *holm))


def _is_adjusted(plan: Plan) -> bool:
    return any(each.method == "holm" for each in plan.families)


def _families(plan: Plan, words: Vocabulary) -> str:
    """Say over what p values were adjusted."""
    holm = [each for each in plan.families if each.method == "holm"]
    if not holm:
        return "p values are not adjusted."
    named = [
        ", ".join(map(words.outcome, each.outcomes))
        + (" and every effect of its ANOVA" if "anova" in each.analyses else "")
        for each in holm
    ]
    over = "; and, apart from these, ".join(named)
    return (
        f"p values were adjusted with Holm’s (1979) method over {over}; each time over all "
        "comparisons."
    )


def _exactness(rows: Sequence[SignedRankRow]) -> str:
    """Say how p was found in the tests that were made."""
    made = {row.found.method for row in rows if row.found}
    exact = "from the exact permutation distribution given the ties"
    normal = f"from the normal approximation above {EXACT_UP_TO} pairs"
    if made == {"asymptotic"}:
        return normal
    return f"{exact}, {normal}" if "asymptotic" in made else exact


def _fewest_for_shift(plan: Plan) -> int:
    """Return the fewest differences with which a plan's interval of the shift has a bound."""
    return fewest_for_interval(plan.confidence, _sides(plan))


def _sides(plan: Plan) -> Literal[1, 2]:
    inverted = plan.shift_interval == "inverted_test"
    return 1 if inverted and plan.alternative != "two-sided" else 2


def _shift_paragraph(plan: Plan) -> MethodsParagraph:
    percent = f"{100 * plan.confidence:g} %"
    zeros = "including" if plan.zeros == "pratt" else "excluding"
    if plan.shift_interval == "inverted_test":
        how = (
            f"Its {percent} interval is the hull of the shifts that the same test, ranked anew "
            "after each shift is taken off, does not reject at its level; a round bracket is an "
            f"end that is itself rejected.{_of_holm(plan)}"
        )
    else:
        how = (
            f"Its {percent} interval is bounded by the Walsh averages at the critical ranks of the "
            "signed-rank distribution without ties, on the conservative side; with ties it may "
            "contradict p."
        )
    text = (
        "The difference in points is the Hodges–Lehmann (1963) shift, the median of the Walsh "
        f"averages, {zeros} pairs without a difference. {how} There is none below "
        f"{_fewest_for_shift(plan)} differences, because no fewer can reach such an exact "
        f"{'two' if _sides(plan) == 2 else 'one'}-sided p."
    )
    return MethodsParagraph("Differences", text, ("hodges_1963", "hollander_2014"))


def _of_holm(plan: Plan) -> str:
    """Say of which level intervals are where p values are adjusted."""
    if not _is_adjusted(plan):
        return ""
    return (
        " In a family of m tests it is of the level at which Holm’s method decides: α/(m − i + 1) "
        "of the i-th smallest p while they are rejected, α over their number of the others."
    )


def _effect_paragraph(plan: Plan) -> MethodsParagraph:
    percent = f"{100 * plan.confidence:g} %"
    kind = plan.rank_biserial_interval
    what = (
        "r is the matched-pairs rank-biserial correlation (Kerby, 2014) over non-zero differences."
    )
    if kind == "normal_shift":
        how = (
            f"Its {percent} interval holds the values of 2 P(D₁ + D₂ > 0) − 1 under which the "
            "observed r, or one farther out, is not too rare for non-zero differences D from a "
            "normal distribution of any mean, and what more an interval of arcsin r with the "
            "standard error of its pairs (Sen, 1960) holds, which needs no normal differences. It "
            "drops zeros, which the test may rank, so the two may disagree about 0. Whether there "
            "is a difference, p says."
        )
        return MethodsParagraph("Effect sizes", f"{what} {how}", ("kerby_2014", "sen_1960"))
    n = (
        "the number of non-zero scores in the first condition, as R’s effectsize counts"
        if kind == "effectsize"
        else "the number of non-zero differences"
    )
    how = (
        f"Its {percent} interval is a Fisher-z interval (Ben-Shachar et al., 2020) whose standard "
        f"error uses {n}. It is approximate, too narrow where there is an effect, and has no width "
        "at ±1. Whether there is a difference, p says."
    )
    return MethodsParagraph("Effect sizes", f"{what} {how}", ("kerby_2014", "effectsize"))


def _t_test_paragraph() -> MethodsParagraph:
    return MethodsParagraph(
        "Means",
        "Beside the signed-rank tests stand paired t tests (Student, 1908) of the same pairs, "
        "Cohen’s d_z (Lakens, 2013) and the JZS Bayes factor with a Cauchy prior of scale √2/2 "
        "(Rouder et al., 2009), the latter by pingouin (Vallat, 2018).",
        ("student_1908", "lakens_2013", "rouder_2009", "vallat_2018"),
        section="sensitivity",
    )


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


def _note(rows: Sequence[SignedRankRow], report: ReportContext) -> str:
    plan, pratt = report.plan, report.plan.zeros == "pratt"
    made = [(row.found, row.reported) for row in rows if row.found and row.reported]
    sides = list(dict.fromkeys(row.alternative for row in rows))
    asymptotic = any(found.method == "asymptotic" for found, _ in made)
    note = html(
        "Positive values: higher scores under the first condition. <i>p</i>: {}, exact{}. Zeros: "
        "{}. Difference: Hodges–Lehmann shift in points, pairs without a difference {}. <i>r</i>: "
        "matched-pairs rank-biserial correlation. A round bracket: the end itself is not in the "
        "interval.",
        sides[0] if len(sides) == 1 else "as each comparison says (two-sided, greater, less)",
        " except where marked * (asymptotic)" if asymptotic else "",
        "ranked, then dropped (Pratt)" if pratt else "dropped",
        "included" if pratt else "excluded",
    )
    note += WITHOUT_ZERO * any(is_holed(shown.shift) for _, shown in made)
    note += html(
        " An interval of the shift needs {} differences{}; – where there are fewer.",
        str(_fewest_for_shift(plan)),
        _needed_for_r(plan),
    )
    if any(row.decision.simultaneous for row in rows):
        note += html(
            " Intervals of tests with a <i>p</i> Holm are of the level at which Holm’s method "
            "decides on each, so that they say of 0 what <i>p</i> Holm says; unadjusted ones are "
            "in <code>tables/tests.csv</code>."
        )
    disagreements = sum(
        bool(disagreement(row.decision.verdict, row.reported.effect))
        for row in rows
        if row.reported
    )
    if disagreements:
        note += html(
            " The interval of <i>r</i>, which leaves out pairs without a difference, and the test "
            "disagree about 0 in {} of these tests.",
            str(disagreements),
        )
    return note


def _needed_for_r(plan: Plan) -> Markup:
    if plan.rank_biserial_interval == "normal_shift":
        return Markup()
    score = ", and a score other than 0 under the first condition"
    also = score * (plan.rank_biserial_interval == "effectsize")
    return html(" (for <i>r</i>, that are not zero{})", also)


def _group(row: SignedRankRow, rows: Sequence[SignedRankRow], report: ReportContext) -> str:
    sides = "" if len({each.alternative for each in rows}) == 1 else f" ({row.alternative})"
    return html("{} minus {}{}", *(with_dot(n, report.words) for n in (row.a, row.b)), sides)


def _caption(_: Sequence[SignedRankRow], report: ReportContext) -> str:
    mean = ", mean per exposure" if report.several else ""
    return f"Signed-rank tests of {report.words.scores}{mean}"


def _found(write: Callable[[SignedRankFound], str]) -> Callable[[SignedRankRow, object], str]:
    return lambda row, _: write(row.found) if row.found else ""


def _estimate(found: Shift | EffectSize | None) -> float | None:
    return found.estimate if found else None


def _ends_of(row: SignedRankRow, part: str, *, bounded: bool = False) -> str:
    return interval(getattr(row.reported, part, None), bounded=bounded)


_Column = TableColumn[SignedRankRow]
_TABLE: AnalysisTable[SignedRankRow, SignedRankRow] = AnalysisTable(
    "tests",
    _caption,
    (
        _Column("Score", lambda row, words: words.outcome(row.outcome)),
        _Column(ITALIC_N, lambda row, _: str(row.n)),
        _Column("zeros", _found(lambda found: str(found.zeros))),
        _Column("ties", _found(lambda found: str(found.ties))),
        _Column(Markup("<i>W</i>+"), _found(lambda found: number(found.w_plus, 1))),
        _Column(Markup("<i>W</i>−"), _found(lambda found: number(found.w_minus, 1))),
        _Column(Markup("<i>Z</i>"), _found(lambda found: number(found.z))),
        _Column(ITALIC_P, lambda row, _: starred_p(row.p, row.found.method if row.found else None)),
        _Column(P_HOLM, lambda row, _: p_value(row.decision.p_holm)),
        _Column("difference", _found(lambda found: number(_estimate(found.shift)))),
        _Column(decided_interval, lambda row, _: _ends_of(row, "shift")),
        _Column(
            Markup("<i>r</i>"),
            _found(lambda found: fraction(_estimate(found.effect))),
        ),
        _Column(decided_interval, lambda row, _: _ends_of(row, "effect", bounded=True)),
    ),
    spanning=lambda row: row.not_tested,
    labels=2,
    group=_group,
    group_key=lambda row: (row.a, row.b),
    note=_note,
    csv=_csv,
)


@dataclass(frozen=True)
class _Means:
    """A line of the table of t tests."""

    row: SignedRankRow
    test: PairedTTest


def _means(row: SignedRankRow) -> Iterator[_Means]:
    if row.found and row.found.t_test:
        yield _Means(row, row.found.t_test)


def _difference(line: _Means, words: Vocabulary) -> str:
    return f"{words.condition(line.row.a)} minus {words.condition(line.row.b)}"


_Mean = TableColumn[_Means]
_TABLE_OF_MEANS: AnalysisTable[SignedRankRow, _Means] = AnalysisTable(
    "t_tests",
    "The same pairs by their means: paired t tests, with Bayes factors",
    (
        _Mean("Score", lambda line, words: words.outcome(line.row.outcome)),
        _Mean("Difference", _difference, of_words=True),
        _Mean(ITALIC_N, lambda line, _: str(line.test.n)),
        _Mean(Markup("<i>M</i>"), lambda line, _: number(line.test.mean)),
        _Mean(interval_heading, lambda line, _: interval(line.test)),
        _Mean(Markup("<i>t</i>"), lambda line, _: number(line.test.t)),
        _Mean("df", lambda line, _: degrees(line.test.df)),
        _Mean(ITALIC_P, lambda line, _: p_value(line.test.p)),
        _Mean(Markup("<i>d</i><sub>z</sub>"), lambda line, _: number(line.test.cohen_dz)),
        _Mean("BF₁₀", lambda line, _: bayes_factor(line.test.bayes_factor_10)),
    ),
    lines=_means,
    note=lambda _rows, _report: html(
        "Not adjusted. A Bayes factor above 1 speaks for a difference, below 1 for none. Scores "
        "are skewed: with tails as long as a log-normal’s, 95 % intervals of <i>t</i> held the "
        "true difference in .83 to .89 of simulated studies with an effect; where these tests and "
        "the signed-rank tests differ, see the assumptions."
    ),
    csv=_csv_of_t,
    section="sensitivity",
)

_R_FUNCTIONS = r"""
# Sums over the exposures of each condition, brought to one number of exposures, of the people with
# every planned one. They stay integers, so that ties are exact.
pair_up <- function(scores, test) {
  raw <- as.numeric(scores[[paste0(test$outcome, "_raw")]])
  of <- function(condition) {
    mine <- scores$condition == condition
    list(sum = tapply(raw[mine], scores$participant[mine], sum),
         count = tapply(raw[mine], scores$participant[mine], length))
  }
  a <- of(test$a); b <- of(test$b)
  complete <- function(side, planned) {
    names(side$count)[side$count >= max(1, as.numeric(planned))]
  }
  people <- intersect(complete(a, test$planned_a), complete(b, test$planned_b))
  counts <- c(a$count[people], b$count[people])
  common <- Reduce(function(x, y) x * y / divisor(x, y), unique(counts), 1)
  weighted <- as.numeric(scores[[test$outcome]])
  place <- which(raw != 0)
  unit <- if (length(place)) weighted[place[1]] / raw[place[1]] else 0
  list(a = unname(a$sum[people] * common / a$count[people]),
       b = unname(b$sum[people] * common / b$count[people]), unit = unit / common)
}

divisor <- function(x, y) if (y == 0) x else divisor(y, x %% y)

# Wilcoxon's signed-rank test of integer differences. Zeros are ranked and then dropped (Pratt), or
# dropped before ranking. The exact distribution given the ties: every sign is as likely as the
# other, so that of the sum is found by adding one rank after another (in halves, to be whole).
signed_rank <- function(d, zeros, side) {
  if (zeros == "wilcox") d <- d[d != 0]
  r <- rank(abs(d))[d != 0]
  positive <- d[d != 0] > 0
  w_plus <- sum(r[positive]); w_minus <- sum(r[!positive])
  z <- if (length(r)) (w_plus - w_minus) / sqrt(sum(r^2)) else 0
  list(w_plus = w_plus, w_minus = w_minus, z = z, ranks = r,
       p_exact = exact_p(r, w_plus, side), p_asymptotic = normal_p(z, side))
}

exact_p <- function(r, w_plus, side) {
  p <- 1
  for (step in round(2 * r)) p <- (c(p, numeric(step)) + c(numeric(step), p)) / 2
  at <- round(2 * w_plus) + 1
  up <- sum(p[at:length(p)]); down <- sum(p[1:at])
  switch(side, greater = up, less = down, min(1, 2 * min(up, down)))
}

normal_p <- function(z, side) {
  switch(side, greater = pnorm(-z), less = pnorm(z), 2 * pnorm(-abs(z)))
}

# The median of the Walsh averages.
hodges_lehmann <- function(d) {
  sums <- outer(d, d, "+")
  median(sums[upper.tri(sums, diag = TRUE)]) / 2
}

# The hull of the shifts that the test does not reject: p changes only at Walsh averages, so each of
# them is tried and a shift between neighbours, all times 4 to stay whole. An end is closed where
# the Walsh average itself is not rejected.
interval <- function(d, zeros, side, exact, level) {
  sums <- outer(d, d, "+")
  at <- sort(unique(2 * sums[upper.tri(sums, diag = TRUE)]))
  tried <- sort(c(at, at[-1] - diff(at) / 2, min(at) - 1, max(at) + 1))
  kept <- vapply(tried, function(shift) {
    found <- signed_rank(4 * d - shift, zeros, side)
    (if (exact) found$p_exact else found$p_asymptotic) > level
  }, logical(1))
  if (!any(kept)) return(c(NA, NA))
  first <- min(which(kept)); last <- max(which(kept))
  end <- function(place, step) {   # a kept shift between two averages: the end is the next average
    if (place %in% c(1, length(tried))) return(NA)
    if (tried[place] %in% at) tried[place] else tried[place + step]
  }
  c(end(first, -1), end(last, 1)) / 4
}
"""
_R_LINES = r"""
needed <- c("not_tested", "timepoint_a", "timepoint_b", "ranked_worst", "family", "p_holm")
tests <- if (file.exists(file.path(folder, "tables", "tests.csv"))) read_table("tests") else {
  as.data.frame(sapply(needed, function(name) character(), simplify = FALSE))
}
done <- tests[is.na(tests$not_tested), , drop = FALSE]

# scores.csv has what was answered after exposures: no other moment, and nobody's assumed rank.
elsewhere <- !is.na(done$timepoint_a) | !is.na(done$timepoint_b) | done$ranked_worst != "0"
for (k in which(elsewhere)) {
  cat("Not made here:", done$outcome[k], done$a[k], "minus", done$b[k],
      "(its data are not in scores.csv)\n")
}
adjusted_here <- !(done$family %in% done$family[elsewhere])
done$p_holm[!adjusted_here] <- NA
done <- done[!elsewhere, , drop = FALSE]
p_values <- rep(NA_real_, nrow(done))
for (k in seq_len(nrow(done))) {
  test <- done[k, ]
  pairs <- pair_up(scores, test)
  d <- pairs$a - pairs$b
  exact <- test$method == "exact"
  found <- signed_rank(d, test$zero_method, test$alternative)
  p_values[k] <- if (exact) found$p_exact else found$p_asymptotic
  compare(test, "n", test$n, length(d))
  compare(test, "W+", test$w_plus, found$w_plus)
  compare(test, "W-", test$w_minus, found$w_minus)
  compare(test, "Z", test$z, found$z)
  compare(test, paste("p,", test$method), test$p, p_values[k])
  compare(test, "mean of a", test[[paste0("mean_", test$a)]], mean(pairs$a) * pairs$unit)
  compare(test, "mean of b", test[[paste0("mean_", test$b)]], mean(pairs$b) * pairs$unit)
  ranked <- signed_rank(d, "wilcox", test$alternative)
  if (length(ranked$ranks)) {
    r <- (ranked$w_plus - ranked$w_minus) / sum(ranked$ranks)
    compare(test, "rank-biserial r", test$rank_biserial, r)
  }
  kept <- if (test$zero_method == "wilcox") d[d != 0] else d
  if (length(kept) && length(kept) <= MOST_FOR_WALSH) {
    compare(test, "Hodges-Lehmann", test$hodges_lehmann, hodges_lehmann(kept) * pairs$unit)
  }
  bounded <- !is.na(test$hodges_lehmann_low) || !is.na(test$hodges_lehmann_high)
  if (bounded && test$shift_interval == "inverted_test" && length(kept) <= MOST_FOR_INTERVAL) {
    at <- function(level) interval(d, test$zero_method, test$alternative, exact, level) * pairs$unit
    ends <- at(1 - as.numeric(test$confidence))
    compare(test, "interval, low", test$hodges_lehmann_low, ends[1])
    compare(test, "interval, high", test$hodges_lehmann_high, ends[2])
    ends <- at(as.numeric(test$level))   # in a family: that at which Holm's method decides
    compare(test, "interval (Holm), low", test$hodges_lehmann_holm_low, ends[1])
    compare(test, "interval (Holm), high", test$hodges_lehmann_holm_high, ends[2])
  }
  if (exact && requireNamespace("coin", quietly = TRUE) && any(d != 0)) {
    side <- test$alternative
    method <- if (test$zero_method == "pratt") "Pratt" else "Wilcoxon"
    of_coin <- coin::wilcoxsign_test(pairs$a ~ pairs$b, zero.method = method, alternative =
      if (side == "two-sided") "two.sided" else side, distribution = coin::exact())
    compare(test, "p, exact, of coin", test$p, as.numeric(coin::pvalue(of_coin)))
  }
}

# Holm's method over the tests of a family.
for (family in unique(done$family[!is.na(done$p_holm)])) {
  members <- which(!is.na(done$p_holm) & done$family %in% family)
  adjusted <- p.adjust(p_values[members], "holm")
  for (k in seq_along(members)) {
    compare(done[members[k], ], "p, Holm", done$p_holm[members[k]], adjusted[k])
  }
}
"""

TESTS = Analysis(
    "tests",
    AnalysisSet.COMPLETE_PAIRS,
    _compute,
    tables=(_TABLE, _TABLE_OF_MEANS),
    section="primary",
    place=0,
    order=0,
    by_outcome=True,
    intervals=_intervals,
    sentences=_sentences,
    methods=_methods,
    analysed=lambda row: row.participants,
    r_lines=_R_LINES,
    r_functions=_R_FUNCTIONS,
)
