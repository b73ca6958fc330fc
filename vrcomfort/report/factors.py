"""Factors and covariates of models: their columns, their levels, and scores in points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from vrcomfort.csv_table import number_or_none
from vrcomfort.records.names import natural
from vrcomfort.report.exposures import COLUMNS, column_of, with_scores
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Factor, Plan

WITHIN = frozenset(["condition", "scene", "position", "session", "timepoint", "part"])
"""Columns that change within participants, unless a plan says otherwise."""


def points(table: pd.DataFrame, scored: Exposures, outcome: str) -> pd.DataFrame:
    """Return the exposures that have a score, with the score in points in column `score`."""
    rows = with_scores(table, outcome)
    return rows.assign(score=rows[outcome].astype(float) * scored.units[outcome])


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
            f"`{column}` is not a column of the questionnaires or of participants.csv; "
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
