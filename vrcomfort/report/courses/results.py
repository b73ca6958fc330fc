"""Everything that a report says of ratings over time, and of time to leaving."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.courses.curves import condition_curves
from vrcomfort.report.courses.events import event_results, of_leaving, of_threshold
from vrcomfort.report.courses.exposures import RatedExposure, rated_exposures, rated_instrument
from vrcomfort.report.courses.live_time import LiveClock
from vrcomfort.report.courses.summaries import describe, models, planned_s, sensitivity
from vrcomfort.report.courses.symptom_fits import symptom_fits
from vrcomfort.report.ordering import natural

if TYPE_CHECKING:
    from pathlib import Path

    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.stats.means import MeanCurves

Row = dict[str, Any]


@dataclass(frozen=True)
class Courses:
    """What was analysed, for tables and figures, beside the results."""

    exposures: list[RatedExposure]
    conditions: list[str]
    """With a rating or an exposure, in the order of the report."""
    curves: MeanCurves | None
    carried: MeanCurves | None
    """With the last rating of those who left carried forward; None where nobody left."""
    results: Row
    """`ratings` and `leaving`: each None where the data do not hold it."""


def analyse_courses(study: StudyData, plan: Plan, results: Row, folder: Path) -> Courses:
    """Analyse ratings during exposure, and who left when.

    Parameters
    ----------
    results
        Those of the report so far: conditions, contrasts and who was left out.
    folder
        Where the frames of the study are, which say what was live.

    Raises
    ------
    InputError
        If the plan names an instrument that was not rated, or ratings are damaged.
    """
    asked = plan.ratings
    instrument = rated_instrument(study, asked.instrument)
    exposures = rated_exposures(
        study, instrument, without=_left_out(study, results), clock=LiveClock(study, folder)
    )
    conditions = _conditions(exposures, list(results["labels"]))
    exposures = [e for e in exposures if e.condition in conditions]
    rated = [e for e in exposures if e.course.times_s.size]
    answered = [e for e in rated if e.course.answered.ratings.size]
    curves = carried = None
    if answered:
        curves = condition_curves(answered, conditions, plan.confidence)
        if any(e.left for e in answered):
            carried = condition_curves(answered, conditions, plan.confidence, carried=True)
    found: Row = {
        "ratings": _ratings(study, plan, results, exposures, conditions, instrument)
        if rated
        else None,
        "leaving": _leaving(plan, results, exposures, conditions),
    }
    if found["ratings"] is not None:
        found["ratings"]["curves"] = _curve_rows(curves, carried, conditions)
    return Courses(exposures, conditions, curves, carried, found)


def _left_out(study: StudyData, results: Row) -> set[str]:
    """Return who is in no analysis, by the experimenter or by a rule of the plan."""
    people = {p["participant"] for p in study.participants if p["status"] == "excluded"}
    rules = {x["participant"] for x in results["exclusions"] if x["what"] == "participant"}
    return people | rules


def _conditions(exposures: list[RatedExposure], labels: list[str]) -> list[str]:
    there = {e.condition for e in exposures} - {""} or {""}
    order = {name: place for place, name in enumerate(labels)}
    return sorted(there, key=lambda name: (order.get(name, len(order)), natural(name)))


def _pairs(results: Row) -> list[tuple[str, str]]:
    """Return the pairs of conditions that are compared."""
    tests = [t for t in results["tests"] if not any(side["timepoint"] for side in t["sides"])]
    return list(dict.fromkeys((t["a"], t["b"]) for t in tests))


def reference_of(results: Row, conditions: list[str]) -> str:
    """Return the condition that others are compared with: b of the only pair, or the first."""
    pairs = _pairs(results)
    if len(pairs) == 1 and pairs[0][1] in conditions:
        return pairs[0][1]
    return conditions[0]


def _times(asked: tuple[float, ...], longest: float) -> list[float]:
    quarters = [longest * part / 4 for part in (1, 2, 3, 4)]
    return sorted(asked) or [float(f"{time:.6g}") for time in quarters if time > 0]


def _ratings(
    study: StudyData,
    plan: Plan,
    results: Row,
    exposures: list[RatedExposure],
    conditions: list[str],
    instrument: str,
) -> Row:
    asked, known = plan.ratings, study.instruments.get(instrument)
    rated = [e for e in exposures if e.course.times_s.size]
    answered = [e for e in rated if e.course.answered.ratings.size]
    values = np.concatenate([e.course.answered.ratings for e in rated])
    low, high = (known.low, known.high) if known else _range(values)
    threshold = (low + high) / 2 if asked.threshold is None else asked.threshold
    reference = reference_of(results, conditions)
    return {
        "instrument": instrument,
        "short": known.short if known else instrument or "rating",
        "low": low,
        "high": high,
        "conditions": conditions,
        **_counts(rated),
        "summaries": [row for s in asked.summaries for row in describe(answered, s, conditions)],
        "models": models(answered, asked.summaries, reference, plan.confidence),
        "sensitivity": sensitivity(
            [e for e in exposures if e.course.answered.ratings.size or e.left],
            asked.summaries,
            reference,
            float(high),
            plan.confidence,
        ),
        "threshold": threshold,
        "threshold_planned": asked.threshold is not None,
        "reached": _reached(plan, results, answered, conditions, threshold),
        "symptom_model": symptom_fits(answered, conditions, asked, plan.confidence)
        if asked.symptom_model == "fast_slow"
        else None,
    }


def _range(values: np.ndarray[Any, Any]) -> tuple[float, float]:
    return (0.0, float(values.max())) if values.size else (0.0, 0.0)


def _counts(rated: list[RatedExposure]) -> Row:
    missed = [int(np.isnan(e.course.ratings).sum()) for e in rated]
    return {
        "exposures": len(rated),
        "people": len({e.participant for e in rated}),
        "asked": sum(e.course.ratings.size for e in rated),
        "missed": sum(missed),
        "without_answer": sum(not e.course.answered.ratings.size for e in rated),
        "left_early": sum(e.left for e in rated),
        "endings_recorded": any(e.ending != "not recorded" for e in rated),
        "not_live_s": sum(e.not_live_s for e in rated),
        "freezes": sum(len(e.freezes) for e in rated),
        "unplaced": sum(e.unplaced for e in rated),
        "planned_s": planned_s(rated),
    }


def _reached(
    plan: Plan,
    results: Row,
    answered: list[RatedExposure],
    conditions: list[str],
    threshold: float,
) -> list[Row]:
    """Return the time to the threshold: of all, and, where somebody left, under assumptions."""
    if not answered:
        return []
    times = _times(plan.ratings.times_s, max(e.ended_s for e in answered))
    ways = ["all available"]
    if any(e.left for e in answered):
        ways += ["completers", "worst case"]
    found = []
    for how in ways:
        events = of_threshold(answered, threshold, how=how)
        if events:
            reference = reference_of(results, conditions)
            pairs = _pairs(results)
            made = event_results(events, conditions, pairs, times, reference, plan.confidence)
            found.append({"analysis": how, **made})
    return found


def _leaving(
    plan: Plan, results: Row, exposures: list[RatedExposure], conditions: list[str]
) -> Row | None:
    """Return the time to leaving; None where no trial is recorded or nobody left."""
    events = of_leaving(exposures)
    if not any(e.came for e in events):
        return None
    times = _times((), max(e.time_s for e in events))
    reference, pairs = reference_of(results, conditions), _pairs(results)
    return event_results(events, conditions, pairs, times, reference, plan.confidence)


def _curve_rows(
    curves: MeanCurves | None, carried: MeanCurves | None, conditions: list[str]
) -> list[Row]:
    """Return the means as rows, one for each condition and time with an exposure."""
    if curves is None:
        return []
    rows = []
    for row, condition in enumerate(conditions):
        for place, time in enumerate(curves.times_s):
            if not curves.n[row, place]:
                continue
            mean, half = float(curves.mean[row, place]), float(curves.half[row, place])
            known = not np.isnan(half)
            rows.append(
                {
                    "condition": condition,
                    "time_s": float(time),
                    "n": int(curves.n[row, place]),
                    "mean": mean,
                    "low": mean - half if known else None,
                    "high": mean + half if known else None,
                    "carried_forward": None if carried is None else float(carried.mean[row, place]),
                }
            )
    return rows
