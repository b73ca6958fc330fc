"""ANOVA, crossover and mixed models of a plan; each says why where it cannot be made."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from scipy.stats import shapiro

from vrcomfort.csv_table import number_or_none
from vrcomfort.errors import InputError
from vrcomfort.report.exposures import COLUMNS, column_of
from vrcomfort.report.ordering import natural
from vrcomfort.report.pairs import Side, side_sums, with_every_score
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.anova import AnovaEffect, anova
from vrcomfort.stats.mixed import crossover, mixed_model
from vrcomfort.stats.rank_anova import aligned_ranks, friedman

if TYPE_CHECKING:
    from collections.abc import Callable

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Factor, Plan

Result = dict[str, Any]

WITHIN = frozenset(["condition", "scene", "position", "session", "timepoint", "part"])
"""Columns that change within participants, unless a plan says otherwise."""
MOST_FOR_SHAPIRO = 5000
"""Residuals up to which the p of Shapiro and Wilk's test is accurate."""


def guarded(outcome: str, analyse: Callable[[], Result]) -> Result:
    """Return an analysis with its outcome, or the sentence that says why there is none."""
    try:
        return {"outcome": outcome, "not_tested": None, **analyse()}
    except InputError as error:
        return {"outcome": outcome, "not_tested": error.message}


def points(table: pd.DataFrame, scored: Exposures, outcome: str) -> pd.DataFrame:
    """Return the exposures that have a score, with the score in points in column `score`."""
    rows = table.dropna(subset=[outcome])
    return rows.assign(score=rows[outcome].astype(float) * scored.units[outcome])


def run_anova(scored: Exposures, plan: Plan, outcome: str) -> Result:
    """ANOVA of one outcome over the plan's factors."""
    return guarded(outcome, lambda: _anova(scored, plan, outcome))


def _anova(scored: Exposures, plan: Plan, outcome: str) -> Result:
    over_time = any(factor.column == "timepoint" for factor in plan.anova)
    table = points(scored.moments if over_time else scored.table, scored, outcome)
    made = [(f, level_of(scored, table, f)) for f in plan.anova]
    made = [(f, levels) for f, levels in made if len(levels.dropna().unique()) > 1]
    if not made:
        raise InputError("no factor has two levels in the data")
    long = table.assign(**{f.name: levels for f, levels in made})
    between = [f.name for f, _ in made if is_between(f)]
    within = [f.name for f, _ in made if not is_between(f)]
    names = [f.name for f, _ in made]
    whole = long.dropna(subset=names)
    if plan.needs_every_score:
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
    return {
        "factors": {n: sorted(map(str, cells[n].unique())) for n in names},
        "between": between,
        "sums_of_squares": plan.sums_of_squares,
        "n": result.n,
        "participants": sorted(people, key=natural),
        "excluded": sorted(set(long["participant"]) - people, key=natural),
        "effects": [
            {**asdict(effect), "family": None, "p_holm": None} for effect in result.effects
        ],
        "aligned_ranks": [asdict(effect) for effect in ranked],
        "residuals": _residual_check(result.residuals),
    }


def _with_every_score(
    scored: Exposures, outcome: str, rows: pd.DataFrame, factors: list[Factor]
) -> pd.DataFrame:
    """Return the rows of who has every planned score, in each cell of an ANOVA.

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


def level_of(scored: Exposures, table: pd.DataFrame, factor: Factor) -> pd.Series:
    """Return a factor's level in each row; missing where the data do not say it."""
    return column_of(scored, table, factor.column).map(
        lambda value: factor.levels.get(str(value), str(value)), na_action="ignore"
    )


def is_between(factor: Factor) -> bool:
    """Return whether a factor groups participants."""
    return (factor.kind or ("within" if factor.column in WITHIN else "between")) == "between"


def check_columns(plan: Plan, scored: Exposures) -> None:
    """Raise InputError where a plan names a column that the data do not have."""
    for i, factor in enumerate(plan.anova):
        check_column(plan, scored, factor.column, "anova", i, "column")
    for key, names in (("mixed_model", plan.mixed_model), ("covariates", plan.covariates)):
        for i, name in enumerate(names):
            check_column(plan, scored, name, key, i)
    for index, name in enumerate(plan.covariates):
        for who, person in scored.people.items():
            if person.get(name) and number_or_none(person[name]) is None:
                raise plan.fault(
                    f"covariate `{name}` of participant {who} is `{person[name]}`, which is no "
                    "number; give it to [[anova]] or mixed_model as a factor",
                    "covariates",
                    index,
                )


def check_column(plan: Plan, scored: Exposures, column: str, *path: str | int) -> None:
    """Raise InputError where the data do not have a column, with its place in the plan."""
    said = {column for person in scored.people.values() for column in person}
    there = {*COLUMNS, *said} - {"number", "early", "participant", "status", "note", "enrolled_at"}
    if column not in there:
        raise plan.fault(
            f"`{column}` is no column of the questionnaires or of participants.csv; "
            f"{did_you_mean(column, there)}",
            *path,
        )


def check_levels(plan: Plan, scored: Exposures, labels: dict[str, str]) -> None:
    """Raise InputError where a factor of the plan renames a level that does not exist."""
    for index, factor in enumerate(plan.anova):
        values = column_of(scored, scored.moments, factor.column).dropna().unique()
        there = {str(value) for value in values}
        there |= set(labels) if factor.column == "condition" else set()
        for level in factor.levels:
            if there and level not in there:
                known = ", ".join(sorted(there, key=natural))
                raise plan.fault(
                    f"the analysis plan renames level `{level}` of {factor.column} in factor "
                    f"`{factor.name}`; the data have {known}",
                    "anova",
                    index,
                    "levels",
                    level,
                )


def _residual_check(residuals: np.ndarray[Any, np.dtype[np.float64]]) -> Result | None:
    flat = residuals.ravel()
    if not 4 <= flat.size <= MOST_FOR_SHAPIRO or np.ptp(flat) <= 1e-9:
        return None
    found = shapiro(flat)
    return {"shapiro_w": float(found.statistic), "p": float(found.pvalue), "n": int(flat.size)}


def run_friedman(scored: Exposures, plan: Plan, conditions: list[str], outcome: str) -> Result:
    """Friedman's test over more than two conditions, on integer sums of the planned scores."""
    return guarded(outcome, lambda: _friedman(scored, plan, conditions, outcome))


def _friedman(scored: Exposures, plan: Plan, conditions: list[str], outcome: str) -> Result:
    sides = [Side(condition) for condition in conditions]
    people, sums, _ = side_sums(scored, outcome, sides, complete=plan.needs_every_score)
    return {"participants": people, **asdict(friedman(sums))}


def run_crossover(scored: Exposures, plan: Plan, a: str, b: str, outcome: str) -> Result:
    """Condition, position and sequence effects where everybody keeps one order of a and b."""
    table = points(scored.table, scored, outcome)
    planned = scored.planned_of[outcome]
    if not plan.needs_every_score:
        planned = dict.fromkeys(planned, 1)
    done = guarded(outcome, lambda: _crossover(table, a, b, planned))
    return {"a": a, "b": b, **done}


def _crossover(table: pd.DataFrame, a: str, b: str, planned: dict[str, int]) -> Result:
    pair = table[table["condition"].isin([a, b])]
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
    a_first = (place[a] < place[b]).to_numpy()
    first = np.where(a_first, score[a], score[b])
    second = np.where(a_first, score[b], score[a])
    found = asdict(crossover(first, second, a_first))
    return {**found, "left_out": left_out, "planned": {a: planned[a], b: planned[b]}}


def _without_one_place(pair: pd.DataFrame) -> list[str]:
    """Return the few who met one condition in different positions, as with a repeated exposure."""
    places = pair.groupby(["participant", "condition"])["position"].nunique()
    people = places[places > 1].index.get_level_values("participant").unique()
    if 2 * len(people) > pair["participant"].nunique():
        raise InputError("most participants met one condition in different positions")
    return sorted(map(str, people), key=natural)


def run_mixed(scored: Exposures, plan: Plan, reference: str, outcome: str) -> Result:
    """Linear mixed model of every scored exposure; conditions are compared with `reference`."""
    return guarded(outcome, lambda: _mixed(scored, plan, reference, outcome))


def _mixed(scored: Exposures, plan: Plan, reference: str, outcome: str) -> Result:
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
                references={"condition": reference},
                covariates=covariates,
                confidence=plan.confidence,
            )
        except InputError:
            if len(factors) + len(covariates) == 1:
                raise
            left_out.insert(0, (covariates if len(factors) < 2 else factors).pop())
            continue
        return {**asdict(model), "left_out": left_out}
    raise InputError("no effect has two levels in the data")
