"""ANOVA, crossover and mixed models of a plan; each says why where it cannot be made."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import shapiro

from vrcomfort.errors import InputError
from vrcomfort.report.ordering import natural
from vrcomfort.report.pairs import condition_sums
from vrcomfort.stats.anova import anova
from vrcomfort.stats.crossover import crossover
from vrcomfort.stats.friedman import friedman
from vrcomfort.stats.mixed import mixed_model

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Contrast, Factor, Plan

Result = dict[str, Any]

MOST_FOR_SHAPIRO = 5000
"""Residuals up to which the p of Shapiro and Wilk's test is accurate."""


def guarded(outcome: str, analyse: Callable[[], Result]) -> Result:
    """Return an analysis with its outcome, or the sentence that says why there is none."""
    try:
        return {"outcome": outcome, "not_tested": None, **analyse()}
    except InputError as error:
        return {"outcome": outcome, "not_tested": error.message}


def points(scored: Exposures, outcome: str) -> pd.DataFrame:
    """Return the exposures with the weighted score in column `score`."""
    table = scored.table
    return table.assign(score=table[outcome].astype(float) * scored.weights[outcome])


def run_anova(scored: Exposures, plan: Plan, outcome: str) -> Result:
    """Repeated-measures ANOVA of one outcome over the plan's factors."""
    return guarded(outcome, lambda: _anova(points(scored, outcome), plan))


def _anova(table: pd.DataFrame, plan: Plan) -> Result:
    factors = [f for f in plan.anova if len(table[f.column].unique()) > 1]
    if not factors:
        raise InputError("no factor has two levels in the data")
    names = [factor.name for factor in factors]
    long = table.assign(**{f.name: _levels(table, f) for f in factors})
    cells = long.groupby(["participant", *names])["score"].mean().reset_index()
    result = anova(cells, value="score", participant="participant", within=names)
    return {
        "factors": {n: sorted(cells[n].astype(str).unique()) for n in names},
        "n": result.n,
        "excluded": list(result.excluded),
        "effects": [asdict(effect) for effect in result.effects],
        "residuals": _residual_check(result.residuals),
    }


def check_levels(plan: Plan, table: pd.DataFrame, labels: dict[str, str]) -> None:
    """Raise InputError where a factor of the plan renames a level that does not exist."""
    for factor in plan.anova:
        there = {str(value) for value in table[factor.column].unique()}
        there |= set(labels) if factor.column == "condition" else set()
        for level in factor.levels:
            if there and level not in there:
                known = ", ".join(sorted(there, key=natural))
                raise InputError(
                    f"the analysis plan renames level `{level}` of {factor.column} in factor "
                    f"`{factor.name}`; the data have {known}"
                )


def _levels(table: pd.DataFrame, factor: Factor) -> pd.Series:
    return table[factor.column].map(lambda value: factor.levels.get(str(value), str(value)))


def _residual_check(residuals: np.ndarray[Any, np.dtype[np.float64]]) -> Result | None:
    flat = residuals.ravel()
    if not 4 <= flat.size <= MOST_FOR_SHAPIRO or np.ptp(flat) <= 1e-9:
        return None
    found = shapiro(flat)
    return {"shapiro_w": float(found.statistic), "p": float(found.pvalue), "n": int(flat.size)}


def run_friedman(scored: Exposures, conditions: list[str], outcome: str) -> Result:
    """Friedman's test over more than two conditions, on integer sums of complete people."""
    return guarded(outcome, lambda: _friedman(scored, conditions, outcome))


def _friedman(scored: Exposures, conditions: list[str], outcome: str) -> Result:
    _, sums, _ = condition_sums(scored.table, outcome, conditions, complete=scored.planned)
    return asdict(friedman(sums))


def run_crossover(scored: Exposures, contrast: Contrast, outcome: str) -> Result:
    """Condition, position and sequence effects where everybody keeps one order of a and b."""
    table = points(scored, outcome)
    done = guarded(outcome, lambda: _crossover(table, contrast, scored.planned))
    return {"a": contrast.a, "b": contrast.b, **done}


def _crossover(table: pd.DataFrame, contrast: Contrast, planned: dict[str, int]) -> Result:
    pair = table[table["condition"].isin([contrast.a, contrast.b])]
    if pair["condition"].nunique() < 2:
        raise InputError("nobody finished both conditions")
    if (pair["position"] == 0).any():
        raise InputError("the data do not say in which order the conditions came")
    left_out = _without_one_place(pair)
    pair = pair[~pair["participant"].isin(left_out)]
    if pair["position"].nunique() != 2:
        raise InputError("not a two-position crossover: conditions come in more than two places")
    grouped = pair.groupby(["participant", "condition"])
    score, count = grouped["score"].mean().unstack(), grouped.size().unstack()  # noqa: PD010
    place = grouped["position"].first().unstack()  # noqa: PD010
    complete = (count >= count.columns.map(planned)).all(axis=1)
    score, place = score[complete], place[complete]
    a_first = (place[contrast.a] < place[contrast.b]).to_numpy()
    first = np.where(a_first, score[contrast.a], score[contrast.b])
    second = np.where(a_first, score[contrast.b], score[contrast.a])
    return {**asdict(crossover(first, second, a_first)), "left_out": left_out}


def _without_one_place(pair: pd.DataFrame) -> list[str]:
    """Return the few who met one condition in different positions, as with a repeated exposure."""
    places = pair.groupby(["participant", "condition"])["position"].nunique()
    people = places[places > 1].index.get_level_values("participant").unique()
    if 2 * len(people) > pair["participant"].nunique():
        raise InputError("most participants met one condition in different positions")
    return sorted(map(str, people), key=natural)


def run_mixed(scored: Exposures, plan: Plan, reference: str, outcome: str) -> Result:
    """Linear mixed model of every scored exposure; conditions are compared with `reference`."""
    return guarded(outcome, lambda: _mixed(points(scored, outcome), plan, reference))


def _mixed(table: pd.DataFrame, plan: Plan, reference: str) -> Result:
    factors = [name for name in plan.mixed_model if len(table[name].unique()) > 1]
    left_out: list[str] = []
    while factors:
        try:
            model = mixed_model(
                table, value="score", participant="participant", factors=factors,
                references={"condition": reference}, confidence=plan.confidence,
            )  # fmt: skip
        except InputError:
            if len(factors) == 1:
                raise
            left_out.insert(0, factors.pop())
            continue
        return {**asdict(model), "left_out": left_out}
    raise InputError("no effect has two levels in the data")
