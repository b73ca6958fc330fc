"""Ratings over time and times to events as flat tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.courses.summaries import long_table
from vrcomfort.report.courses.symptom_fits import person_rows

if TYPE_CHECKING:
    from vrcomfort.report.courses.results import Courses

Row = dict[str, Any]


def course_tables(results: Row, courses: Courses) -> dict[str, list[Row]]:
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
