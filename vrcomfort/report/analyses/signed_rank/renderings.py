"""Renderings of the signed-rank tests: sentences, tables, lines of reproduce.R."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from markupsafe import Markup

from vrcomfort.report.analyses.contract import (
    ITALIC_N,
    ITALIC_P,
    P_HOLM,
    WITHOUT_ZERO,
    AnalysisTable,
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
from vrcomfort.report.analyses.signed_rank.computation import (
    PairedTTest,
    SignedRankFound,
    SignedRankRow,
)
from vrcomfort.report.analyses.signed_rank.methods import fewest_for_shift
from vrcomfort.report.families import (
    deciding_p,
    difference_in_words,
    disagreement,
    interval_title,
    means_in_words,
    p_in_words,
    too_few_in_words,
)
from vrcomfort.report.orders import in_words
from vrcomfort.report.words import (
    NONE,
    bayes_factor,
    degrees,
    fraction,
    interval,
    number,
    p_value,
)
from vrcomfort.stats.effects import EffectSize
from vrcomfort.stats.ranks import fewest_for_interval

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.shift import Shift


_DESCRIBED = ("mean", "sd", "median", "q1", "q3")


def sentences(row: SignedRankRow, words: Vocabulary) -> Iterator[Sentence]:
    """Yield the answer of a test."""
    a, b = words.condition(row.a), words.condition(row.b)
    name, found = words.outcome(row.outcome), row.found
    if found is None:
        yield Sentence(f"{name}: {a} and {b} could not be compared ({row.not_tested}).")
        return
    if found.effect is None and not row.ranked_worst:
        yield Sentence(f"{name}: nobody’s score differed between {a} and {b} (n = {row.n}).")
        return
    size, few = found.descriptives, too_few_in_words(row.decision, row.confidence, found.zeros)
    said = difference_in_words(row.decision, a, b, "under", few)
    order = f" But {in_words(row.confounded, words.condition)}." if row.confounded else ""
    yield Sentence(
        f"{name}: {said}; {_shift(row, words)}, {deciding_p(row.p, row.decision)}, "
        f"n\u00a0=\u00a0{row.n}.",
        f"{means_in_words(a, size[row.a], b, size[row.b])} {found.method.capitalize()} signed-rank "
        f"test: Z\u00a0=\u00a0{number(found.z)}, {p_in_words(row.p, row.decision)}, "
        f"rank-biserial r\u00a0=\u00a0{_rank_biserial(row, words)}.{order}",
    )


def _shift(row: SignedRankRow, words: Vocabulary) -> str:
    shift = row.reported.shift if row.reported else None
    whose = ""
    if row.ranked_worst:
        stayed = row.n - len(row.ranked_worst)
        whose = f" of the {stayed} who stayed (the test ranks those who left as worst)"
    percent, found = interval_title(row.decision, row.confidence), interval(shift)
    estimate = number(shift.estimate if shift else None)
    of = f"the median difference{whose} was {estimate} {words.unit(row.outcome)}".rstrip()
    if found == NONE:
        why = "the test is of ranks" if row.ranked_worst else "too few differences"
        return f"{of} (no {percent}: {why})"
    return f"{of}, {percent} {found}{disagreement(row.decision.verdict, shift)}"


def _rank_biserial(row: SignedRankRow, words: Vocabulary) -> str:
    effect = row.reported.effect if row.reported else None
    if effect is None:
        return f"{NONE} (nobody’s score differed)"
    r = fraction(effect.estimate)
    if effect.low is not None:
        return f"{r} {interval(effect, bounded=True)}{disagreement(row.decision.verdict, effect)}"
    if row.ranked_worst:
        return r
    few = row.n - (row.found.zeros if row.found else 0) < fewest_for_interval(effect.confidence)
    a = words.condition(row.a)
    reason = "too few differences other than 0" if few else f"{a} has no score but 0"
    return f"{r} (no {interval_title(row.decision, row.confidence)}: {reason})"


def _csv(row: SignedRankRow) -> Iterator[Cells]:
    found, decision = row.found, row.decision
    shift = found.shift if found else None
    effect = found.effect if found else None
    holm = decision.simultaneous
    cells = {
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
        cells |= {f"{stat}_{name}": getattr(described, stat) for stat in _DESCRIBED}
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
        "{}. Difference: median difference (Hodges–Lehmann) in points, pairs without a difference "
        "{}. <i>r</i>: matched-pairs rank-biserial correlation. A round bracket: the end itself is "
        "not in the interval.",
        sides[0] if len(sides) == 1 else "as each comparison says (two-sided, greater, less)",
        " except where marked * (asymptotic)" if asymptotic else "",
        "ranked, then dropped (Pratt)" if pratt else "dropped",
        "included" if pratt else "excluded",
    )
    note += WITHOUT_ZERO * any(is_holed(shown.shift) for _, shown in made)
    note += html(
        " An interval of the shift needs {} differences{}; – where there are fewer.",
        str(fewest_for_shift(plan)),
        _needed_for_r(plan),
    )
    if any(row.decision.simultaneous for row in rows):
        note += html(
            " Where there is a <i>p</i> Holm, intervals have the level at which Holm’s method "
            "decides on that test, so that interval and <i>p</i> agree about 0. Unadjusted "
            "intervals are in <code>tables/tests.csv</code>."
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
TABLE: AnalysisTable[SignedRankRow, SignedRankRow] = AnalysisTable(
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


def _standardised(test: PairedTTest) -> str:
    d = EffectSize(test.cohen_dz, test.cohen_dz_low, test.cohen_dz_high, test.confidence)
    return f"{number(d.estimate)} {interval(d)}"


_Mean = TableColumn[_Means]
TABLE_OF_MEANS: AnalysisTable[SignedRankRow, _Means] = AnalysisTable(
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
        _Mean(Markup("<i>d</i><sub>z</sub>"), lambda line, _: _standardised(line.test)),
        _Mean("BF₁₀", lambda line, _: bayes_factor(line.test.bayes_factor_10)),
    ),
    lines=_means,
    note=lambda _rows, _report: html(
        "Not adjusted. A Bayes factor above 1 favours a difference, below 1 none. Intervals of "
        "<i>t</i> assume normal differences: with log-normal tails, 95 % intervals covered the "
        "true difference in .83 to .89 of simulated studies with an effect. If these tests "
        "and the signed-rank tests disagree, see Assumptions."
    ),
    csv=_csv_of_t,
    section="sensitivity",
)


R_FUNCTIONS = r"""
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


R_LINES = r"""
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
done <- done[!elsewhere, , drop = FALSE]
for (k in seq_len(nrow(done))) {
  test <- done[k, ]
  pairs <- pair_up(scores, test)
  d <- pairs$a - pairs$b
  exact <- test$method == "exact"
  found <- signed_rank(d, test$zero_method, test$alternative)
  p <- if (exact) found$p_exact else found$p_asymptotic
  in_family(test, p)
  compare(test, "n", test$n, length(d))
  compare(test, "W+", test$w_plus, found$w_plus)
  compare(test, "W-", test$w_minus, found$w_minus)
  compare(test, "Z", test$z, found$z)
  compare(test, paste("p,", test$method), test$p, p)
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
"""
