"""The whole analysis as one plain, ordered structure: what results.json holds."""

from __future__ import annotations

import json
import math
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from vrcomfort import __version__
from vrcomfort.report.contrasts import (
    conditions_of,
    contrasts_of,
    run_tests,
    sensitivity,
)
from vrcomfort.report.descriptives import describe_all, describe_recovery, mean_answers
from vrcomfort.report.exposures import score_exposures, unused_timepoints
from vrcomfort.report.models import (
    check_levels,
    run_anova,
    run_crossover,
    run_friedman,
    run_mixed,
)
from vrcomfort.report.notices import notices
from vrcomfort.report.ordering import natural
from vrcomfort.report.plan import check_outcomes, of_the_data
from vrcomfort.report.quality import quality
from vrcomfort.report.withdrawals import (
    count_withdrawals,
    everybody,
    find_withdrawals,
    lost_signs,
    sequences,
    why_not,
)
from vrcomfort.stats.means import RESAMPLES, SEED

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Contrast, Plan
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.report.withdrawals import Withdrawal

SOFTWARE = ("numpy", "scipy")
SCHEMA = 1
"""Version of the layout of results.json."""


def analyse(study: StudyData, plan: Plan) -> tuple[dict[str, Any], Exposures]:
    """Make every analysis of a plan.

    Returns
    -------
    dict, Exposures
        The results (only plain values) and the scores they come from.
    """
    check_outcomes(plan, study.instrument)
    scored = score_exposures(study, plan)
    plan = of_the_data(plan, study.instrument, scored.outcomes)
    conditions = conditions_of(scored.table, study.labels)
    contrasts = contrasts_of(plan, conditions, study.labels)
    check_levels(plan, scored.table, study.labels)
    named = [*conditions, *_unfinished(contrasts, conditions)]
    found = find_withdrawals(study)
    tests = run_tests(scored, plan, contrasts)
    analysed = _analysed(tests, scored.table)
    reasons = why_not(study, scored, found, in_every_test=_in_every_test(tests, analysed))
    results = {
        "schema": SCHEMA,
        "software": {"vrcomfort": __version__, **{name: version(name) for name in SOFTWARE}},
        "study": {"title": study.title, "protocol": study.protocol},
        "plan": plan.model_dump(mode="json"),
        "bootstrap": {"resamples": RESAMPLES, "seed": SEED},
        "score_basis": scored.basis,
        "instrument": _instrument(scored),
        "weights": scored.weights,
        "outcome_names": scored.titles,
        "conditions": [{"name": c, "label": study.labels.get(c, c)} for c in named],
        "participants": {
            "n": len(everybody(study)),
            "analysed": analysed,
            "left_out": [row for row in reasons if row["participant"] not in analysed],
            "in_some_tests": [row for row in reasons if row["participant"] in analysed],
            "exposures_per_condition": scored.planned,
            "sequences": sequences(study, analysed, found),
        },
        "notices": notices(study, scored, tests),
        "tests": tests,
        "sensitivity": _sensitivity(scored, plan, tests, found),
        "descriptives": describe_all(scored, plan, conditions, tests),
        "recovery": describe_recovery(scored, plan),
        "items": mean_answers(scored, conditions, tests),
        **_models(scored, plan, conditions, contrasts),
        "withdrawals": count_withdrawals(study, found),
        "quality": quality(study, scored, plan, unused_timepoints(study, plan)),
    }
    return plain(results), scored


def _instrument(scored: Exposures) -> dict[str, Any]:
    """Say what was asked, in words that a page needs."""
    asked = scored.instrument
    return {
        "name": asked.name,
        "short": asked.short,
        "title": asked.title,
        "citation": asked.citation,
        "rule": asked.rule,
        "primary": asked.primary,
        "answers": asked.answers.in_words,
        "items": {item.name: item.text for item in asked.items if item.name in scored.items},
    }


def _sensitivity(
    scored: Exposures, plan: Plan, tests: list[dict[str, Any]], found: list[Withdrawal]
) -> list[dict[str, Any]]:
    return [
        line
        for test in tests
        for line in sensitivity(scored, plan, test, lost_signs(found, test["a"], test["b"]))
    ]


def _models(
    scored: Exposures, plan: Plan, conditions: list[str], contrasts: list[Contrast]
) -> dict[str, list[dict[str, Any]]]:
    outcomes = plan.outcomes
    reference = _reference(contrasts, conditions)
    several = outcomes if len(conditions) > 2 else ()
    return {
        "anova": [run_anova(scored, plan, outcome) for outcome in outcomes],
        "friedman": [run_friedman(scored, conditions, outcome) for outcome in several],
        "crossover": [run_crossover(scored, c, outcome) for c in contrasts for outcome in outcomes],
        "mixed_models": [run_mixed(scored, plan, reference, outcome) for outcome in outcomes],
    }


def _unfinished(contrasts: list[Contrast], conditions: list[str]) -> list[str]:
    """Return the conditions that are compared although nobody finished them."""
    compared = dict.fromkeys(name for each in contrasts for name in (each.a, each.b))
    return [name for name in compared if name not in conditions]


def _reference(contrasts: list[Contrast], conditions: list[str]) -> str:
    """Return what the mixed model compares with: b of the only contrast, or the first."""
    if len(contrasts) == 1 and contrasts[0].b in conditions:
        return contrasts[0].b
    return next(iter(conditions), "")


def _analysed(tests: list[dict[str, Any]], table: pd.DataFrame) -> list[str]:
    """Everybody who is in a test; everybody with a score if there is nothing to test."""
    tested = {name for test in tests for name in test["participants"]}
    return sorted(tested if tests else table["participant"].unique(), key=natural)


def _in_every_test(tests: list[dict[str, Any]], analysed: list[str]) -> set[str]:
    """Who of the analysed is in every test that anybody is in."""
    return set(analysed).intersection(*(t["participants"] for t in tests if t["participants"]))


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
