"""The whole analysis as one ordered structure: the content of results.json."""

from __future__ import annotations

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from vrcomfort import __version__
from vrcomfort.json_text import json_of
from vrcomfort.records.names import natural
from vrcomfort.report.analyses import AnalysisData, analysed_people, run_analyses
from vrcomfort.report.asked import unused_timepoints
from vrcomfort.report.contrasts import check_groups, conditions_of, contrasts_of
from vrcomfort.report.decisions import decide_all
from vrcomfort.report.derived_plan import with_outcomes
from vrcomfort.report.descriptives import describe_all, describe_recovery
from vrcomfort.report.deviations import deviations
from vrcomfort.report.exclusions import apply_rules, rules_in_words
from vrcomfort.report.exposures import score_exposures
from vrcomfort.report.factors import check_columns, check_levels
from vrcomfort.report.measures import Measure, definition_of
from vrcomfort.report.notices import notices
from vrcomfort.report.outcomes import Outcome
from vrcomfort.report.plan_files import in_order
from vrcomfort.report.quality import quality
from vrcomfort.report.rows import as_json, rounded
from vrcomfort.report.sensitivity import sensitivity
from vrcomfort.report.smallest_effect import smallest_effects
from vrcomfort.report.study_data import conditions_in
from vrcomfort.report.withdrawals import (
    count_withdrawals,
    everybody,
    find_withdrawals,
    sequences,
    why_not,
)
from vrcomfort.stats.means import RESAMPLES, SEED

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from vrcomfort.questionnaire import Instrument
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

SOFTWARE = ("numpy", "scipy", "pandas", "pingouin")
SCHEMA = 2
"""Version of the layout of results.json."""
PLAN_FILE = "plan.toml"


def analyse(study: StudyData, plan: Plan) -> tuple[dict[str, Any], Exposures]:
    """Make every analysis of a plan.

    Returns
    -------
    dict, Exposures
        The results (only plain values) and the scores they come from.
    """
    plan = with_outcomes(plan, study)
    scored, exclusions = apply_rules(score_exposures(study, plan), study, plan)
    conditions = conditions_of(scored, study.labels)
    asked = conditions_in(study, plan.exposure_timepoint)
    there = list(dict.fromkeys([*conditions, *study.labels, *asked]))
    check_groups(plan, scored)
    every = contrasts_of(plan, conditions, there)
    check_columns(plan, scored)
    check_levels(plan, scored, study.labels)
    found = find_withdrawals(study)
    reference = _reference([each for each in every if each.test == "signed_rank"], conditions)
    data = AnalysisData(study, scored, plan, conditions, reference, every, found, complete=False)
    made = decide_all(data, run_analyses(data))
    tests, compared = made.rows["tests"], [*made.rows["tests"], *made.rows["comparisons"]]
    tested = analysed_people(made.rows)
    analysed = _analysed(tested, scored.table)
    reasons = why_not(
        study,
        scored,
        found,
        exclusions,
        in_every_test=_in_every_test(tested, analysed),
    )
    named = [*conditions, *_unfinished(every, conditions)]
    results = {
        "without_primary": scored.without_primary or None,
        "schema": SCHEMA,
        "software": {"vrcomfort": __version__, **{name: version(name) for name in SOFTWARE}},
        "study": {"title": study.title, "protocol": study.protocol},
        "plan": {**in_order(plan), "sha256": plan.sha256, "file": PLAN_FILE},
        "deviations": [],
        "bootstrap": {"resamples": RESAMPLES, "seed": SEED},
        "seeds": [{"what": "bootstrap-t of means", "seed": SEED, "resamples": RESAMPLES}],
        **_what_was_asked(scored, study),
        "score_basis": scored.basis,
        "weights": dict(scored.units),
        "conditions": [{"name": c, "label": study.labels.get(c, c)} for c in named],
        "labels": _labels(named, every, study.labels),
        "participants": {
            "n": len(everybody(study)),
            "analysed": analysed,
            "left_out": [row for row in reasons if row["participant"] not in analysed],
            "in_some_tests": [row for row in reasons if row["participant"] in analysed],
            "exposures_per_condition": scored.planned,
            "sequences": sequences(study, analysed, found),
        },
        "exclusion_rules": rules_in_words(plan, scored, exclusions),
        "exclusions": exclusions,
        "notices": notices(study, scored, tests, exclusions, plan.of_choices),
        "families": made.families,
        **made.of("primary", "tests"),
        "sensitivity": sensitivity(data, tests),
        "smallest_effects": smallest_effects(plan, tests),
        "descriptives": describe_all(scored, plan, conditions, compared),
        "recovery": describe_recovery(scored),
        **made.of("models", "order"),
        "withdrawals": count_withdrawals(study, found),
        "quality": quality(study, scored, plan, unused_timepoints(study, plan)),
    }
    results["deviations"] = deviations(study, scored, plan, results)
    return rounded(results), scored


def _what_was_asked(scored: Exposures, study: StudyData) -> dict[str, Any]:
    """Describe the outcomes and the instruments that they are of."""
    instruments = dict.fromkeys(o.instrument for o in scored.outcomes if isinstance(o, Outcome))
    return {
        "outcomes": [
            {
                "name": each.name,
                "title": each.title,
                "instrument": each.instrument,
                "unit": scored.units[each.name],
                "basis": scored.bases[each.name],
                "parts": each.parts,
                "unit_label": each.unit_label,
                "better": each.better,
                "definition": definition_of(each) if isinstance(each, Measure) else "",
            }
            for each in scored.outcomes
        ],
        "instruments": [
            {
                "name": each.name,
                "short": each.short,
                "title": each.title,
                "citation": each.citation,
                "rule": each.rule,
                "asks": each.asks,
                "answers": _answers_in_words(each),
                "low": each.low,
                "high": each.high,
                "items": [{"name": item.name, "text": item.text} for item in each.asked],
            }
            for each in map(study.instruments.__getitem__, instruments)
        ],
    }


def _answers_in_words(instrument: Instrument) -> str:
    alike = all(item.answers == instrument.answers for item in instrument.asked)
    return instrument.answers.in_words if alike else "each with its own answers"


def _labels(named: list[str], contrasts: list[Compared], labels: dict[str, str]) -> dict[str, str]:
    """Return the label of every condition, and of every other side of a contrast."""
    found = {name: labels.get(name, name) for name in named}
    for side in (side for each in contrasts for side in (each.a, each.b)):
        condition = labels.get(side.condition, side.condition)
        parts = [part for part in (side.level, condition, side.timepoint) if part]
        found.setdefault(side.name, ", ".join(parts))
    return found


def _unfinished(contrasts: list[Compared], conditions: list[str]) -> list[str]:
    """Return the conditions that are compared although nobody finished them."""
    sides = [side for each in contrasts for side in (each.a, each.b)]
    compared = dict.fromkeys(side.condition for side in sides if side.condition)
    return [name for name in compared if name not in conditions]


def _reference(contrasts: list[Compared], conditions: list[str]) -> str:
    """Return the reference condition of models: b of the only contrast, or the first."""
    if len(contrasts) == 1 and contrasts[0].b.condition in conditions:
        return contrasts[0].b.condition
    return next(iter(conditions), "")


def _analysed(tests: list[Sequence[str]], table: pd.DataFrame) -> list[str]:
    """Return the participants of all tests; all with a score if there is nothing to test."""
    tested = {name for people in tests for name in people}
    return sorted(tested if tests else table["participant"].unique(), key=natural)


def _in_every_test(tests: list[Sequence[str]], analysed: list[str]) -> set[str]:
    """Return the participants of every test that has any."""
    return set(analysed).intersection(*(people for people in tests if people))


def to_json(results: dict[str, Any]) -> str:
    """Write results.json."""
    return json_of(as_json(results)) + "\n"
