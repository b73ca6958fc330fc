"""Correlations of two outcomes: of people, or within people over exposures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from vrcomfort.plurals import counted
from vrcomfort.records.names import natural
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
    interval_heading,
    starred_p,
    unknown_outcome,
)
from vrcomfort.report.families import disagreement, is_shown, verdict_alone
from vrcomfort.report.pairs import Side, side_sums
from vrcomfort.report.plan import Entry
from vrcomfort.report.rows import INLINE, cells
from vrcomfort.report.words import NONE, fraction, interval, p_equals
from vrcomfort.settings import Problem
from vrcomfort.stats.correlation import Correlation, correlation, repeated_measures_correlation

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from vrcomfort.report.families import Verdict
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary

    Floats = NDArray[np.float64]

NAMES = {
    "pearson": ("Pearson’s r", "r"),
    "spearman": ("Spearman’s ρ", "ρ"),
    "kendall": ("Kendall’s τ", "τ"),
    "repeated_measures": ("Repeated-measures correlation", "r"),
}


class Correlated(Entry):
    """Two outcomes that are correlated."""

    x: str
    y: str
    method: Literal["spearman", "pearson", "kendall", "repeated_measures"] = "spearman"
    """`repeated_measures`: within people, over exposures; others: one value per person."""
    condition: str = ""
    """Of which exposures; blank: of all, each person's mean."""


@dataclass(frozen=True)
class CorrelationRow:
    """One correlation, with the values that it is of."""

    x: str
    y: str
    condition: str
    not_tested: str | None
    participants: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    found: Correlation = field(metadata=INLINE)
    verdict: Verdict | None


def _problems(plan: Plan, asked: Sequence[Correlated]) -> Iterator[Problem]:
    for place, pair in enumerate(asked):
        yield from unknown_outcome(plan, pair.x, "correlations", place, "x")
        yield from unknown_outcome(plan, pair.y, "correlations", place, "y")
        if pair.x == pair.y:
            yield Problem(("correlations", place), f"`{pair.x}` is correlated with itself")


def _compute(data: AnalysisData, asked: Sequence[Correlated]) -> list[CorrelationRow]:
    return [_row(data, each) for each in asked if data.has(each.x, each.y)]


def _row(data: AnalysisData, asked: Correlated) -> CorrelationRow:
    scored, confidence = data.scored, data.plan.confidence
    rows = scored.table
    rows = rows[rows["condition"] == asked.condition] if asked.condition else rows
    if asked.method == "repeated_measures":
        rows = rows.dropna(subset=[asked.x, asked.y])
        x, y = _points(data, rows, asked)
        people = sorted(rows["participant"].unique(), key=natural)
        found = repeated_measures_correlation(
            x, y, rows["participant"].to_numpy(), confidence=confidence
        )
        smallest = 0.0
    else:
        means = _means(data, rows, asked)
        x, y = _points(data, means, asked)
        people = sorted(means.index, key=natural)
        found = correlation(x, y, method=asked.method, confidence=confidence)
        # The smallest p that these ranks, ties and all, can give: both in one order. Pearson's r of
        # other values can be as close to 1 as one likes.
        one_way = correlation(np.sort(x), np.sort(y), method=asked.method)
        smallest = 0.0 if asked.method == "pearson" or one_way.p is None else one_way.p
    problem = None
    if found.estimate is None:
        problem = (
            f"{found.n} pairs of values, or one of both does not vary: too little to correlate"
        )
    higher = (found.estimate or 0.0) > 0
    return CorrelationRow(
        asked.x, asked.y, asked.condition, problem, tuple(people),
        (tuple(x.tolist()), tuple(y.tolist())), found,
        verdict_alone(found.p, smallest, confidence, higher=higher),
    )  # fmt: skip


def _means(data: AnalysisData, rows: pd.DataFrame, asked: Correlated) -> pd.DataFrame:
    """Return the means of each participant with every planned score of both outcomes."""
    sides = [Side(asked.condition)]
    complete = [
        set(side_sums(data.scored, name, sides, complete=data.complete)[0])
        for name in (asked.x, asked.y)
    ]
    rows = rows[rows["participant"].isin(set.intersection(*complete))]
    return rows.groupby("participant")[[asked.x, asked.y]].mean().dropna()


def _points(data: AnalysisData, rows: pd.DataFrame, asked: Correlated) -> tuple[Floats, Floats]:
    units = data.scored.units
    x, y = (rows[name].to_numpy(dtype=float) * units[name] for name in (asked.x, asked.y))
    return x, y


def _sentences(row: CorrelationRow, words: Vocabulary) -> Iterator[Sentence]:
    x, y, found = words.outcome(row.x), words.outcome(row.y), row.found
    if row.not_tested:
        yield Sentence(f"{x} and {y} could not be correlated ({row.not_tested}).")
        return
    title, symbol = NAMES[found.method]
    if row.verdict == "not_possible":
        said = "with so few values, no correlation could be shown"
    elif not is_shown(row.verdict):
        said = "no correlation was shown"
    else:
        more = "more" if row.verdict == "higher" else "less"
        said = f"more of one went with {more} of the other"
    ends = ""
    if found.low is not None:
        ends = f", {100 * found.confidence:g}\u00a0% CI {interval(found, bounded=True)}"
        ends += disagreement(row.verdict, found)
    n = f"n\u00a0=\u00a0{found.n}"
    if found.method == "repeated_measures":
        n = f"{counted(found.n, 'exposures')} of {counted(found.people, 'people')}"
    yield Sentence(
        f"{x} and {y}: {said}; {symbol}\u00a0=\u00a0{fraction(found.estimate)}{ends}, {n}.",
        f"{title}: {p_equals(found.p)}.",
    )


_METHODS: dict[str, tuple[str, tuple[str, ...]]] = {
    "pearson": (
        "Pearson’s r has an interval of t on Fisher’s scale, with the larger of the normal and the "
        "jackknife’s standard error.",
        (),
    ),
    "spearman": (
        "Spearman’s ρ has the interval of Bonett & Wright (2000); its p is exact up to 8 pairs.",
        ("bonett_2000",),
    ),
    "kendall": (
        "Kendall’s τ_b has the interval of Fieller et al. (1957); its p is exact without ties up "
        "to 33 pairs.",
        ("fieller_1957",),
    ),
    "repeated_measures": (
        "Repeated-measures correlations have one slope for all and a level for each person (Bland "
        "& Altman, 1995; Bakdash & Marusich, 2017).",
        ("bland_1995", "bakdash_2017"),
    ),
}


def _methods(rows: Sequence[CorrelationRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    made = dict.fromkeys(row.found.method for row in rows if not row.not_tested)
    if made:
        text = " ".join(_METHODS[name][0] for name in made)
        cited = tuple(key for name in made for key in _METHODS[name][1])
        yield MethodsParagraph(
            "Correlations", f"{text} p values of correlations are not adjusted.", cited
        )


def _outcomes(row: CorrelationRow, words: Vocabulary) -> str:
    condition = f" ({words.condition(row.condition)})" if row.condition else ""
    return f"{words.outcome(row.x)}, {words.outcome(row.y)}{condition}"


def _csv(row: CorrelationRow) -> Iterator[Cells]:
    yield cells(row, ("participants", "values")) | {"people_in_it": list(row.participants)}


_TABLE: AnalysisTable[CorrelationRow, CorrelationRow] = AnalysisTable(
    "correlations",
    "Correlations",
    (
        TableColumn("Outcomes", _outcomes, of_words=True),
        TableColumn("Method", lambda row, _: NAMES[row.found.method][0], of_words=True),
        TableColumn(ITALIC_N, lambda row, _: str(row.found.n)),
        TableColumn("estimate", lambda row, _: fraction(row.found.estimate)),
        TableColumn(interval_heading, lambda row, _: interval(row.found, bounded=True)),
        TableColumn("df", lambda row, _: NONE if row.found.df is None else str(row.found.df)),
        TableColumn(ITALIC_P, lambda row, _: starred_p(row.found.p, row.found.p_method)),
    ),
    spanning=lambda row: row.not_tested,
    labels=3,
    csv=_csv,
)

_R_LINES = r"""
found <- read_if_there("correlations")
for (k in seq_len(if (is.null(found)) 0 else nrow(found))) {
  line <- found[k, ]
  if (line$method == "repeated_measures") {
    mine <- is.na(line$condition) | scores$condition %in% line$condition
    x <- as.numeric(scores[[line$x]])[mine]; y <- as.numeric(scores[[line$y]])[mine]
    both <- !is.na(x) & !is.na(y); who <- factor(scores$participant[mine][both])
    x <- x[both]; y <- y[both]
    left <- sum(resid(lm(y ~ who + x))^2); all <- sum(resid(lm(y ~ who))^2)
    r <- sign(coef(lm(y ~ who + x))[["x"]]) * sqrt(1 - left / all)
    p <- anova(lm(y ~ who), lm(y ~ who + x))[2, "Pr(>F)"]
  } else {
    people <- names_in(line$people_in_it)
    x <- means_of(line$x, people, line$condition); y <- means_of(line$y, people, line$condition)
    r <- cor(x, y, method = line$method)
    p <- if (line$method == "pearson") cor.test(x, y)$p.value else NA
  }
  line$outcome <- line$x
  about <- paste("correlation with", line$y)
  compare(line, line$method, line$estimate, r, about, size = 1e-6)
  if (!is.na(p)) compare(line, "p", line$p, p, about)
  others <- others + 1
}
"""

CORRELATIONS = Analysis(
    "correlations",
    AnalysisSet.COMPLETE_CASES,
    _compute,
    asked=Correlated,
    problems=_problems,
    tables=(_TABLE,),
    place=40,
    order=20,
    sentences=_sentences,
    methods=_methods,
    analysed=lambda rows: [row.participants for row in rows],
    r_lines=_R_LINES,
)
