"""All available data: a linear mixed model with a random participant."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from statsmodels.regression.mixed_linear_model import MixedLM

from vrcomfort.errors import InputError
from vrcomfort.stats.crossover import Estimate, t_estimate

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    People = NDArray[np.object_]


@dataclass(frozen=True)
class MixedModel:
    """A random-intercept model, fitted by restricted maximum likelihood."""

    n_participants: int
    n_values: int
    terms: dict[str, Estimate]
    """Fixed effects by name: ``factor: level − reference level``; no intercept."""
    participant_sd: float
    residual_sd: float
    notes: tuple[str, ...]
    """What the optimiser had to say; empty if it converged inside the parameter space."""


def mixed_model(
    table: pd.DataFrame,
    *,
    value: str,
    participant: str,
    factors: Sequence[str],
    references: dict[str, str] | None = None,
    confidence: float = 0.95,
) -> MixedModel:
    """Fit ``value ~ factors + (1 | participant)`` to every row, complete participants or not.

    Degrees of freedom are those of the inner level, values − participants − terms that vary
    within participants, as in R's ``nlme``; in a balanced crossover they are Satterthwaite's.

    Parameters
    ----------
    factors
        Columns with categories. Those with one level are left out.
    references
        Reference level of a factor; the first in sorted order otherwise.

    Raises
    ------
    InputError
        If too few values or no variance are left for a residual, or the factors cannot be told
        apart.
    """
    rows = table.dropna(subset=[value, participant, *factors])
    columns = _columns(rows, factors, references or {})
    names = list(columns)
    design = np.column_stack([np.ones(len(rows)), *columns.values()])
    people = rows[participant].astype(str).to_numpy(dtype=object)
    inner = sum(_varies_within(column, people) for column in columns.values())
    df = len(rows) - np.unique(people).size - inner
    if df < 1:
        raise InputError("too few values for a mixed model")
    if np.linalg.matrix_rank(design) < design.shape[1]:
        raise InputError(f"{' and '.join(factors)} cannot be told apart in these data")
    fit, errors, notes = _fit(rows[value].to_numpy(dtype=np.float64), design, people)
    estimates = np.asarray(fit.fe_params)
    return MixedModel(
        n_participants=int(np.unique(people).size),
        n_values=len(rows),
        terms={
            name: t_estimate(float(estimates[i]), float(errors[i]), df, confidence)
            for i, name in enumerate(names, start=1)
        },
        participant_sd=float(np.sqrt(np.asarray(fit.cov_re).item())),
        residual_sd=float(np.sqrt(fit.scale)),
        notes=notes,
    )


def _columns(
    rows: pd.DataFrame, factors: Sequence[str], references: dict[str, str]
) -> dict[str, Floats]:
    """Treatment-coded columns by name."""
    columns = {}
    for factor in factors:
        values = rows[factor].astype(str).to_numpy(dtype=object)
        levels = sorted(set(values))
        if not levels:
            continue
        reference = references.get(factor, levels[0])
        for level in levels:
            if level != reference:
                name = f"{factor}: {level} − {reference}"
                columns[name] = (values == level).astype(np.float64)
    return columns


def _varies_within(
    column: Floats,
    people: People,
) -> bool:
    return any(np.unique(column[people == person]).size > 1 for person in np.unique(people))


def _fit(
    values: Floats,
    design: Floats,
    people: People,
) -> tuple[Any, Floats, tuple[str, ...]]:
    """Return the fit, the standard errors of the fixed effects and statsmodels' notes."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            fit = MixedLM(values, design, groups=people).fit(reml=True)
            errors = np.asarray(fit.bse_fe, dtype=np.float64)
        except np.linalg.LinAlgError as error:
            raise InputError("the scores leave no variance to model") from error
    if not np.isfinite(errors).all():  # everybody answered alike
        raise InputError("the scores leave no variance to model")
    return fit, errors, tuple(dict.fromkeys(str(w.message) for w in caught))
