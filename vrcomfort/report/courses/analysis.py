"""The analysis of ratings during exposure and of time to withdrawal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vrcomfort.report.courses.exposures import (
    LiveClock,
    RatedExposure,
    rated_exposures,
    rated_instrument,
)
from vrcomfort.report.courses.survival import event_results, of_leaving, of_threshold
from vrcomfort.report.courses.symptom_model import person_rows, symptom_fits
from vrcomfort.report.courses.time_courses import (
    condition_curves,
    describe,
    long_table,
    models,
    planned_s,
    sensitivity,
)
from vrcomfort.report.ordering import natural

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.stats.means import MeanCurves


Row = dict[str, Any]


@dataclass(frozen=True)
class TimeCourseAnalysis:
    """What was analysed, for tables and figures, beside the results."""

    exposures: list[RatedExposure]
    conditions: list[str]
    """With a rating or an exposure, in the order of the report."""
    curves: MeanCurves | None
    carried: MeanCurves | None
    """With the last rating of those who left carried forward; None where nobody left."""
    results: Row
    """`ratings` and `leaving`: each None where the data do not hold it."""


def analyse_time_courses(study: StudyData, plan: Plan, results: Row) -> TimeCourseAnalysis:
    """Analyse ratings during exposure, and who left when.

    Parameters
    ----------
    results
        Those of the report so far: conditions, contrasts and who was left out.

    Raises
    ------
    InputError
        If the plan names an instrument that was not rated, or ratings are damaged.
    """
    asked = plan.ratings
    instrument = rated_instrument(study, asked.instrument)
    exposures = rated_exposures(
        study, instrument, without=_left_out(study, results), clock=LiveClock(study)
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
    return TimeCourseAnalysis(exposures, conditions, curves, carried, found)


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


def course_tables(results: Row, courses: TimeCourseAnalysis) -> dict[str, list[Row]]:
    """Return name → rows of every table of ratings and of times to events."""
    ratings, leaving = results["ratings"], results["leaving"]
    found: dict[str, list[Row]] = {}
    if ratings is not None:
        found |= {
            "rated_exposures": long_table(e for e in courses.exposures if e.course.times_s.size),
            "rating_curves": ratings["curves"],
            "rating_summaries": ratings["summaries"],
            "rating_models": [row for model in ratings["models"] for row in _model(model)],
            "rating_sensitivity": ratings["sensitivity"],
        }
        for way in ratings["reached"]:
            for name, rows in _event("reached", way).items():
                found.setdefault(name, []).extend({"analysis": way["analysis"], **r} for r in rows)
        if ratings["symptom_model"]:
            found["symptom_model"] = person_rows(ratings["symptom_model"])
            found["symptom_model_ratios"] = ratings["symptom_model"]["ratios"]
    if leaving is not None:
        found |= _event("leaving", leaving)
    return found


def _model(model: Row) -> list[Row]:
    if model["not_fitted"]:
        return [{"summary": model["summary"], "not_fitted": model["not_fitted"]}]
    keys = ("summary", "reference", "n_participants", "n_values", "participant_sd", "residual_sd")
    same = {key: model[key] for key in keys}
    terms = {"(intercept)": model["intercept"], **model["terms"]}
    rows = [{**same, "term": name, **effect} for name, effect in terms.items()]
    return rows + [{**same, "term": name, **test} for name, test in model["omnibus"].items()]


def _event(name: str, found: Row) -> dict[str, list[Row]]:
    curves = [
        {"condition": curve["condition"], "robust": curve["robust"], "n": curve["n"], **row}
        for curve in found["curves"]
        for row in curve["at"]
    ]
    tests = [
        {key: " ".join(map(str, value)) if isinstance(value, list) else value
         for key, value in test.items()}
        for test in found["log_rank"]
    ]  # fmt: skip
    cox = found["cox"]
    ratios = [] if cox["not_fitted"] else [{"term": t, **e} for t, e in cox["effects"].items()]
    tables = {
        f"{name}_curves": curves,
        f"{name}_log_rank": tests,
        f"{name}_hazards": ratios,
        f"{name}_by_position": found["by_position"],
    }
    return {title: rows for title, rows in tables.items() if rows}


Results = dict[str, Any]
Paragraph = tuple[str, str, tuple[str, ...]]
"""Title, text, and the keys of what it cites."""


def course_paragraphs(results: Results) -> list[Paragraph]:
    """Return the paragraphs on what was made of courses in this report."""
    ratings = results["ratings"]
    rated = ratings is not None and bool(ratings["curves"])
    events = [*(ratings["reached"][:1] if rated else []), results["leaving"]]
    made = [event for event in events if event]
    return [
        *([_courses(ratings, several=len(ratings["conditions"]) > 1)] if rated else []),
        *([_survival(made)] if made else []),
        *([_symptom_model(ratings["symptom_model"])] if rated and ratings["symptom_model"] else []),
    ]


def _courses(ratings: Results, *, several: bool) -> Paragraph:
    text = (
        "Each course of ratings is summed up by one number (Matthews et al., 1990), which a mixed "
        "model with a random intercept for each participant takes as its outcome. Times are live "
        "ones, where they were recorded. "
    )
    cited = ["matthews_1990"]
    if several:
        text += (
            "At each time, the means of conditions are those of such a model of the last ratings "
            "then, and their intervals compare conditions within people: the variance of a mean’s "
            "distance from the mean of all k conditions times k/(k − 1), which is Cousineau’s "
            "(2005) with Morey’s (2008) correction and, where nothing is missing, the interval of "
            "Loftus and Masson (1994). "
        )
        cited += ["cousineau_2005", "morey_2008", "loftus_1994"]
    if ratings["sensitivity"]:
        text += (
            "Models are repeated of completed exposures alone, and with the last rating, or the "
            "highest answer, standing from leaving until the planned end."
        )
    return "Ratings during exposure", text.strip(), tuple(cited)


def _survival(made: list[Results]) -> Paragraph:
    again = any(event["repeated"] for event in made)
    text = (
        "Times to events are Kaplan–Meier estimates (1958) with Greenwood’s error and intervals "
        "of the logarithm of survival; groups are compared by log-rank tests (Mantel, 1966) and "
        "by Cox’s (1972) proportional hazards with Efron’s (1977) treatment of ties, of condition "
        "and order."
    )
    cited = ["kaplan_1958", "mantel_1966", "cox_1972", "efron_1977"]
    if again:
        text += (
            " As people come more than once, log-rank tests are made within people as well (each "
            "one a stratum), and errors of hazard ratios and of curves are robust: scores and "
            "influences are summed within people (Lin & Wei, 1989)."
        )
        cited.append("lin_1989")
    return "Time to events", text, tuple(cited)


def _symptom_model(found: Results) -> Paragraph:
    constants = found["constants"]
    text = (
        f"Oman’s (1990) model has a fast ({constants['fast_s']:g} s) and a slow "
        f"({constants['slow_s']:g} s) path of second order, the slow one making the fast one more "
        f"sensitive, and a power law of exponent {constants['exponent']:g} (Irmak et al., 2022). "
        "It was fitted to each person by least squares, with a level for each condition and one "
        "sensitisation; its errors allow for residuals that correlate in time. Each exposure is "
        "taken to begin without symptoms and to be as strong from its start to its end."
    )
    return "Model of symptoms", text, ("oman_1990", "irmak_2022")
