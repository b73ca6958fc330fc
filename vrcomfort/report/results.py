"""The whole analysis as one plain, ordered structure: what results.json holds."""

from __future__ import annotations

import json
import math
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from vrcomfort.questionnaire import WEIGHTS
from vrcomfort.report.contrasts import (
    conditions_of,
    contrasts_of,
    describe,
    run_tests,
    sensitivity,
)
from vrcomfort.report.exposures import ITEMS, score_exposures
from vrcomfort.report.models import run_anova, run_crossover, run_friedman, run_mixed
from vrcomfort.report.pairs import planned_exposures
from vrcomfort.report.quality import quality
from vrcomfort.report.withdrawals import (
    count_withdrawals,
    everybody,
    find_withdrawals,
    left_out,
    lost_signs,
    sequences,
)

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

SCHEMA = 1
"""Version of the layout of results.json."""


def analyse(study: StudyData, plan: Plan) -> tuple[dict[str, Any], Exposures]:
    """Make every analysis of a plan.

    Returns
    -------
    dict, Exposures
        The results (only plain values) and the scores they come from.
    """
    scored = score_exposures(study, plan)
    table = scored.table
    conditions = conditions_of(table, study.labels)
    contrasts = contrasts_of(plan, conditions)
    found = find_withdrawals(study)
    tests = run_tests(table, plan, contrasts)
    analysed = list(tests[0]["participants"]) if tests else []
    results = {
        "schema": SCHEMA,
        "software": {name: version(name) for name in ("vrcomfort", "numpy", "scipy", "statsmodels")},
        "study": {"title": study.title, "protocol": study.protocol},
        "plan": plan.model_dump(mode="json"),
        "score_basis": scored.basis,
        "weights": dict(WEIGHTS),
        "conditions": [{"name": c, "label": study.labels.get(c, c)} for c in conditions],
        "participants": {
            "n": len(everybody(study)),
            "analysed": analysed,
            "left_out": left_out(study, scored, found, analysed),
            "exposures_per_condition": planned_exposures(table),
            "sequences": sequences(study, analysed, found),
        },
        "tests": tests,
        "sensitivity": [
            line for t in tests for line in sensitivity(table, plan, t, lost_signs(found, t["a"], t["b"]))
        ],
        "descriptives": _descriptives(table, plan, conditions),
        "items": _items(table, conditions, analysed),
        "anova": [run_anova(table, plan, outcome) for outcome in plan.outcomes],
        "friedman": [run_friedman(table, conditions, outcome) for outcome in plan.outcomes]
        if len(conditions) > 2
        else [],
        "crossover": [
            run_crossover(table, contrast, outcome)
            for contrast in contrasts
            for outcome in plan.outcomes
        ],
        "mixed_models": [run_mixed(table, plan, conditions, outcome) for outcome in plan.outcomes],
        "withdrawals": count_withdrawals(study, found),
        "quality": quality(study, scored),
    }
    return plain(results), scored


def _descriptives(
    table: pd.DataFrame, plan: Plan, conditions: list[str]
) -> list[dict[str, Any]]:
    """Describe all scored exposures by condition, and by condition and scene and position."""
    rows = []
    for outcome in plan.outcomes:
        for by in ("all", "scene", "position", "session"):
            levels = [""] if by == "all" else sorted(table[by].unique(), key=str)
            if by != "all" and len(levels) < 2:
                continue
            for level in levels:
                part = table if by == "all" else table[table[by] == level]
                for condition in conditions:
                    scores = part.loc[part["condition"] == condition, outcome]
                    if len(scores):
                        points = scores.to_numpy(dtype=float) * WEIGHTS[outcome]
                        rows.append({"outcome": outcome, "by": by, "level": str(level),
                                     "condition": condition, **describe(points)})  # fmt: skip
    return rows


def _items(
    table: pd.DataFrame, conditions: list[str], analysed: list[str]
) -> list[dict[str, Any]]:
    """Mean answer of each symptom by condition, of the analysed (of everybody, if nobody is)."""
    part = table[table["participant"].isin(analysed)] if analysed else table
    means = part.groupby("condition")[list(ITEMS)].mean()
    return [
        {"item": item, **{c: float(means.loc[c, item]) for c in conditions if c in means.index}}
        for item in ITEMS
    ]


def plain(value: Any) -> Any:
    """Make a structure of JSON's own types; numbers to 12 digits, NaN and infinity to null."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.12g}") if math.isfinite(value) else None
    return value


def to_json(results: dict[str, Any]) -> str:
    """Write results.json."""
    return json.dumps(results, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
