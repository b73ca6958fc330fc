"""Comparisons by other tests than the signed-rank test: of pairs, and of groups of people.

Each test is one function and one line in `_TESTS`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from markupsafe import Markup

from vrcomfort.report.analyses.contract import (
    ITALIC_N,
    ITALIC_P,
    P_HOLM,
    WITHOUT_ZERO,
    Analysis,
    AnalysisData,
    AnalysisFigure,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    ReportContext,
    Sentence,
    TableColumn,
    decided_interval,
    html,
    is_holed,
    percent,
    starred_p,
    with_dot,
)
from vrcomfort.report.descriptives import Description, describe
from vrcomfort.report.estimation import group_figure
from vrcomfort.report.families import (
    Decision,
    difference_in_words,
    disagreement,
    interval_title,
    mean_and_sd,
    p_in_words,
    too_few_in_words,
)
from vrcomfort.report.pairs import NO_VARIANCE, Groups, Pairs, Side, groups_of, pair_up, too_few
from vrcomfort.report.rows import INLINE
from vrcomfort.report.words import (
    NONE,
    bayes_factor,
    degrees,
    fraction,
    interval,
    number,
    p_value,
)
from vrcomfort.stats.mann_whitney import mann_whitney
from vrcomfort.stats.proportions import sign_test
from vrcomfort.stats.t_tests import TTest, Variances, paired_t, two_sample_t

if TYPE_CHECKING:
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.effects import EffectSize
    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.shift import Shift

_DESCRIBED = ("mean", "sd", "median")
NAMES = {
    "mann_whitney": "Mann–Whitney test",
    "welch_t": "Welch’s t test",
    "student_t": "Student’s t test",
    "paired_t": "Paired t test",
    "sign": "Sign test",
    "signed_rank": "Signed-rank test",
}
DIGITS = {"U": 1, "positive": 0, "t": 2}
"""Digits of a statistic in tables and sentences."""


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


def _compute(data: AnalysisData, _: Sequence[object]) -> list[ComparisonRow]:
    return [
        _row(data, contrast, outcome.name)
        for contrast in data.contrasts
        if contrast.test != "signed_rank"
        for outcome in data.scored.outcomes
    ]


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
    )  # fmt: skip
    if row.not_tested:
        return row
    test = _TESTS[row.test](samples, plan, row.alternative, plan.confidence)
    if test is None:
        return replace(row, not_tested=NO_VARIANCE)
    sides = {"a": describe(samples.a * samples.unit), "b": describe(samples.b * samples.unit)}
    smallest = _SMALLEST_P.get(row.test, _any_p)(samples, plan, row.alternative)
    decision: Decision[ComparisonIntervals] = Decision(smallest_p=smallest, higher=test.higher)
    return replace(row, p=test.p, decision=decision, found=ComparisonFound(sides, test.numbers))


def _samples(data: AnalysisData, design: str, outcome: str, a: Side, b: Side) -> Pairs | Groups:
    make = pair_up if design == "paired" else groups_of
    return make(data.scored, outcome, a, b, complete=data.complete)


def _intervals(data: AnalysisData, row: ComparisonRow, level: float) -> ComparisonIntervals | None:
    samples = _samples(data, row.design, row.outcome, *row.sides)
    test = _TESTS[row.test](samples, data.plan, row.alternative, 1 - level)
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


def _sentences(row: ComparisonRow, words: Vocabulary) -> Iterator[Sentence]:
    a, b, name = words.condition(row.a), words.condition(row.b), words.outcome(row.outcome)
    if row.found is None or row.reported is None:
        yield Sentence(f"{name}: {a} and {b} could not be compared ({row.not_tested}).")
        return
    of_a, of_b = (
        f"{label} ({mean_and_sd(row.found.descriptives[side])})"
        for side, label in (("a", a), ("b", b))
    )
    within = "under" if row.design == "paired" else "in"
    confidence = _confidence(row.found.numbers)
    few = too_few_in_words(row.decision, confidence)
    said = difference_in_words(row.decision, of_a, of_b, within, few)
    n = row.n_a if row.design == "paired" else f"{row.n_a} and {row.n_b}"
    yield Sentence(
        f"{name}: {said}; {_difference(row, words, confidence)}, n\u00a0=\u00a0{n}.",
        _evidence(row, row.found.numbers),
    )


def _confidence(numbers: ComparisonNumbers) -> float:
    return numbers.difference.of.confidence if numbers.difference else 0.0


def _difference(row: ComparisonRow, words: Vocabulary, confidence: float) -> str:
    found = row.reported.difference if row.reported else None
    if found is None:
        return ""
    of = f"{found.what} {number(found.of.estimate)} {words.unit(row.outcome)}".rstrip()
    percent, ends = interval_title(row.decision, confidence), interval(found.of)
    if ends == NONE:
        return f"{of} (no {percent}: too few)"
    return f"{of}, {percent} {ends}{disagreement(row.decision.verdict, found.of)}"


def _evidence(row: ComparisonRow, numbers: ComparisonNumbers) -> str:
    exact = f" ({numbers.method})" if numbers.method != "t" else ""
    df = ""
    if numbers.df:
        df = f"({number(numbers.df, 0 if float(numbers.df).is_integer() else 2)})"
    value = number(numbers.value, DIGITS[numbers.statistic])
    text = f"{NAMES[row.test]}{exact}: {numbers.statistic}{df}\u00a0=\u00a0{value}, "
    text += p_in_words(row.p, row.decision)
    effect = row.reported.effect if row.reported else None
    if effect:
        bounded = "g" not in effect.what.split()[-1]
        write = fraction if bounded else number
        text += f"; {effect.what}\u00a0=\u00a0{write(effect.of.estimate)}"
        if interval(effect.of) != NONE:
            null = 0.5 if effect.what == "share above" else 0.0
            text += f" {interval(effect.of, bounded=bounded, null=null)}"
            text += disagreement(row.decision.verdict, effect.of, null)
    return f"{text}."


def _methods(rows: Sequence[ComparisonRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    made = {row.test for row in rows if row.found}
    if "mann_whitney" in made:
        yield MethodsParagraph(
            "Mann–Whitney tests",
            "Groups were compared with the test of Mann & Whitney (1947) on integer sums, exact "
            "given the ties (Streitberg & Röhmel, 1986) where p is not marked; two-sided, p is the "
            "probability of a rank sum at least as far from its expectation. The difference is the "
            "Hodges–Lehmann (1963) shift, the median of all differences between two people of "
            "different groups; its interval is the hull of the shifts that the same test does not "
            "reject. The rank-biserial r is 2 P − 1 with P the probability that somebody of the "
            "first group is higher, its interval that of Newcombe (2006, method 5).",
            ("mann_1947", "streitberg_1986", "hodges_1963", "newcombe_2006"),
        )  # fmt: skip
    if made & {"welch_t", "student_t", "paired_t"}:
        yield MethodsParagraph(
            "Tests of means",
            "Means were compared with t tests"
            + (", without the assumption of equal variances (Welch, 1947)" * ("welch_t" in made))
            + ". Hedges’ (1981) g is the difference over the standard deviation (of the "
            "differences in pairs; the pooled one of groups) without its bias; its interval is "
            "that of the noncentral t distribution. BF₁₀ is the Bayes factor of Rouder et al. "
            "(2009), prior scale √½, two-sided.",
            ("hedges_1981", "rouder_2009", *(("welch_1947",) if "welch_t" in made else ())),
        )  # fmt: skip
    if "sign" in made:
        yield MethodsParagraph(
            "Sign tests",
            "The sign test is exact and leaves out differences of zero; the interval of the share "
            "of positive differences is that of Clopper & Pearson (1934), that of the median lies "
            "between two of the differences (Hollander et al., 2014).",
            ("clopper_1934", "hollander_2014"),
        )  # fmt: skip


def _csv(row: ComparisonRow) -> Iterator[Cells]:
    decision, numbers = row.decision, row.found.numbers if row.found else None
    cells: dict[str, object] = {
        "a": row.a, "b": row.b, "outcome": row.outcome, "test": row.test, "design": row.design,
        "alternative": row.alternative, "n_a": row.n_a, "n_b": row.n_b, "p": row.p,
        "not_tested": row.not_tested, "family": decision.family, "p_holm": decision.p_holm,
        "level": decision.level, "verdict": decision.verdict, "smallest_p": decision.smallest_p,
        "higher": decision.higher,
    }  # fmt: skip
    if numbers:
        cells |= {
            "statistic": numbers.statistic, "value": numbers.value, "df": numbers.df,
            "z": numbers.z, "ties": numbers.ties, "method": numbers.method,
            "p_asymptotic": numbers.p_asymptotic, "bayes_factor_10": numbers.bayes_factor_10,
        }  # fmt: skip
    people = (row.participants[: row.n_a], row.participants[-row.n_b :] if row.n_b else ())
    for side, mine, where in zip("ab", people, row.sides, strict=True):
        cells |= {
            f"people_{side}": list(mine),
            f"condition_{side}": where.condition,
            f"timepoint_{side}": where.timepoint,
        }
    for side in ("a", "b"):
        described = row.found.descriptives[side] if row.found else None
        cells |= {f"{key}_{side}": getattr(described, key, None) for key in _DESCRIBED}
    parts = {
        "difference": (numbers and numbers.difference, _adjusted(row, "difference")),
        "effect": (numbers and numbers.effect, _adjusted(row, "effect")),
    }
    for part, (found, holm) in parts.items():
        cells |= {
            f"{part}_what": found and found.what,
            f"{part}_estimate": found and found.of.estimate,
            f"{part}_low": found and found.of.low,
            f"{part}_high": found and found.of.high,
            f"{part}_holm_low": holm and holm.of.low,
            f"{part}_holm_high": holm and holm.of.high,
        }
    difference = numbers.difference if numbers else None
    yield {**cells, "confidence": difference and difference.of.confidence}


def _adjusted(row: ComparisonRow, name: str) -> NamedEstimate | None:
    found = row.decision.simultaneous
    return getattr(found, name) if found else None


def _heading(rows: Sequence[ComparisonRow]) -> str:
    of_pairs = all(row.design == "paired" for row in rows)
    return "Further tests of pairs" if of_pairs else "Groups of people"


def _caption(_: Sequence[ComparisonRow], report: ReportContext) -> str:
    mean = ", mean per exposure" if report.several else ""
    return f"Comparisons by other tests than the signed-rank test{mean}"


def _group(row: ComparisonRow, _: Sequence[ComparisonRow], report: ReportContext) -> str:
    a, b = (with_dot(name, report.words) for name in (row.a, row.b))
    return html("{} minus {} ({})", a, b, row.alternative)


def _tested(write: Callable[[ComparisonFound], str]) -> Callable[[ComparisonRow, object], str]:
    return lambda row, _: write(row.found) if row.found else ""


def _estimated(
    part: Literal["difference", "effect"], write: Callable[[NamedEstimate], str]
) -> Callable[[ComparisonRow, object], str]:
    """Return the writer of a cell on an estimate, with the interval that belongs to the p."""

    def cell(row: ComparisonRow, _: object) -> str:
        found: NamedEstimate | None = getattr(row.reported, part, None)
        return write(found) if found else NONE

    return cell


def _statistic(found: ComparisonFound) -> str:
    test = found.numbers
    df = "" if test.df is None else f"({degrees(test.df)})"
    return f"{test.statistic}{df} = {number(test.value, DIGITS[test.statistic])}"


def _means(found: ComparisonFound) -> str:
    sides = (found.descriptives[side] for side in "ab")
    return ", ".join(f"{number(side.mean)} ({number(side.sd)})" for side in sides)


def _note(rows: Sequence[ComparisonRow], _: ReportContext) -> str:
    note = html(
        "Positive differences: higher under the first. U: pairs of people in which the first is "
        "higher, ties a half. The difference is the Hodges–Lehmann shift of a Mann–Whitney test, "
        "the median difference of a sign test, the difference of means of a t test. * asymptotic."
    )
    if any(row.decision.simultaneous for row in rows):
        note += html(
            " Intervals of tests with a <i>p</i> Holm are of the level at which Holm’s method "
            "decides on each; unadjusted ones are in <code>tables/comparisons.csv</code>."
        )
    shifts = (row.reported.difference for row in rows if row.reported)
    return note + WITHOUT_ZERO * any(is_holed(found.of) for found in shifts if found)


_Column = TableColumn[ComparisonRow]
_TABLE: AnalysisTable[ComparisonRow, ComparisonRow] = AnalysisTable(
    "comparisons",
    _caption,
    (
        _Column("Outcome", lambda row, words: words.outcome(row.outcome)),
        _Column("Test", lambda row, _: NAMES[row.test].replace(" test", ""), of_words=True),
        _Column(ITALIC_N, lambda row, _: row.size),
        _Column(Markup("<i>M</i> (<i>SD</i>)"), _tested(_means)),
        _Column("statistic", _tested(_statistic)),
        _Column(
            ITALIC_P,
            lambda row, _: starred_p(row.p, row.found.numbers.method if row.found else None),
        ),
        _Column(P_HOLM, lambda row, _: p_value(row.decision.p_holm)),
        _Column("difference", _estimated("difference", lambda found: number(found.of.estimate))),
        _Column(decided_interval, _estimated("difference", lambda found: interval(found.of))),
        _Column(
            "effect",
            _estimated("effect", lambda found: f"{found.what} {number(found.of.estimate)}"),
        ),
        _Column(decided_interval, _estimated("effect", lambda found: interval(found.of))),
        _Column("BF₁₀", _tested(lambda found: bayes_factor(found.numbers.bayes_factor_10))),
    ),
    spanning=lambda row: row.not_tested,
    labels=3,
    group=_group,
    group_key=lambda row: (row.a, row.b),
    note=_note,
    csv=_csv,
)


def _figures(rows: Sequence[ComparisonRow], report: ReportContext) -> Iterator[AnalysisFigure]:
    """Yield a figure for each comparison that could be tested."""
    words = report.words
    for place, row in enumerate(rows):
        difference = row.found and row.found.numbers.difference
        if difference:
            yield AnalysisFigure(
                f"comparison_{place}",
                "paired",
                f"{words.outcome(row.outcome)}: a dot is a participant; the marks beside are means "
                "with standard deviations. Right: the difference that was tested "
                f"({difference.what}) with its {percent(report.plan.confidence)} interval.",
                partial(group_figure, row=row, words=words),
                row.outcome,
            )


_R_LINES = r"""
# The exact distribution of a rank sum given the ties, person after person: rows are people dealt to a.
rank_sum_p <- function(a, b, side) {
  twice <- round(2 * rank(signif(c(a, b), 12))); n <- length(a)
  ways <- matrix(0, n + 1, sum(twice) + 1); ways[1, 1] <- 1
  for (step in twice) {
    moved <- ways[seq_len(n), seq_len(ncol(ways) - step), drop = FALSE]
    ways[-1, -seq_len(step)] <- ways[-1, -seq_len(step)] + moved
  }
  p <- ways[n + 1, ] / sum(ways[n + 1, ])
  sums <- seq_along(p) - 1; found <- sum(twice[seq_len(n)]); middle <- n * (length(twice) + 1)
  switch(side, greater = sum(p[sums >= found]), less = sum(p[sums <= found]),
         sum(p[abs(sums - middle) >= abs(found - middle)]))
}

compare_means <- function(line, a, b) {
  side <- if (line$alternative == "two-sided") "two.sided" else line$alternative
  paired <- line$test == "paired_t"
  test <- t.test(a, b, paired = paired, var.equal = line$test == "student_t", alternative = side,
                 conf.level = as.numeric(line$confidence))
  mean <- mean(a) - mean(b)
  within <- if (paired) var(a - b) else {
    ((length(a) - 1) * var(a) + (length(b) - 1) * var(b)) / (length(a) + length(b) - 2)
  }
  df <- if (paired) length(a) - 1 else length(a) + length(b) - 2
  compare(line, "t", line$value, unname(test$statistic), size = 1e-6)
  compare(line, "df", line$df, unname(test$parameter))
  compare(line, "p", line$p, test$p.value)
  compare(line, "difference", line$difference_estimate, mean, size = 1e-6)
  compare(line, "interval, low", line$difference_low, test$conf.int[1], size = 1e-6)
  compare(line, "interval, high", line$difference_high, test$conf.int[2], size = 1e-6)
  if (df > 1) {
    compare(line, "Hedges' g", line$effect_estimate, mean / sqrt(within) * unbiased(df), size = 1e-6)
  }
}

compare_ranks <- function(line, a, b) {
  a <- signif(a, 12); b <- signif(b, 12)   # means of several exposures that are alike tie
  above <- outer(a, b, ">") + outer(a, b, "==") / 2
  compare(line, "U", line$value, sum(above))
  compare(line, "r", line$effect_estimate, 2 * mean(above) - 1, size = 1e-6)
  compare(line, "shift", line$difference_estimate, median(outer(a, b, "-")), size = 1e-6)
  if (line$method == "exact") compare(line, "p, exact", line$p, rank_sum_p(a, b, line$alternative))
}

compare_signs <- function(line, a, b) {
  d <- signif(a - b, 12); side <- line$alternative
  if (!any(d != 0)) return(invisible())
  test <- binom.test(sum(d > 0), sum(d != 0), alternative =
    if (side == "two-sided") "two.sided" else side)
  compare(line, "p", line$p, test$p.value)
  compare(line, "share above", line$effect_estimate, unname(test$estimate))
}

found <- read_if_there("comparisons")
for (k in seq_len(if (is.null(found)) 0 else nrow(found))) {
  line <- found[k, ]
  if (!is.na(line$timepoint_a) || !is.na(line$timepoint_b)) {
    not_here(line$outcome, line$a, "minus", line$b, "(its data are not in scores.csv)")
    next
  }
  a <- means_of(line$outcome, names_in(line$people_a), line$condition_a)
  b <- means_of(line$outcome, names_in(line$people_b), line$condition_b)
  switch(line$test, mann_whitney = compare_ranks(line, a, b), sign = compare_signs(line, a, b),
         compare_means(line, a, b))
  others <- others + 1
}
"""  # noqa: E501 - lines of R

COMPARISONS = Analysis(
    "comparisons",
    AnalysisSet.COMPLETE_PAIRS,
    _compute,
    tables=(_TABLE,),
    heading=_heading,
    figures=_figures,
    figure_kinds=("paired",),
    side_by_side=True,
    place=1,
    order=1,
    by_outcome=True,
    intervals=_intervals,
    sentences=_sentences,
    methods=_methods,
    analysed=lambda row: row.participants,
    r_lines=_R_LINES,
)
