"""Rating time courses: summaries, their models, sensitivity to dropout, and mean curves."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.stats.means import MeanCurves, mean_curves
from vrcomfort.stats.mixed import mixed_model

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from vrcomfort.report.courses.exposures import RatedExposure
    from vrcomfort.report.plan.ratings import Course
    from vrcomfort.stats.rating_courses import RatingCourse

    Floats = NDArray[np.float64]

Row = dict[str, Any]

SUMMARIES: dict[str, Callable[[RatingCourse], float | None]] = {
    "peak": lambda course: course.peak(),
    "mean": lambda course: course.mean(),
    "last": lambda course: course.last(),
    "area": lambda course: None if (area := course.area()) is None else area / 60,
    "slope": lambda course: course.slope_per_min(),
}
TITLES = {
    "peak": "highest rating",
    "mean": "mean rating",
    "last": "last rating",
    "area": "area under the ratings (points × min)",
    "slope": "slope (points per min)",
}
ALL, COMPLETERS, CARRIED, WORST = "all available", "completers", "carried forward", "worst case"
MEANINGS = {
    COMPLETERS: "exposures that were completed alone",
    ALL: "every exposure, with the ratings until it ended",
    CARRIED: "the last rating stands until the planned end",
    WORST: "the highest answer stands from leaving until the planned end",
}


def summary_table(
    exposures: Iterable[RatedExposure], summary: Course, of: Callable[[RatedExposure], float | None]
) -> pd.DataFrame:
    """Return a row for each exposure that has the summary: participant, condition, value."""
    rows = [(e.participant, e.condition, of(e)) for e in exposures]
    columns = ["participant", "condition", summary]
    return pd.DataFrame(rows, columns=columns).dropna(subset=[summary])


def describe(exposures: list[RatedExposure], summary: Course, conditions: list[str]) -> list[Row]:
    """Describe a summary under each condition, and, last, under all together."""
    table = summary_table(exposures, summary, lambda e: SUMMARIES[summary](e.course))
    rows = []
    for condition in [*conditions, None]:
        mine = table if condition is None else table[table["condition"] == condition]
        values = mine[summary].astype(float)
        many = len(values) > 1
        rows.append(
            {
                "summary": summary,
                "condition": condition,
                "n": len(values),
                "people": int(mine["participant"].nunique()),
                "mean": float(values.mean()) if len(values) else None,
                "sd": float(values.std(ddof=1)) if many else None,
                "median": float(values.median()) if len(values) else None,
            }
        )
    return rows if len(conditions) > 1 else rows[:-1]


def model_of(table: pd.DataFrame, summary: Course, reference: str, confidence: float) -> Row:
    """Fit ``summary ~ condition + (1 | participant)``, or say why there is no model."""
    try:
        model = mixed_model(
            table,
            value=summary,
            participant="participant",
            factors=["condition"],
            references={"condition": reference},
            confidence=confidence,
        )
    except InputError as error:
        return {"summary": summary, "not_fitted": error.message}
    squares = {
        name: {"mean_square": test.f * model.residual_sd**2,
               "sum_of_squares": test.f * test.df_effect * model.residual_sd**2}
        for name, test in model.omnibus.items()
    }  # fmt: skip
    found = asdict(model)
    for name, more in squares.items():
        found["omnibus"][name] |= more
    return {"summary": summary, "not_fitted": None, "reference": reference, **found}


def models(
    exposures: list[RatedExposure], summaries: Iterable[Course], reference: str, confidence: float
) -> list[Row]:
    """Return the model of each summary, of all available data."""

    def table(name: Course) -> pd.DataFrame:
        return summary_table(exposures, name, lambda e: SUMMARIES[name](e.course))

    return [model_of(table(name), name, reference, confidence) for name in summaries]


def sensitivity(
    exposures: list[RatedExposure],
    summaries: Iterable[Course],
    reference: str,
    highest: float,
    confidence: float,
) -> list[Row]:
    """Return the effects of each model under other assumptions of those who left early.

    Only peak, mean and last ratings have a value for the time after somebody left.
    """
    if not any(e.left for e in exposures):
        return []
    planned = planned_s(exposures)
    rows = []
    for name in summaries:
        for how, of in _assumptions(name, planned, highest).items():
            kept = [e for e in exposures if how != COMPLETERS or e.ending == "completed"]
            found = model_of(summary_table(kept, name, of), name, reference, confidence)
            base = {"summary": name, "analysis": how}
            if found["not_fitted"]:
                rows.append({**base, "not_fitted": found["not_fitted"]})
                continue
            rows += [
                {**base, "n": found["n_values"], "term": term, **effect, "not_fitted": None}
                for term, effect in found["terms"].items()
            ]
    return rows


def planned_s(exposures: Iterable[RatedExposure]) -> float:
    """Return how long an exposure was to be: the longest that was completed, or that there is."""
    there = list(exposures)
    done = [e.ended_s for e in there if e.ending == "completed"]
    return max(done or [e.ended_s for e in there], default=0.0)


def _assumptions(
    name: Course, planned: float, highest: float
) -> dict[str, Callable[[RatedExposure], float | None]]:
    plain = SUMMARIES[name]
    found: dict[str, Callable[[RatedExposure], float | None]] = {
        COMPLETERS: lambda e: plain(e.course),
        ALL: lambda e: plain(e.course),
    }
    if name == "mean":
        found[CARRIED] = lambda e: _filled(e, planned, e.course.last())
        found[WORST] = lambda e: _filled(e, planned, highest)
    elif name in {"peak", "last"}:
        found[WORST] = lambda e: highest if e.left else plain(e.course)
    return found


def _filled(exposure: RatedExposure, planned: float, value: float | None) -> float | None:
    """Return the mean rating with a value from leaving on, each second counting the same."""
    mean = exposure.course.mean()
    if not exposure.left or planned <= 0 or value is None:
        return mean
    share = min(exposure.ended_s / planned, 1.0)
    if mean is None:
        return value
    return mean * share + value * (1 - share)


def long_table(exposures: Iterable[RatedExposure]) -> list[Row]:
    """Return a row for each exposure: how it ended, and its summaries."""
    rows = []
    for e in exposures:
        answered = int(e.course.answered.ratings.size)
        rows.append(
            {
                "participant": e.participant,
                "session": e.session,
                "trial": e.trial,
                "condition": e.condition,
                "position": e.position,
                "ending": e.ending,
                "ended_s": round(e.ended_s, 9),
                "not_live_s": round(e.not_live_s, 9),
                "answered": answered,
                "missed": int(np.isnan(e.course.ratings).sum()),
                **{name: of(e.course) for name, of in SUMMARIES.items()},
            }
        )
    return rows


MOST_TIMES = 48
"""At which a mean is fitted: more than a figure can show apart."""


def grid_s(exposures: list[RatedExposure]) -> Floats:
    """Return the times of the means: those of ratings where they are few and alike, else even.

    Even ones end where a tenth of the exposures that nobody left had ended: means of the few that
    went on for longer would jump.
    """
    answered = [e.course.answered.times_s for e in exposures]
    together = np.concatenate(answered) if answered else np.array([])
    if not together.size:
        return together
    rounded = np.unique(np.round(together))
    if rounded.size <= MOST_TIMES:
        late = [together[np.round(together) == moment].max() for moment in rounded]
        return np.asarray(late, dtype=np.float64)
    first = max(float(np.median([each[0] for each in answered if each.size])), 0.0)
    ends = [e.course.times_s[-1] for e in exposures if not e.left] or [float(together.max())]
    last = float(np.quantile(ends, 0.1))
    return np.linspace(first, max(last, first), MOST_TIMES)


def at_times(exposures: list[RatedExposure], times_s: Floats, *, carried: bool) -> Floats:
    """Return each exposure's last rating at each time, shape (exposures, times).

    Parameters
    ----------
    carried
        Of those who left, the last rating stands until the planned end; without it, nothing is
        there after an exposure ended.
    """
    end = planned_s(exposures)
    rows = [
        e.course.carried_forward(times_s, until_s=end if carried and e.left else _until_s(e))
        for e in exposures
    ]
    return np.array(rows, dtype=np.float64).reshape(len(exposures), times_s.size)


def _until_s(exposure: RatedExposure) -> float:
    """Return until when a rating stands: the end of the exposure, and its last rating at least."""
    times = exposure.course.times_s
    return max(exposure.ended_s, float(times[-1]) if times.size else 0.0)


def condition_curves(
    exposures: list[RatedExposure],
    conditions: list[str],
    confidence: float,
    *,
    carried: bool = False,
) -> MeanCurves:
    """Return the mean of each condition over time, of the exposures that have a rating."""
    rated = [e for e in exposures if e.course.answered.ratings.size and e.condition in conditions]
    times = grid_s(rated)
    return mean_curves(
        times,
        at_times(rated, times, carried=carried),
        [conditions.index(e.condition) for e in rated],
        [e.participant for e in rated],
        count=len(conditions),
        confidence=confidence,
    )
