"""Linear mixed models of every scored exposure, with marginal means."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING

import pandas as pd
from markupsafe import Markup

from vrcomfort.errors import InputError
from vrcomfort.plurals import counted
from vrcomfort.report.analyses.contract import (
    ITALIC_P,
    ITALIC_SE,
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    Remark,
    ReportContext,
    TableColumn,
    estimable,
    estimate_columns,
    html,
    interval_heading,
    missing_outcomes,
    percent,
    with_dot,
)
from vrcomfort.report.exposures import column_of
from vrcomfort.report.factors import points
from vrcomfort.report.possible import all_limited, limited
from vrcomfort.report.rows import INLINE
from vrcomfort.report.words import NONE, degrees, interval, number, p_value
from vrcomfort.stats.mixed import MOST_LEVELS, Estimate, MixedModel, Pairwise, mixed_model

if TYPE_CHECKING:
    from vrcomfort.report.possible import Possible
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.random_intercept import FTest

ERRORS = {
    "cluster_robust": "cluster-robust (CR2; Bell & McCaffrey, 2002; Pustejovsky & Tipton, 2018), "
    "with participants as clusters. Degrees of freedom are Satterthwaite’s (1946); effects with "
    "several terms were tested with Hotelling’s T².",
    "model": "those of generalised least squares at the fitted variances. Degrees of freedom are "
    "Satterthwaite’s (1946; Kuznetsova et al., 2017).",
}
"""What is said of each kind of standard errors."""
NOTED = {
    "cluster_robust": "Standard errors robust to skew and to unequal people (CR2), with "
    "Satterthwaite’s degrees of freedom",
    "model": "Standard errors of the model, with Satterthwaite’s degrees of freedom",
}
CITED = {
    "cluster_robust": ("bell_2002", "pustejovsky_2018", "satterthwaite_1946"),
    "model": ("satterthwaite_1946", "kuznetsova_2017"),
}


@dataclass(frozen=True)
class MixedFit:
    """The fitted model, and the effects that could not be told apart from its own."""

    model: MixedModel = field(metadata=INLINE)
    left_out: tuple[str, ...]


@dataclass(frozen=True)
class MixedRow:
    """The mixed model of one outcome."""

    outcome: str
    not_tested: str | None
    fit: MixedFit | None = field(metadata=INLINE)


def _compute(data: AnalysisData, _: Sequence[object]) -> list[MixedRow]:
    wanted = data.plan.mixed_model or data.plan.covariates
    return [_row(data, each.name) for each in (data.scored.outcomes if wanted else ())]


def _row(data: AnalysisData, outcome: str) -> MixedRow:
    return MixedRow(outcome, *estimable(lambda: _fit(data, outcome)))


def _fit(data: AnalysisData, outcome: str) -> MixedFit:
    """Fit the wanted effects; while they cannot be told apart, without the least wanted one."""
    scored, plan = data.scored, data.plan
    rows = points(scored.table, scored, outcome)
    rows = rows.assign(**{n: column_of(scored, rows, n) for n in plan.mixed_model})
    rows = rows.assign(
        **{n: pd.to_numeric(column_of(scored, rows, n), errors="coerce") for n in plan.covariates}
    )
    factors = [name for name in plan.mixed_model if len(rows[name].dropna().unique()) > 1]
    covariates = [name for name in plan.covariates if len(rows[name].dropna().unique()) > 1]
    left_out: list[str] = []
    while factors or covariates:
        try:
            model = mixed_model(
                rows,
                value="score",
                participant="participant",
                factors=factors,
                references={"condition": data.reference},
                covariates=covariates,
                errors=plan.mixed_model_errors,
                confidence=plan.confidence,
            )
        except InputError:
            if len(factors) + len(covariates) == 1:
                raise
            # From the end, the least wanted effect; the first factor goes last of all, after the
            # covariates. `left_out` has them in the order of the plan.
            left_out.insert(0, (covariates if len(factors) < 2 else factors).pop())
            continue
        possible = scored.possible_scores(outcome)
        return MixedFit(within_possible(model, possible, covariates), tuple(left_out))
    raise InputError("no effect has two levels in the data")


def within_possible(
    model: MixedModel, possible: Possible, covariates: Collection[str] = ()
) -> MixedModel:
    """Limit a model's intervals of means and differences to the possible range."""
    apart = possible.difference
    return replace(
        model,
        intercept=limited(model.intercept, possible),
        terms={
            name: each if name in covariates else limited(each, apart)
            for name, each in model.terms.items()
        },
        means={name: all_limited(each, possible) for name, each in model.means.items()},
        pairwise={name: all_limited(each, apart) for name, each in model.pairwise.items()},
    )


def _methods(rows: Sequence[MixedRow], report: ReportContext) -> Iterator[MethodsParagraph]:
    models = [row.fit.model for row in rows if row.fit]
    if models:
        yield MethodsParagraph(
            "Mixed model",
            "The mixed model has a random intercept per participant (Laird & Ware, 1982). It was "
            "fitted by restricted maximum likelihood to every scored exposure. Standard errors "
            f"are {ERRORS[report.plan.mixed_model_errors]}",
            ("laird_1982", *CITED[report.plan.mixed_model_errors]),
        )
    if any("condition" in model.means for model in models):
        yield MethodsParagraph(
            "Marginal means",
            "Estimated marginal means (Searle et al., 1980) of the mixed model give the levels of "
            "the other factors equal weight. Their differences are Bonferroni-adjusted for the "
            "number of pairs.",
            ("searle_1980",),
        )


def _csv(row: MixedRow) -> Iterator[Cells]:
    """Yield the terms, then each effect as a whole, one line each."""
    if row.fit is None:
        yield {"outcome": row.outcome, "not_tested": row.not_tested}
        return
    model = row.fit.model
    keys = {
        "outcome": row.outcome, "n_participants": model.n_participants,
        "n_values": model.n_values, "errors": model.errors,
        "left_out": " × ".join(row.fit.left_out),
    }  # fmt: skip
    for name, term in model.terms.items():
        yield {**keys, "term": name, **asdict(term)}
    for name, test in model.omnibus.items():
        yield {**keys, "term": name, **asdict(test)}


def _csv_of_means(row: MixedRow) -> Iterator[Cells]:
    """Yield marginal means, then their differences, one line each."""
    if row.fit is None:
        return
    for of_factors in (row.fit.model.means, row.fit.model.pairwise):
        for factor, levels in of_factors.items():
            for level, estimate in levels.items():
                keys = {"outcome": row.outcome, "factor": factor, "level": level}
                yield {**keys, **asdict(estimate)}


def _remarks(rows: Sequence[MixedRow], report: ReportContext) -> Iterator[Remark]:
    yield from missing_outcomes(rows, report, "mixed model")


def _title(row: MixedRow, _: Sequence[MixedRow], report: ReportContext) -> str:
    if row.fit is None:
        return ""
    model = row.fit.model
    people = counted(model.n_participants, "participants")
    sizes = f"{counted(model.n_values, 'exposures')} of {people}"
    return f"{report.words.outcome(row.outcome)}, {sizes}"


def _terms(row: MixedRow) -> Iterable[tuple[str, Estimate]]:
    return row.fit.model.terms.items() if row.fit else ()


@dataclass(frozen=True)
class _Whole:
    """A line on an effect as a whole; the first line of an outcome names it."""

    outcome: str | None
    effect: str
    test: FTest


def _wholes(row: MixedRow) -> Iterator[_Whole]:
    tests = row.fit.model.omnibus if row.fit else {}
    for place, (effect, test) in enumerate(tests.items()):
        yield _Whole(None if place else row.outcome, effect, test)


@dataclass(frozen=True)
class _Mean:
    """A line on the mean of a condition, or on the difference of two."""

    outcome: str | None
    condition: str
    pair: str
    found: Estimate | Pairwise


def _means(row: MixedRow) -> Iterator[_Mean]:
    if row.fit is None:
        return
    of_conditions = row.fit.model.means.get("condition", {})
    for place, (condition, mean) in enumerate(of_conditions.items()):
        yield _Mean(None if place else row.outcome, condition, "", mean)
    pairs = row.fit.model.pairwise.get("condition", {}) if of_conditions else {}
    for pair, difference in pairs.items():
        yield _Mean(None, "", pair, difference)


def _dfs(test: FTest) -> str:
    return NONE if test.df_error is None else f"{test.df_effect}, {degrees(test.df_error)}"


def _outcome(line: _Whole | _Mean, words: Vocabulary) -> str:
    return "" if line.outcome is None else words.outcome(line.outcome)


def _condition(line: _Mean, words: Vocabulary) -> str:
    if line.condition:
        return with_dot(line.condition, words)
    return words.term(f"condition: {line.pair}").replace("condition: ", "")


def _note(rows: Sequence[MixedRow], report: ReportContext) -> str:
    left_out = next(row.fit.left_out for row in rows if row.fit)
    also = (
        f" Left out, as their effects cannot be separated from the others: {', '.join(left_out)}."
    )
    return (
        "Participants with missing scores are included, and each effect is adjusted for the "
        "others. Estimates therefore differ from those of the pairs; they are valid if missingness "
        "depends only on observed data. "
        f"{NOTED[report.plan.mixed_model_errors]}." + also * bool(left_out)
    )


def _note_on_means(rows: Sequence[MixedRow], _: ReportContext) -> str:
    note = html(
        "Other factors have equal weights, covariates are at their means; all factors are in "
        "<code>tables/marginal_means.csv</code>."
    )
    models = [row.fit.model for row in rows if row.fit]
    without = any("condition" in m.means and not m.pairwise.get("condition") for m in models)
    return note + f" Pairs are compared of up to {MOST_LEVELS} conditions." * without


def _caption_of_means(_: Sequence[MixedRow], report: ReportContext) -> str:
    return (
        "Estimated marginal means of the same model by condition, and their differences "
        f"({percent(report.plan.confidence)} intervals of differences and p adjusted by Bonferroni)"
    )


def _estimate_of(line: tuple[str, Estimate]) -> Estimate:
    return line[1]


_Term = TableColumn[tuple[str, Estimate]]
_TABLE: AnalysisTable[MixedRow, tuple[str, Estimate]] = AnalysisTable(
    "mixed_models",
    "All available data: linear mixed model, random intercept per participant (points)",
    (
        _Term("Term", lambda line, words: words.term(line[0]), of_words=True),
        *estimate_columns(_estimate_of, interval_heading),
    ),
    lines=_terms,
    group=_title,
    csv=_csv,
)
_Effect = TableColumn[_Whole]
_TABLE_OF_EFFECTS: AnalysisTable[MixedRow, _Whole] = AnalysisTable(
    "",
    "The same model: each effect as a whole, given the others",
    (
        _Effect("Score", _outcome),
        _Effect("Effect", lambda line, _: line.effect, of_words=True),
        _Effect(Markup("<i>F</i>"), lambda line, _: number(line.test.f)),
        _Effect("df", lambda line, _: _dfs(line.test)),
        _Effect(ITALIC_P, lambda line, _: p_value(line.test.p)),
    ),
    lines=_wholes,
    note=_note,
    csv=lambda _: (),
)
_OfMean = TableColumn[_Mean]
_TABLE_OF_MEANS: AnalysisTable[MixedRow, _Mean] = AnalysisTable(
    "marginal_means",
    _caption_of_means,
    (
        _OfMean("Score", _outcome),
        _OfMean("Condition", _condition, of_words=True),
        _OfMean("estimate", lambda line, _: number(line.found.estimate)),
        _OfMean(ITALIC_SE, lambda line, _: number(line.found.standard_error)),
        _OfMean("df", lambda line, _: degrees(line.found.df)),
        _OfMean(ITALIC_P, lambda line, _: p_value(getattr(line.found, "p_adjusted", None))),
        _OfMean(interval_heading, lambda line, _: interval(line.found)),
    ),
    lines=_means,
    note=_note_on_means,
    csv=_csv_of_means,
)

_R_LINES = r"""
# The mixed model with a random participant; the level after the minus sign is the reference.
mixed_of <- function(found) {
  terms <- found[!is.na(found$estimate), ]; whole <- found[!is.na(found$df_effect), ]
  called <- setNames(paste0("f", seq_len(nrow(whole))), whole$term)
  mine <- data.frame(who = scores$participant, score = as.numeric(scores[[found$outcome[1]]]))
  coefficient <- character()
  for (name in whole$term) {
    column <- scores[[paste0("mixed: ", name)]]
    pairs <- expand.grid(level = unique(column), reference = unique(column),
                         stringsAsFactors = FALSE)
    pairs$term <- paste0(name, ": ", pairs$level, MINUS, pairs$reference)
    own <- pairs[match(intersect(terms$term, pairs$term), pairs$term), ]
    if (nrow(own)) {   # in the order of the terms: that of a locale is another
      mine[[called[name]]] <- factor(match(column, c(own$reference[1], own$level)))
      coefficient[own$term] <- paste0(called[name], 1 + seq_len(nrow(own)))
    } else {
      mine[[called[name]]] <- as.numeric(column)
      coefficient[name] <- called[name]
    }
  }
  mine <- mine[complete.cases(mine), ]
  formula <- as.formula(paste("score ~", paste(called, collapse = " + "), "+ (1 | who)"))
  precise <- lme4::lmerControl(optimizer = "bobyqa", check.conv.singular = "ignore",
                               optCtrl = list(rhobeg = 0.2, rhoend = 1e-12, maxfun = 1e5))
  robust <- found$errors[1] == "cluster_robust"
  if (robust && !requireNamespace("clubSandwich", quietly = TRUE))
    return(not_here("errors of the mixed model of", found$outcome[1],
                    "(package clubSandwich is not installed)"))
  if (robust) {
    # The data stand in the call, where clubSandwich looks for them.
    fit <- do.call(lme4::lmer, list(formula, mine, control = precise))
    table <- as.data.frame(clubSandwich::coef_test(fit, vcov = "CR2", cluster = mine$who))
    rownames(table) <- names(lme4::fixef(fit))
    names(table)[match(c("beta", "SE", "df_Satt", "p_Satt"), names(table))] <-
      c("Estimate", "Std. Error", "df", "Pr(>|t|)")
    columns <- attr(lme4::getME(fit, "X"), "assign")
    tested <- called[!is.na(whole$f)]   # it stops where errors of a contrast are 0
    omnibus <- do.call(rbind, lapply(tested, function(name) {
      own <- which(columns == match(name, called))
      whole <- clubSandwich::Wald_test(fit, clubSandwich::constrain_zero(own), "CR2",
                                       test = "HTZ", cluster = mine$who)
      data.frame("F value" = whole$Fstat, "Pr(>F)" = whole$p_val, check.names = FALSE)
    }))
    if (length(tested)) rownames(omnibus) <- tested
  } else {
    fit <- lmerTest::lmer(formula, mine, control = precise)
    table <- coef(summary(fit)); omnibus <- anova(fit, type = "III")
  }
  theta <- lme4::getME(fit, "theta")
  searched <- theta == 0 || theta > MOST_OF_ROUNDING
  if (!searched) not_here("df and p of the mixed model of", found$outcome[1],
                          "(people differ by nothing but what the search left)")
  of_search <- function(line, what, expected, value, size = 1e-9) {
    compare(line, what, expected, value, paste("mixed model,", line$term), size,
            LARGEST_OF_A_SEARCH)
  }
  for (k in seq_len(nrow(terms))) {
    line <- terms[k, ]; row <- table[coefficient[line$term], ]
    of_search(line, "estimate", line$estimate, row[["Estimate"]],
              max(as.numeric(line$standard_error), 1e-9))
    if (is.na(line$p)) next
    of_search(line, "standard error", line$standard_error, row[["Std. Error"]])
    if (!searched) next
    of_search(line, "df", line$df, row[["df"]])
    of_search(line, "p", line$p, row[["Pr(>|t|)"]])
  }
  for (k in seq_len(nrow(whole))) {
    line <- whole[k, ]
    if (is.na(line$f)) next
    row <- omnibus[called[line$term], ]
    of_search(line, "F", line$f, row[["F value"]], 1e-2)
    if (searched) of_search(line, "p of F", line$p, row[["Pr(>F)"]])
  }
}
found <- read_if_there("mixed_models")
if (!is.null(found) && !requireNamespace("lmerTest", quietly = TRUE)) {
  not_here("the mixed models (package lmerTest is not installed)")
} else if (!is.null(found)) {
  for (one in split(found, found$outcome)) {
    mixed_of(one)
    models <- models + 1
  }
}
"""

MIXED_MODELS = Analysis(
    "mixed_models",
    AnalysisSet.ALL_AVAILABLE,
    _compute,
    section="models",
    place=130,
    order=130,
    tables=(_TABLE, _TABLE_OF_EFFECTS, _TABLE_OF_MEANS),
    remarks=_remarks,
    methods=_methods,
    r_lines=_R_LINES,
)
