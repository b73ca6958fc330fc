"""Renderings of comparisons: sentences, methods, table, lines of reproduce.R."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Literal

from markupsafe import Markup

from vrcomfort.report.analyses.comparisons.computation import (
    ComparisonFound,
    ComparisonNumbers,
    ComparisonRow,
    NamedEstimate,
)
from vrcomfort.report.analyses.comparisons.figure import group_figure
from vrcomfort.report.analyses.contract import (
    ITALIC_N,
    ITALIC_P,
    P_HOLM,
    WITHOUT_ZERO,
    AnalysisFigure,
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
from vrcomfort.report.families import (
    deciding_p,
    difference_in_words,
    disagreement,
    interval_title,
    means_in_words,
    p_in_words,
    too_few_in_words,
)
from vrcomfort.report.words import (
    NONE,
    bayes_factor,
    degrees,
    fraction,
    interval,
    number,
    p_value,
)

if TYPE_CHECKING:
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary


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


def sentences(row: ComparisonRow, words: Vocabulary) -> Iterator[Sentence]:
    """Yield the answer of a comparison."""
    a, b, name = words.condition(row.a), words.condition(row.b), words.outcome(row.outcome)
    if row.found is None or row.reported is None:
        yield Sentence(f"{name}: {a} and {b} could not be compared ({row.not_tested}).")
        return
    within = "under" if row.design == "paired" else "in"
    confidence = _confidence(row.found.numbers)
    few = too_few_in_words(row.decision, confidence)
    said = difference_in_words(row.decision, a, b, within, few)
    n = row.n_a if row.design == "paired" else f"{row.n_a} and {row.n_b}"
    means = means_in_words(a, row.found.descriptives["a"], b, row.found.descriptives["b"])
    yield Sentence(
        f"{name}: {said}; {_difference(row, words, confidence)}"
        f"{deciding_p(row.p, row.decision)}, n\u00a0=\u00a0{n}.",
        f"{means} {_evidence(row, row.found.numbers)}",
    )


def _confidence(numbers: ComparisonNumbers) -> float:
    return numbers.difference.of.confidence if numbers.difference else 0.0


def _difference(row: ComparisonRow, words: Vocabulary, confidence: float) -> str:
    found = row.reported.difference if row.reported else None
    if found is None:
        return ""
    estimate = f"{number(found.of.estimate)} {words.unit(row.outcome)}".rstrip()
    of = f"the {found.what} was {estimate}"
    percent, ends = interval_title(row.decision, confidence), interval(found.of)
    if ends == NONE:
        return f"{of} (no {percent}: too few), "
    return f"{of}, {percent} {ends}{disagreement(row.decision.verdict, found.of)}, "


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


def methods(rows: Sequence[ComparisonRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    """Yield a paragraph on each kind of test that was made."""
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
    cells = {
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
    yield {
        **cells,
        "confidence": difference and difference.of.confidence,
        "largest_difference": row.largest_difference,
    }


def _adjusted(row: ComparisonRow, name: str) -> NamedEstimate | None:
    found = row.decision.simultaneous
    return getattr(found, name) if found else None


def heading(rows: Sequence[ComparisonRow]) -> str:
    """Return the heading above the table."""
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
TABLE: AnalysisTable[ComparisonRow, ComparisonRow] = AnalysisTable(
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


def figures(rows: Sequence[ComparisonRow], report: ReportContext) -> Iterator[AnalysisFigure]:
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


R_LINES = r"""
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
  in_family(line, test$p.value)
  compare(line, "difference", line$difference_estimate, mean, size = 1e-6)
  # No interval goes beyond the largest difference that there can be.
  most <- as.numeric(line$largest_difference); most <- if (is.na(most)) Inf else most
  held <- pmin(pmax(test$conf.int, -most), most)
  compare(line, "interval, low", line$difference_low, held[1], size = 1e-6)
  compare(line, "interval, high", line$difference_high, held[2], size = 1e-6)
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
  if (line$method == "exact") {
    p <- rank_sum_p(a, b, line$alternative)
    compare(line, "p, exact", line$p, p)
    in_family(line, p)
  }
}

compare_signs <- function(line, a, b) {
  d <- signif(a - b, 12); side <- line$alternative
  if (!any(d != 0)) return(invisible())
  test <- binom.test(sum(d > 0), sum(d != 0), alternative =
    if (side == "two-sided") "two.sided" else side)
  compare(line, "p", line$p, test$p.value)
  in_family(line, test$p.value)
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
