"""Linear mixed models of all available data, and the crossover, which has a closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.special import stdtr, stdtrit
from scipy.stats import t as t_distribution

from vrcomfort.errors import InputError
from vrcomfort.stats.cluster_robust import cluster_robust
from vrcomfort.stats.random_intercept import FTest, fit_independent, fit_random_intercept

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import pandas as pd
    from numpy.typing import ArrayLike, NDArray

    from vrcomfort.stats.cluster_robust import ClusterRobust
    from vrcomfort.stats.random_intercept import RandomIntercept

    Floats = NDArray[np.float64]

Errors = Literal["cluster_robust", "model"]
"""Of a mixed model: robust to its assumptions about people (CR2), or its own."""

ROUNDING = 1e-12
"""Share of the largest score below which a difference, or its spread, is rounding."""

# The two-period crossover: condition, period and sequence (carry-over) effects.
#
# With one value per participant and period, the mixed model with a random participant has a
# closed form: condition and period are tested on the differences between periods, the sequence on
# the sums (Grizzle 1965; Jones & Kenward 2014, chapter 2). The estimates, standard errors and
# degrees of freedom equal those of the mixed model with Satterthwaite's method.


@dataclass(frozen=True)
class Estimate:
    """A fixed effect with its t test."""

    estimate: float
    standard_error: float
    df: float
    t: float | None
    p: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Crossover:
    """The three effects of an AB/BA crossover, in points of the score."""

    n_ab: int
    n_ba: int
    condition: Estimate
    """a minus b."""
    period: Estimate
    """Second period minus first."""
    sequence: Estimate
    """Sequence ba minus ab, of the participants' means; carry-over shows here."""


def crossover(
    first: ArrayLike, second: ArrayLike, a_first: ArrayLike, *, confidence: float = 0.95
) -> Crossover:
    """Analyse a two-period crossover.

    Parameters
    ----------
    first, second
        Scores in the first and second period, shape (n,).
    a_first
        Whether the participant had condition a in the first period, shape (n,).

    Raises
    ------
    InputError
        If a sequence has nobody, or there are fewer than three participants.
    """
    one, two = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    ab = np.asarray(a_first, dtype=bool)
    if not ab.any() or ab.all():
        raise InputError("a crossover analysis needs participants in both orders")
    if ab.size < 3:
        raise InputError("a crossover analysis needs at least three participants")
    half, mean = (one - two) / 2, (one + two) / 2
    rounding = ROUNDING * float(np.abs([one, two]).max())
    return Crossover(
        n_ab=int(ab.sum()),
        n_ba=int((~ab).sum()),
        condition=_difference(half[ab], half[~ab], confidence, rounding),
        period=_difference(-half[ab], half[~ab], confidence, rounding),
        sequence=_difference(mean[~ab], mean[ab], confidence, rounding),
    )


def _difference(
    x: NDArray[np.float64], y: NDArray[np.float64], confidence: float, rounding: float
) -> Estimate:
    """Estimate mean(x) − mean(y) with the pooled variance; rounding errors count as 0."""
    df = x.size + y.size - 2
    spread = float(np.sqrt((np.sum((x - x.mean()) ** 2) + np.sum((y - y.mean()) ** 2)) / df))
    error = spread * math.sqrt(1 / x.size + 1 / y.size) if spread > rounding else 0.0
    difference = float(x.mean() - y.mean())
    return t_estimate(difference if abs(difference) > rounding else 0.0, error, df, confidence)


def t_estimate(estimate: float, error: float, df: float, confidence: float) -> Estimate:
    """Return `estimate` with its two-sided t test; no test without error variance or df."""
    if not (error > 0 and df > 0):
        return Estimate(estimate, error, df, None, None, None, None)
    t = estimate / error
    half = float(stdtrit(df, (1 + confidence) / 2)) * error
    p = float(2 * stdtr(df, -abs(t)))
    return Estimate(estimate, error, df, t, p, estimate - half, estimate + half)


# Estimated marginal means of a mixed model, and their pairwise differences.
#
# Each level's mean is that of the model with all levels of the other factors weighing alike and
# covariates at their means (Searle, Speed & Milliken 1980), as R's ``lmerTest::ls_means`` has it.


MOST_LEVELS = 12
"""Levels up to which all pairs are compared."""


@dataclass(frozen=True)
class Pairwise:
    """The difference of two marginal means, adjusted for the number of pairs (Bonferroni)."""

    estimate: float
    standard_error: float
    df: float
    t: float | None
    p: float | None
    """Unadjusted."""
    p_adjusted: float | None
    low: float | None
    """Adjusted: the interval holds 0 exactly where `p_adjusted` is above 1 − confidence."""
    high: float | None


def marginal_means(
    fit: RandomIntercept | ClusterRobust,
    factors: Mapping[str, tuple[str, ...]],
    covariates: int,
    confidence: float,
) -> tuple[dict[str, dict[str, Estimate]], dict[str, dict[str, Pairwise]]]:
    """Return means and pairwise differences by factor.

    A factor with more than `MOST_LEVELS` levels has no pairwise differences.

    Parameters
    ----------
    fit
        Of a design with a column of ones, the treatment-coded columns of the factors in order
        (each factor's first level is its reference), and centred covariates.
    factors
        Factor → levels, the reference first.
    covariates
        How many columns follow those of the factors.
    """
    means, pairs = {}, {}
    for name, levels in factors.items():
        rows = {level: _row(factors, name, level, covariates) for level in levels}
        means[name] = {level: _estimated(fit, row, confidence) for level, row in rows.items()}
        compared = [*combinations(levels, 2)] if len(levels) <= MOST_LEVELS else []
        pairs[name] = {
            f"{one} − {two}": _pairwise(fit, rows[one] - rows[two], len(compared), confidence)
            for one, two in compared
        }
    return means, pairs


def _row(factors: Mapping[str, tuple[str, ...]], name: str, level: str, covariates: int) -> Floats:
    """Return the coefficients' weights in the mean of a level."""
    parts = [np.ones(1)]
    for factor, levels in factors.items():
        others = levels[1:]
        if factor == name:
            parts.append(np.array([float(each == level) for each in others]))
        else:
            parts.append(np.full(len(others), 1 / len(levels)))
    return np.concatenate([*parts, np.zeros(covariates)])


def _estimated(fit: RandomIntercept | ClusterRobust, row: Floats, confidence: float) -> Estimate:
    estimate, error = float(row @ fit.coefficients), fit.standard_error(row)
    return t_estimate(estimate, error, fit.degrees_of_freedom(row), confidence)


def _pairwise(
    fit: RandomIntercept | ClusterRobust, row: Floats, count: int, confidence: float
) -> Pairwise:
    found = _estimated(fit, row, confidence)
    if found.p is None:
        nothing = (None, None, None, None, None)
        return Pairwise(found.estimate, found.standard_error, found.df, *nothing)
    half = found.standard_error * float(
        t_distribution.isf((1 - confidence) / (2 * count), found.df)
    )
    return Pairwise(
        found.estimate, found.standard_error, found.df, found.t, found.p,
        min(1.0, count * found.p), found.estimate - half, found.estimate + half,
    )  # fmt: skip


# All available data: a linear mixed model with a random participant.
#
# Our own fit, because the standard errors of statsmodels' ``MixedLM`` (``bse_fe``) are not those
# of its own variance components where cells are missing, and it has no Satterthwaite degrees of
# freedom and no omnibus tests. See `random_intercept`.


@dataclass(frozen=True)
class MixedModel:
    """A random-intercept model, fitted by restricted maximum likelihood."""

    n_participants: int
    n_values: int
    errors: Errors
    intercept: Estimate
    """The mean at the reference levels and the means of the covariates."""
    terms: dict[str, Estimate]
    """Fixed effects by name: ``factor: level − reference level``; no intercept."""
    omnibus: dict[str, FTest]
    """Test of each factor, all of its levels together, given the others."""
    participant_sd: float | None
    """0 where people differ no more than the residuals let expect; None of a model without a random
    intercept."""
    residual_sd: float
    means: dict[str, dict[str, Estimate]]
    """Estimated marginal means by factor and level."""
    pairwise: dict[str, dict[str, Pairwise]]
    """Their differences, adjusted for the number of pairs; none of factors with many levels."""


def mixed_model(
    table: pd.DataFrame,
    *,
    value: str,
    participant: str,
    factors: Sequence[str],
    references: dict[str, str] | None = None,
    covariates: Sequence[str] = (),
    errors: Errors = "cluster_robust",
    confidence: float = 0.95,
    repeated: bool = True,
) -> MixedModel:
    """Fit ``value ~ factors + (1 | participant)`` to every row, complete participants or not.

    Standard errors are cluster-robust: CR2, with the fitted model as the working one, which holds
    its level with skewed scores of few people (Pustejovsky & Tipton 2018); see `cluster_robust`.
    Those of the model itself are those of generalised least squares at the fitted variances, as in
    R's ``lmerTest`` (Kuznetsova, Brockhoff & Christensen 2017), whose ``anova`` has the same
    omnibus tests. Degrees of freedom are Satterthwaite's in both.

    Parameters
    ----------
    factors
        Columns with categories. Those with one level are left out.
    references
        Reference level of a factor; the first in sorted order otherwise.
    covariates
        Columns with numbers, each an effect of one degree of freedom: points per unit.
    errors
        `cluster_robust` (CR2), or those of the `model`.
    repeated
        Whether participants have several values. A linear model without a random intercept is
        fitted to one value each.

    Raises
    ------
    InputError
        If too few values or no variance are left for a residual, or the factors cannot be told
        apart.
    """
    rows = table.dropna(subset=[value, participant, *factors, *covariates])
    columns = {
        factor: treatment_columns(rows, factor, (references or {}).get(factor))
        for factor in factors
    }
    columns |= {name: _centred(rows, name) for name in covariates}
    terms = {name: column for found in columns.values() for name, column in found.items()}
    if not terms:
        raise InputError("no effect has two levels in the data")
    design = np.column_stack([np.ones(len(rows)), *terms.values()])
    if np.linalg.matrix_rank(design) < design.shape[1]:
        names = " and ".join([*factors, *covariates])
        raise InputError(f"{names} cannot be told apart in these data")
    people, groups = np.unique(rows[participant].astype(str), return_inverse=True)
    values = rows[value].to_numpy(dtype=np.float64)
    fitted = (
        fit_random_intercept(values, design, groups)
        if repeated
        else fit_independent(values, design)
    )
    robust = errors == "cluster_robust"
    fit = cluster_robust(fitted, values, design, groups) if robust else fitted
    unit = np.eye(design.shape[1])
    places = {name: unit[i] for i, name in enumerate(terms, start=1)}

    levels = {
        factor: _levels(rows, factor, (references or {}).get(factor))
        for factor in factors
        if columns[factor]
    }
    others = sum(len(columns[name]) for name in covariates)
    means, pairwise = marginal_means(fit, levels, others, confidence)
    return MixedModel(
        n_participants=people.size,
        n_values=len(rows),
        errors=errors,
        intercept=_estimated(fit, unit[0], confidence),
        terms={name: _estimated(fit, row, confidence) for name, row in places.items()},
        omnibus=(
            {next(iter(columns)): fit.omnibus(_sequential_contrasts(design))}
            if len(columns) == 1
            else {
                factor: fit.omnibus(np.stack([places[name] for name in found]))
                for factor, found in columns.items()
                if found
            }
        ),
        participant_sd=float(np.sqrt(fitted.group_variance)) if repeated else None,
        residual_sd=float(np.sqrt(fitted.residual_variance)),
        means=means,
        pairwise=pairwise,
    )


def _sequential_contrasts(design: Floats) -> Floats:
    """Return the contrasts of all coefficients but the intercept, shape (p − 1, p).

    They are those that the ``anova`` of lmerTest takes for a model of one term: rows of the upper
    triangle of X'X = LU, each divided by its pivot (Goodnight 1979). Every basis gives one F; its
    denominator's df depend on the basis where the data are unbalanced.
    """
    pivots = np.linalg.cholesky(design.T @ design).T
    rows: Floats = pivots / np.diag(pivots)[:, None]
    return rows[1:]


def _centred(rows: pd.DataFrame, covariate: str) -> dict[str, Floats]:
    """Return a covariate without its mean, so that other effects are those at the mean."""
    values = rows[covariate].to_numpy(dtype=np.float64)
    return {covariate: values - values.mean()} if np.unique(values).size > 1 else {}


def treatment_columns(rows: pd.DataFrame, factor: str, reference: str | None) -> dict[str, Floats]:
    """Return the treatment-coded columns of one factor by name; none of one level."""
    values = rows[factor].astype(str).to_numpy(dtype=object)
    base, *others = _levels(rows, factor, reference) or ("",)
    return {f"{factor}: {level} − {base}": (values == level).astype(np.float64) for level in others}


def _levels(rows: pd.DataFrame, factor: str, reference: str | None) -> tuple[str, ...]:
    """Return the levels of a factor, the reference first."""
    found = sorted(map(str, rows[factor].unique()))
    base = reference if reference is not None else next(iter(found), "")
    return (base, *(level for level in found if level != base))
