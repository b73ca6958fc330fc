"""Analyses of variance of a plan's factors, on scores and on aligned ranks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup
from scipy.stats import shapiro

from vrcomfort.errors import InputError
from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import (
    ITALIC_P,
    MOST_NAMED,
    P_HOLM,
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    Remark,
    ReportContext,
    Sentence,
    TableColumn,
    estimable,
    html,
    missing_outcomes,
    p_in_html,
)
from vrcomfort.report.factors import is_between, level_of, points
from vrcomfort.report.pairs import with_every_score
from vrcomfort.report.rows import INLINE
from vrcomfort.report.words import NONE, degrees, fraction, number, p_equals, p_value
from vrcomfort.stats.anova import AnovaEffect, anova
from vrcomfort.stats.rank_anova import aligned_ranks

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Factor
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.anova import Sphericity
    from vrcomfort.stats.effects import EffectSize

P_GG = Markup("<i>p</i> GG")
MOST_FOR_SHAPIRO = 5000
"""Residuals up to which the p of Shapiro and Wilk's test is accurate."""


@dataclass(frozen=True)
class AnovaEffectRow:
    """An effect, with its p adjusted in the plan's family.

    Parameters
    ----------
    shown
        Whether the p that decides is small enough; None where no family tests the effect.
    """

    test: AnovaEffect = field(metadata=INLINE)
    family: str | None = None
    p_holm: float | None = None
    shown: bool | None = None


@dataclass(frozen=True)
class ResidualCheck:
    """Shapiro and Wilk's test of the residuals."""

    shapiro_w: float
    p: float
    n: int


@dataclass(frozen=True)
class AnovaFit:
    """The effects, and the people they are of.

    Parameters
    ----------
    means
        Factor → level → mean of the cells of that level, each participant weighing alike.
    """

    factors: dict[str, list[str]]
    means: dict[str, dict[str, float]]
    between: tuple[str, ...]
    sums_of_squares: str
    n: int
    participants: tuple[str, ...]
    excluded: tuple[str, ...]
    effects: tuple[AnovaEffectRow, ...]
    aligned_ranks: tuple[AnovaEffect, ...]
    residuals: ResidualCheck | None


@dataclass(frozen=True)
class AnovaRow:
    """The analysis of variance of one outcome."""

    outcome: str
    not_tested: str | None
    fit: AnovaFit | None = field(metadata=INLINE)


def _compute(data: AnalysisData, _: Sequence[object]) -> list[AnovaRow]:
    outcomes = data.scored.outcomes if data.plan.anova else ()
    return [_row(data, each.name) for each in outcomes]


def _row(data: AnalysisData, outcome: str) -> AnovaRow:
    return AnovaRow(outcome, *estimable(lambda: _fit(data, outcome)))


def _fit(data: AnalysisData, outcome: str) -> AnovaFit:
    scored, plan = data.scored, data.plan
    over_time = any(factor.column == "timepoint" for factor in plan.anova)
    table = points(scored.moments if over_time else scored.table, scored, outcome)
    made = [(f, level_of(scored, table, f)) for f in plan.anova]
    # A plan may name factors that a study lacks, as the scenes of a study with one.
    made = [(f, levels) for f, levels in made if len(levels.dropna().unique()) > 1]
    if not made:
        raise InputError("no factor has two levels in the data")
    long = table.assign(**{f.name: levels for f, levels in made})
    between = [f.name for f, _ in made if is_between(f)]
    within = [f.name for f, _ in made if not is_between(f)]
    names = [f.name for f, _ in made]
    whole = long[long[names].notna().all(axis=1)]
    if data.complete:
        whole = _with_every_score(scored, outcome, whole, [factor for factor, _ in made])
    cells = whole.groupby(["participant", *names])["score"].mean().reset_index()
    ranked: tuple[AnovaEffect, ...] = ()
    if plan.aligned_ranks:
        result, ranked = aligned_ranks(
            cells, value="score", participant="participant", within=within, between=between,
            sums_of_squares=plan.sums_of_squares,
        )  # fmt: skip
    else:
        result = anova(
            cells, value="score", participant="participant", within=within, between=between,
            sums_of_squares=plan.sums_of_squares,
        )  # fmt: skip
    people = set(cells["participant"]) - set(result.excluded)
    analysed = cells[cells["participant"].isin(people)]
    return AnovaFit(
        factors={n: sorted(map(str, cells[n].unique())) for n in names},
        means={name: _means(analysed, name, names) for name in names},
        between=tuple(between),
        sums_of_squares=plan.sums_of_squares,
        n=result.n,
        participants=tuple(sorted(people, key=natural)),
        excluded=tuple(sorted(set(long["participant"]) - people, key=natural)),
        effects=tuple(map(AnovaEffectRow, result.effects)),
        aligned_ranks=tuple(ranked),
        residuals=_residual_check(result.residuals),
    )


def _means(cells: pd.DataFrame, factor: str, factors: list[str]) -> dict[str, float]:
    """Return level → mean of its cells, in which participants weigh alike."""
    means = cells.groupby(factors)["score"].mean().groupby(level=factor).mean()
    return {str(level): float(mean) for level, mean in means.items()}


def _with_every_score(
    scored: Exposures, outcome: str, rows: pd.DataFrame, factors: list[Factor]
) -> pd.DataFrame:
    """Return the rows of participants with every planned score in each cell of an ANOVA.

    How many are planned is known of conditions; where scenes, say, divide them, and where nothing
    tells conditions apart, it is the most frequent number.
    """
    of_conditions = [factor.name for factor in factors if factor.column == "condition"]
    divided = [f for f in factors if f.column != "condition" and not is_between(f)]
    if divided or not of_conditions:
        return with_every_score(rows, [factor.name for factor in factors])
    planned = scored.planned_of[outcome]
    levels = rows.groupby(of_conditions)["condition"].unique()
    wanted = {level: sum(planned.get(name, 1) for name in found) for level, found in levels.items()}
    return with_every_score(rows, of_conditions, wanted)


def _residual_check(residuals: NDArray[np.float64]) -> ResidualCheck | None:
    flat = residuals.ravel()
    # Of residuals that are rounding alone, or of three values, W says nothing.
    if not 4 <= flat.size <= MOST_FOR_SHAPIRO or np.ptp(flat) <= 1e-9:
        return None
    found = shapiro(flat)
    return ResidualCheck(float(found.statistic), float(found.pvalue), int(flat.size))


def reported_p(effect: AnovaEffect) -> float | None:
    """Return the p that counts: of an effect without sphericity, Greenhouse and Geisser's."""
    corrected = effect.p_greenhouse_geisser
    return effect.p if corrected is None else corrected


def _sentences(row: AnovaRow, words: Vocabulary) -> Iterator[Sentence]:
    """Yield the answers of the effects that a family of the plan tests."""
    for effect in row.fit.effects if row.fit else ():
        if row.fit and effect.family:
            yield _sentence(row.fit, effect, words.outcome(row.outcome))


def _sentence(fit: AnovaFit, row: AnovaEffectRow, outcome: str) -> Sentence:
    effect, factors = row.test, row.test.effect.split(" × ")
    what = f"effect of {factors[0]}"
    if len(factors) > 1:
        what = f"interaction of {', '.join(factors[:-1])} and {factors[-1]}"
    if effect.f is None:
        return Sentence(f"{outcome}: the {what} could not be tested (no variance of error).")
    p, adjusted = reported_p(effect), ""
    if row.p_holm is not None and row.p_holm != p:
        p, adjusted = row.p_holm, "Holm-adjusted "
    shape = effect.sphericity
    share = 1.0 if shape is None else shape.greenhouse_geisser
    df = f"{degrees(effect.df_effect * share)}, {degrees(effect.df_error * share)}"
    eta = fraction(effect.generalised_eta_squared)
    means = fit.means[factors[0]].items() if len(factors) == 1 else ()
    listed = ", ".join(f"{level} {number(mean)}" for level, mean in means)
    return Sentence(
        f"{outcome}: {f'an {what}' if row.shown else f'no {what}'} was shown; "
        f"F({df})\u00a0=\u00a0{number(effect.f)}, {adjusted}{p_equals(p)}, "
        f"η²G\u00a0=\u00a0{eta}, n\u00a0=\u00a0{fit.n}.",
        f"Means: {listed}." if listed else "",
    )


def _methods(rows: Sequence[AnovaRow], report: ReportContext) -> Iterator[MethodsParagraph]:
    if any(row.fit for row in rows):
        plotted = ""
        if report.drawn:
            plotted = " and are plotted over normal quantiles at Blom’s (1958) positions"
        yield MethodsParagraph(
            "Analysis of variance",
            f"The ANOVA uses type {report.plan.sums_of_squares} sums of squares (Maxwell et al., "
            "2018) and participants with every planned score in every cell. Sphericity: Mauchly’s "
            "(1940) test, and ε after Greenhouse & Geisser (1959, GG) and Huynh & Feldt (1976, "
            "HF). Effect sizes: generalised η² (Olejnik & Algina, 2003) and partial η², whose "
            "interval, in the tables, is that of the noncentral F distribution (Steiger, 2004). "
            f"Residuals were tested after Shapiro & Wilk (1965){plotted}.",
            ("maxwell_2018", "mauchly_1940", "greenhouse_1959", "huynh_1976", "olejnik_2003",
             "steiger_2004", "shapiro_1965", *(("blom_1958",) if report.drawn else ())),
        )  # fmt: skip
    if any(row.fit and row.fit.aligned_ranks for row in rows):
        yield MethodsParagraph(
            "Aligned ranks",
            "For each effect of the ANOVA scores were stripped of all other effects, ranked, and "
            "analysed in the same way (Wobbrock et al., 2011).",
            ("wobbrock_2011",),
        )


def _csv(row: AnovaRow) -> Iterator[Cells]:
    """Yield the effects, one line each."""
    fit = row.fit
    if fit is None:
        yield {"outcome": row.outcome, "not_tested": row.not_tested}
        return
    keys = {
        "outcome": row.outcome, "n": fit.n, "people_in_it": list(fit.participants),
        "between": list(fit.between), "type": fit.sums_of_squares,
    }  # fmt: skip
    for effect in fit.effects:
        numbers = asdict(effect.test)
        shape = numbers.pop("sphericity") or {}
        eta = numbers.pop("partial_eta_squared") or {}
        yield {
            **keys, **numbers, "family": effect.family, "p_holm": effect.p_holm,
            "partial_eta_squared": eta.get("estimate"),
            "partial_eta_squared_low": eta.get("low"),
            "partial_eta_squared_high": eta.get("high"),
            **{name: shape.get(name) for name in _SHAPE},
        }  # fmt: skip


_SHAPE = ("mauchly_w", "mauchly_p", "greenhouse_geisser", "huynh_feldt")
_OF_RANKS = ("effect", "f", "df_effect", "df_error", "p", "p_greenhouse_geisser", "p_huynh_feldt")


def _csv_of_ranks(row: AnovaRow) -> Iterator[Cells]:
    for effect in row.fit.aligned_ranks if row.fit else ():
        yield {"outcome": row.outcome, **{name: getattr(effect, name) for name in _OF_RANKS}}


def _remarks(rows: Sequence[AnovaRow], report: ReportContext) -> Iterator[Remark]:
    """Yield why there is none of some outcomes; and, among the assumptions, the residuals."""
    yield from missing_outcomes(rows, report, "ANOVA")
    checks = [_residuals(row.outcome, row.fit, report.words) for row in rows if row.fit]
    if checks:
        yield Remark(
            html(
                "Residuals (Shapiro–Wilk): {}. Scores of questionnaires are ordinal and skewed; "
                "where the residuals are far from normal, rely on the rank tests.",
                Markup("; ").join(checks),
            ),
            section="assumptions",
        )


def _residuals(outcome: str, fit: AnovaFit, words: Vocabulary) -> Markup:
    found = fit.residuals
    if found is None:
        return html("{} not available", words.outcome(outcome))
    name, w, p = words.outcome(outcome), fraction(found.shapiro_w, 3), p_in_html(found.p)
    return html("{} <i>W</i> = {}, {}", name, w, p)


def _title(row: AnovaRow, _: Sequence[AnovaRow], report: ReportContext) -> str:
    fit, outcome = row.fit, report.words.outcome(row.outcome)
    return f"{outcome}, n = {fit.n}{_missing(fit.excluded)}" if fit else ""


def _missing(people: Sequence[str]) -> str:
    if not people:
        return ""
    more = len(people) - MOST_NAMED
    named = ", ".join(people[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
    return f"; excluded for missing scores: {named}"


def _not_spherical(row: AnovaRow) -> list[AnovaEffect]:
    return [each.test for each in row.fit.effects if each.test.sphericity] if row.fit else []


def _ranked(row: AnovaRow) -> tuple[AnovaEffect, ...]:
    return row.fit.aligned_ranks if row.fit else ()


def _outcome_of(
    lines: Callable[[AnovaRow], Sequence[AnovaEffect]],
) -> Callable[[AnovaRow, Sequence[AnovaRow], ReportContext], str]:
    """Return the writer of an outcome's title, where it has lines."""
    return lambda row, _, report: report.words.outcome(row.outcome) if lines(row) else ""


def _note(rows: Sequence[AnovaRow], report: ReportContext) -> str:
    adjusted = any(each.p_holm is not None for row in rows if row.fit for each in row.fit.effects)
    return html(
        "Type {} sums of squares. {}Effects with one degree of freedom need no sphericity "
        "correction. The 90 % intervals of η²<sub>p</sub> are in <code>tables/anova.csv</code> "
        "alone: they belong to the uncorrected <i>p</i> and assume normal scores; with heavy tails "
        "they cover the true value in as few as .79 of studies.",
        report.plan.sums_of_squares,
        _OF_HOLM if adjusted else "",
    )


_OF_HOLM = html(
    "{} is of the family of tests, and of {} where sphericity is not assumed. ", P_HOLM, P_GG
)


def _note_without_corrections(rows: Sequence[AnovaRow], report: ReportContext) -> str:
    """Return the note on both tables, where there is no second one."""
    return "" if any(map(_not_spherical, rows)) else _note(rows, report)


def _eta(write: Callable[[EffectSize], str]) -> Callable[[AnovaEffect, object], str]:
    return lambda effect, _: (
        write(effect.partial_eta_squared) if effect.partial_eta_squared else NONE
    )


def _shape(write: Callable[[Sphericity], str]) -> Callable[[AnovaEffect, object], str]:
    return lambda effect, _: write(effect.sphericity) if effect.sphericity else NONE


def _corrected(epsilon: Callable[[Sphericity], float]) -> Callable[[AnovaEffect, object], str]:
    """Return the writer of degrees of freedom that an ε has corrected."""

    def cell(effect: AnovaEffect, _: object) -> str:
        if effect.sphericity is None:
            return NONE
        share = epsilon(effect.sphericity)
        return f"{number(effect.df_effect * share)}, {number(effect.df_error * share)}"

    return cell


_Column = TableColumn[AnovaEffect]
_EFFECT = _Column("Effect", lambda effect, _: effect.effect)
_F = (
    _Column(Markup("<i>F</i>"), lambda effect, _: number(effect.f)),
    _Column("df", lambda effect, _: f"{degrees(effect.df_effect)}, {degrees(effect.df_error)}"),
    _Column(ITALIC_P, lambda effect, _: p_value(effect.p)),
)
_ETA = (
    _Column(
        Markup("η²<sub>G</sub>"), lambda effect, _: fraction(effect.generalised_eta_squared, 3)
    ),
    _Column(Markup("η²<sub>p</sub>"), _eta(lambda eta: fraction(eta.estimate, 3))),
)


def _of_rows(columns: Iterable[_Column]) -> Iterator[TableColumn[AnovaEffectRow]]:
    """Yield columns of effects as those of rows that have one each."""
    for each in columns:
        yield TableColumn(each.heading, partial(_cell_of_test, each.cell))


def _cell_of_test(
    cell: Callable[[AnovaEffect, Vocabulary], str], row: AnovaEffectRow, words: Vocabulary
) -> str:
    return cell(row.test, words)


_TABLE: AnalysisTable[AnovaRow, AnovaEffectRow] = AnalysisTable(
    "anova",
    lambda _, report: f"Repeated-measures ANOVA of {report.words.scores}",
    (
        *_of_rows((_EFFECT, *_F)),
        TableColumn(P_HOLM, lambda row, _: p_value(row.p_holm)),
        *_of_rows(_ETA),
    ),
    lines=lambda row: row.fit.effects if row.fit else (),
    group=_title,
    note=_note_without_corrections,
    csv=_csv,
)
_TABLE_OF_CORRECTIONS: AnalysisTable[AnovaRow, AnovaEffect] = AnalysisTable(
    "",
    "The same effects where sphericity is not assumed: degrees of freedom and p corrected by ε",
    (
        _EFFECT,
        _Column(Markup("Mauchly <i>W</i>"), _shape(lambda found: fraction(found.mauchly_w, 3))),
        _Column(ITALIC_P, _shape(lambda found: p_value(found.mauchly_p))),
        _Column("ε GG", _shape(lambda found: fraction(found.greenhouse_geisser, 3))),
        _Column("df GG", _corrected(lambda found: found.greenhouse_geisser)),
        _Column(P_GG, lambda effect, _: p_value(effect.p_greenhouse_geisser)),
        _Column("ε HF", _shape(lambda found: fraction(found.huynh_feldt, 3))),
        _Column("df HF", _corrected(lambda found: found.huynh_feldt)),
        _Column(Markup("<i>p</i> HF"), lambda effect, _: p_value(effect.p_huynh_feldt)),
    ),
    lines=_not_spherical,
    group=_outcome_of(_not_spherical),
    note=_note,
    csv=lambda _: (),
)
_TABLE_OF_RANKS: AnalysisTable[AnovaRow, AnovaEffect] = AnalysisTable(
    "aligned_ranks",
    "The same effects on aligned ranks, each in an analysis of its own",
    (_EFFECT, *_F, _Column(P_GG, lambda effect, _: p_value(effect.p_greenhouse_geisser))),
    lines=_ranked,
    group=_outcome_of(_ranked),
    csv=_csv_of_ranks,
)

_R_LINES = r"""
# Every order of some names.
orders <- function(names) {
  if (length(names) < 2) return(list(names))
  each <- function(k) lapply(orders(names[-k]), function(rest) c(names[k], rest))
  do.call(c, lapply(seq_along(names), each))
}

# The analysis of variance of participants with a score in every cell.
anova_of <- function(found, columns) {
  names <- sub("^anova: ", "", columns)
  between <- names_in(found$between[1])
  mine <- data.frame(who = scores$participant, score = as.numeric(scores[[found$outcome[1]]]))
  called <- setNames(paste0("f", seq_along(names)), names)
  for (k in seq_along(names)) mine[[called[k]]] <- scores[[columns[k]]]
  mine <- mine[complete.cases(mine), ]
  within <- called[setdiff(names, between)]; between <- called[between]
  cell <- if (length(within)) do.call(paste, c(mine[within], sep = "\r")) else rep("", nrow(mine))
  wide <- tapply(mine$score, list(mine$who, cell), mean)
  wide <- wide[complete.cases(wide) & rownames(wide) %in% names_in(found$people_in_it[1]), ,
               drop = FALSE]
  people <- mine[match(rownames(wide), mine$who), between, drop = FALSE]
  people[] <- lapply(people, factor)
  old <- options(contrasts = c("contr.sum", "contr.poly")); on.exit(options(old))
  side <- if (length(between)) paste(between, collapse = "*") else "1"
  type <- found$type[1]
  if (!length(within)) {
    people$score <- wide[, 1]
    fit <- lm(as.formula(paste("score ~", side)), people)
    if (deviance(fit) <= 1e-20 * sum((people$score - mean(people$score))^2)) {
      not_here("the ANOVA of", found$outcome[1], "(groups are all that differs)")
      return(invisible())
    }
    made <- car::Anova(fit, type = type)
    made <- made[!rownames(made) %in% c("(Intercept)", "Residuals"), ]
    univariate <- cbind(made[, "Sum Sq"], made[, "F value"], made[, "Pr(>F)"])
    rownames(univariate) <- rownames(made); corrected <- NULL
  } else {
    fit <- lm(as.formula(paste("wide ~", side)), people)
    idata <- mine[match(colnames(wide), cell), within, drop = FALSE]
    idata[] <- lapply(idata, factor)
    # It warns of error matrices that leave no epsilon, and of epsilons above 1.
    made <- suppressWarnings(summary(car::Anova(fit, idata = idata, type = type,
      idesign = as.formula(paste("~", paste(within, collapse = "*")))), multivariate = FALSE))
    univariate <- unclass(made$univariate.tests)[, c("Sum Sq", "F value", "Pr(>F)"), drop = FALSE]
    corrected <- made$pval.adjustments
  }
  effects <- lapply(strsplit(rownames(univariate), ":", TRUE), function(term) {
    vapply(orders(names[match(term, called)]), paste, "", collapse = TIMES)
  })
  for (k in seq_len(nrow(found))) {
    line <- found[k, ]
    row <- which(vapply(effects, function(called) line$effect %in% called, logical(1)))
    about <- paste("ANOVA,", line$effect)
    if (!length(row) || is.na(line$f)) next
    compare(line, "sum of squares", line$sum_of_squares, univariate[row, 1], about, size = 1e-6)
    compare(line, "F", line$f, univariate[row, 2], about, size = 1e-6)
    compare(line, "p", line$p, univariate[row, 3], about)
    p <- univariate[row, 3]
    if (rownames(univariate)[row] %in% rownames(corrected)) {
      epsilon <- corrected[rownames(univariate)[row], ]
      if (anyNA(epsilon)) next
      compare(line, "epsilon, GG", line$greenhouse_geisser, epsilon[["GG eps"]], about)
      compare(line, "p, GG", line$p_greenhouse_geisser, epsilon[["Pr(>F[GG])"]], about)
      compare(line, "epsilon, HF", line$huynh_feldt, min(1, epsilon[["HF eps"]]), about)
      p <- epsilon[["Pr(>F[GG])"]]
    }
    in_family(line, p, about)
  }
}
found <- read_if_there("anova")
columns <- grep("^anova: ", names(scores), value = TRUE)
if (!is.null(found) && !length(columns)) {
  not_here("the ANOVA over time (its data are not in scores.csv)")
} else if (!is.null(found) && !requireNamespace("car", quietly = TRUE)) {
  not_here("the ANOVA (package car is not installed)")
} else if (!is.null(found)) {
  for (one in split(found, found$outcome)) {
    anova_of(one, columns)
    models <- models + 1
  }
}
"""

ANOVA = Analysis(
    "anova",
    AnalysisSet.COMPLETE_BLOCKS,
    _compute,
    section="models",
    place=-10,
    order=100,
    by_outcome=True,
    sentences=_sentences,
    tables=(_TABLE, _TABLE_OF_CORRECTIONS, _TABLE_OF_RANKS),
    remarks=_remarks,
    methods=_methods,
    r_lines=_R_LINES,
)
