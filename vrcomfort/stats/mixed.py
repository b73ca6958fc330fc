"""All available data: a linear mixed model with a random participant.

Our own fit, because the standard errors of statsmodels' ``MixedLM`` (``bse_fe``) are not those of
its own variance components where cells are missing, and it has no Satterthwaite degrees of
freedom and no omnibus tests. See `random_intercept`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.stats.crossover import Estimate, t_estimate
from vrcomfort.stats.marginal_means import Pairwise, marginal_means
from vrcomfort.stats.random_intercept import FTest, fit_random_intercept

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MixedModel:
    """A random-intercept model, fitted by restricted maximum likelihood."""

    n_participants: int
    n_values: int
    intercept: Estimate
    """The mean at the reference levels and the means of the covariates."""
    terms: dict[str, Estimate]
    """Fixed effects by name: ``factor: level − reference level``; no intercept."""
    omnibus: dict[str, FTest]
    """Test of each factor, all of its levels together, given the others."""
    participant_sd: float
    """0 where people differ no more than the residuals let expect."""
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
    confidence: float = 0.95,
) -> MixedModel:
    """Fit ``value ~ factors + (1 | participant)`` to every row, complete participants or not.

    Standard errors are those of generalised least squares at the fitted variances; degrees of
    freedom are Satterthwaite's, as in R's ``lmerTest`` (Kuznetsova, Brockhoff & Christensen 2017),
    whose ``anova`` has the same omnibus tests.

    Parameters
    ----------
    factors
        Columns with categories. Those with one level are left out.
    references
        Reference level of a factor; the first in sorted order otherwise.
    covariates
        Columns with numbers, each an effect of one degree of freedom: points per unit.

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
    fit = fit_random_intercept(rows[value].to_numpy(dtype=np.float64), design, groups)
    unit = np.eye(design.shape[1])
    places = {name: unit[i] for i, name in enumerate(terms, start=1)}

    def estimate(row: Floats) -> Estimate:
        error = float(np.sqrt(row @ fit.covariance @ row))
        df = fit.degrees_of_freedom(row)
        return t_estimate(float(row @ fit.coefficients), error, df, confidence)

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
        intercept=estimate(unit[0]),
        terms={name: estimate(row) for name, row in places.items()},
        omnibus=(
            {next(iter(columns)): fit.omnibus(_sequential_contrasts(design))}
            if len(columns) == 1
            else {
                factor: fit.omnibus(np.stack([places[name] for name in found]))
                for factor, found in columns.items()
                if found
            }
        ),
        participant_sd=float(np.sqrt(fit.group_variance)),
        residual_sd=float(np.sqrt(fit.residual_variance)),
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
