"""What the models leave over: residuals of the analysis of variance, and differences in pairs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.report.estimation import differences

if TYPE_CHECKING:
    from typing import Any

    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan

    Floats = NDArray[np.float64]

WITHIN = ("condition", "scene", "position", "session")


@dataclass(frozen=True)
class Residuals:
    """What is left of one score, in points.

    Parameters
    ----------
    fitted, residuals
        Shape (n,): of the model with participants and cells; empty where there are none.
    differences
        Differences of the first comparison, shape (pairs,).
    """

    outcome: str
    fitted: Floats
    residuals: Floats
    a: str
    b: str
    differences: Floats


def residuals_of(
    scored: Exposures, plan: Plan, tests: list[dict[str, Any]], outcome: str
) -> Residuals:
    """Take participants and cells off one score; complete participants alone."""
    fitted, left = _of_cells(scored, plan, outcome)
    test = next((t for t in tests if t["outcome"] == outcome and not t["not_tested"]), None)
    if test is None:
        return Residuals(outcome, fitted, left, "", "", np.empty(0))
    return Residuals(outcome, fitted, left, test["a"], test["b"], differences(scored, test))


def _of_cells(scored: Exposures, plan: Plan, outcome: str) -> tuple[Floats, Floats]:
    table, unit = scored.table.dropna(subset=[outcome]), scored.units[outcome]
    factors = [
        factor.column
        for factor in plan.anova
        if factor.column in WITHIN and table[factor.column].nunique() > 1
    ]
    if not factors:
        return np.empty(0), np.empty(0)
    means = table.groupby(["participant", *factors])[outcome].mean().astype(float) * unit
    scores = means.unstack(factors).dropna().to_numpy(dtype=float)
    if len(scores) < 2:
        return np.empty(0), np.empty(0)
    fitted = scores.mean(axis=0) + scores.mean(axis=1, keepdims=True) - scores.mean()
    return fitted.ravel(), (scores - fitted).ravel()
