"""Rating time courses: summaries, their models, sensitivity to dropout, and mean curves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.report.analyses.contract import MethodsParagraph
from vrcomfort.report.analyses.mixed import CITED, ERRORS, within_possible
from vrcomfort.report.possible import Possible
from vrcomfort.report.rated_exposures import ALL, CARRIED, COMPLETERS, WORST, possible_area
from vrcomfort.report.rows import INLINE, Cells
from vrcomfort.stats.means import MeanCurves, mean_curves
from vrcomfort.stats.mixed import Errors, Estimate, MixedModel, Pairwise, mixed_model
from vrcomfort.stats.random_intercept import FTest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import NDArray

    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rated_exposures import RatedExposure
    from vrcomfort.report.ratings.settings import Course
    from vrcomfort.stats.rating_courses import RatingCourse

    Floats = NDArray[np.float64]

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
MEANINGS = {
    COMPLETERS: "exposures that were completed alone",
    ALL: "every exposure, with the ratings until it ended",
    CARRIED: "the last rating stands until the planned end",
    WORST: "the highest answer stands from leaving until the planned end",
}


@dataclass(frozen=True)
class SummaryStatistics:
    """A summary of ratings under one condition, or under all together (None)."""

    summary: str
    condition: str | None
    n: int
    people: int
    mean: float | None
    sd: float | None
    median: float | None


@dataclass(frozen=True)
class OmnibusTest:
    """The test of a factor, with the squares that lme4 prints beside it where errors are its."""

    test: FTest = field(metadata=INLINE)
    mean_square: float | None
    sum_of_squares: float | None

    @classmethod
    def of(cls, test: FTest, square: float | None) -> OmnibusTest:
        """Return a test with its squares; `square` is the variance of the residuals, or None."""
        if square is None or test.f is None:
            return cls(test, None, None)
        return cls(test, test.f * square, test.f * test.df_effect * square)


@dataclass(frozen=True)
class SummaryEstimates:
    """The estimates of a mixed model; its fields are those of `MixedModel`."""

    reference: str
    n_participants: int
    n_values: int
    errors: Errors
    intercept: Estimate
    terms: dict[str, Estimate]
    omnibus: dict[str, OmnibusTest]
    participant_sd: float | None
    residual_sd: float
    means: dict[str, dict[str, Estimate]]
    pairwise: dict[str, dict[str, Pairwise]]

    @classmethod
    def of(cls, model: MixedModel, reference: str, square: float | None) -> SummaryEstimates:
        """Return the estimates of a fitted model; `square` as in `OmnibusTest.of`."""
        tests = {name: OmnibusTest.of(test, square) for name, test in model.omnibus.items()}
        return cls(reference, **{**vars(model), "omnibus": tests})


@dataclass(frozen=True)
class SummaryModel:
    """The mixed model of a summary, or the reason for its absence."""

    summary: str
    not_fitted: str | None
    found: SummaryEstimates | None = field(default=None, metadata=INLINE)


@dataclass(frozen=True)
class AssumedEffect:
    """An effect of a model under an assumption."""

    n: int
    term: str
    estimate: Estimate = field(metadata=INLINE)


@dataclass(frozen=True)
class DropoutSensitivity:
    """An effect under an assumption about withdrawals, or the reason for its absence."""

    summary: str
    analysis: str
    effect: AssumedEffect | None = field(metadata=INLINE)
    not_fitted: str | None


@dataclass(frozen=True)
class CurvePoint:
    """The mean rating of a condition at one time, with its interval."""

    condition: str
    time_s: float
    n: int
    mean: float
    low: float | None
    high: float | None
    carried_forward: float | None


def summary_table(
    exposures: Iterable[RatedExposure], summary: Course, of: Callable[[RatedExposure], float | None]
) -> pd.DataFrame:
    """Return a row for each exposure that has the summary: participant, condition, value."""
    rows = [(e.participant, e.condition, of(e)) for e in exposures]
    columns = ["participant", "condition", summary]
    return pd.DataFrame(rows, columns=columns).dropna(subset=[summary])


def describe(
    exposures: list[RatedExposure], summary: Course, conditions: list[str]
) -> list[SummaryStatistics]:
    """Describe a summary under each condition, and, last, under all together."""
    table = summary_table(exposures, summary, lambda e: SUMMARIES[summary](e.course))
    rows = []
    for condition in [*conditions, None]:
        mine = table if condition is None else table[table["condition"] == condition]
        values = mine[summary].astype(float)
        rows.append(
            SummaryStatistics(
                summary=summary,
                condition=condition,
                n=len(values),
                people=int(mine["participant"].nunique()),
                mean=float(values.mean()) if len(values) else None,
                sd=float(values.std(ddof=1)) if len(values) > 1 else None,
                median=float(values.median()) if len(values) else None,
            )
        )
    return rows if len(conditions) > 1 else rows[:-1]


Ranges: TypeAlias = "Mapping[Course, Possible]"
"""Summary → the values that it can have."""


def possible_summaries(exposures: Iterable[RatedExposure], scale: Possible) -> Ranges:
    """Return the range of each summary of ratings on a scale."""
    area = Possible(*(None if end is None else end / 60 for end in possible_area(exposures, scale)))
    return {"peak": scale, "mean": scale, "last": scale, "area": area, "slope": Possible()}


def model_of(
    table: pd.DataFrame, summary: Course, reference: str, plan: Plan, ranges: Ranges
) -> SummaryModel:
    """Fit ``summary ~ condition + (1 | participant)``; or return the reason for no model.

    Of people with one exposure each, the model has no random intercept.
    """
    try:
        model = mixed_model(
            table,
            value=summary,
            participant="participant",
            factors=["condition"],
            references={"condition": reference},
            errors=plan.mixed_model_errors,
            confidence=plan.confidence,
            repeated=not table["participant"].is_unique,
        )
    except InputError as error:
        return SummaryModel(summary, error.message)
    model = within_possible(model, ranges[summary])
    square = model.residual_sd**2 if plan.mixed_model_errors == "model" else None
    return SummaryModel(summary, None, SummaryEstimates.of(model, reference, square))


def models(
    exposures: list[RatedExposure],
    summaries: Iterable[Course],
    reference: str,
    plan: Plan,
    ranges: Ranges,
) -> list[SummaryModel]:
    """Return the model of each summary, of all available data."""

    def table(name: Course) -> pd.DataFrame:
        return summary_table(exposures, name, lambda e: SUMMARIES[name](e.course))

    return [model_of(table(name), name, reference, plan, ranges) for name in summaries]


def sensitivity(
    exposures: list[RatedExposure],
    summaries: Iterable[Course],
    reference: str,
    highest: float,
    plan: Plan,
    ranges: Ranges,
) -> list[DropoutSensitivity]:
    """Return the effects of each model under other assumptions about withdrawals.

    Only peak, mean and last ratings have a value for the time after a withdrawal.
    """
    if not any(e.left for e in exposures):
        return []
    planned = planned_s(exposures)
    rows = []
    for name in summaries:
        for how, of in _assumptions(name, planned, highest).items():
            kept = [e for e in exposures if how != COMPLETERS or e.ending == "completed"]
            model = model_of(summary_table(kept, name, of), name, reference, plan, ranges)
            if model.found is None:
                rows.append(DropoutSensitivity(name, how, None, model.not_fitted))
                continue
            n = model.found.n_values
            rows += [
                DropoutSensitivity(name, how, AssumedEffect(n, term, estimate), None)
                for term, estimate in model.found.terms.items()
            ]
    return rows


def planned_s(exposures: Iterable[RatedExposure]) -> float:
    """Return the planned length of an exposure: that of the longest completed, or of any."""
    there = list(exposures)
    done = [e.ended_s for e in there if e.ending == "completed"]
    return max(done or [e.ended_s for e in there], default=0.0)


def _assumptions(
    name: Course, planned: float, highest: float
) -> dict[str, Callable[[RatedExposure], float | None]]:
    # Area and slope have no value for the time after a withdrawal.
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
    """Return the time-weighted mean of the ratings and of a value from withdrawal on."""
    mean = exposure.course.mean()
    if not exposure.left or planned <= 0 or value is None:
        return mean
    share = min(exposure.ended_s / planned, 1.0)
    if mean is None:
        return value
    return mean * share + value * (1 - share)


def exposure_lines(exposures: Iterable[RatedExposure]) -> list[Cells]:
    """Return the CSV line of each exposure: its ending, and its summaries."""
    return [
        {
            "participant": e.participant,
            "session": e.session,
            "trial": e.trial,
            "condition": e.condition,
            "position": e.position,
            "ending": e.ending,
            "ended_s": round(e.ended_s, 9),
            "not_live_s": round(e.not_live_s, 9),
            "answered": int(e.course.answered.ratings.size),
            "missed": int(np.isnan(e.course.ratings).sum()),
            **{name: of(e.course) for name, of in SUMMARIES.items()},
        }
        for e in exposures
    ]


MOST_TIMES = 48
"""Of means: more than a figure can show apart, and each one is a fit."""


def grid_s(exposures: list[RatedExposure]) -> Floats:
    """Return the times of the means: those of ratings where they are few and alike, else even.

    Even ones end when a tenth of the exposures without withdrawal have ended: means of the few
    longer ones would jump.
    """
    answered = [each for e in exposures if (each := e.course.answered.times_s).size]
    if not answered:
        return np.array([])
    rounded = np.unique(np.concatenate([np.unique(np.round(each)) for each in answered]))
    if rounded.size <= MOST_TIMES:
        # Prompts of one time come some frames apart: at the latest of them, all were answered.
        late = np.full(rounded.size, -np.inf)
        for each in answered:
            np.maximum.at(late, np.searchsorted(rounded, np.round(each)), each)
        return late
    first = max(float(np.median([each[0] for each in answered])), 0.0)
    longest = max(float(each[-1]) for each in answered)
    ends = [e.course.times_s[-1] for e in exposures if not e.left] or [longest]
    last = float(np.quantile(ends, 0.1))
    return np.linspace(first, max(last, first), MOST_TIMES)


def at_times(exposures: list[RatedExposure], times_s: Floats, *, carried: bool) -> Floats:
    """Return each exposure's last rating at each time, shape (exposures, times).

    Parameters
    ----------
    carried
        The last observation before a withdrawal is carried forward to the planned end (LOCF);
        otherwise there is nothing after the end of an exposure.
    """
    end = planned_s(exposures)
    rows = [
        e.course.carried_forward(times_s, until_s=end if carried and e.left else _until_s(e))
        for e in exposures
    ]
    return np.array(rows, dtype=np.float64).reshape(len(exposures), times_s.size)


def _until_s(exposure: RatedExposure) -> float:
    """Return the time until which a rating stands: the end of the exposure, or its last rating."""
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


def curve_points(
    curves: MeanCurves | None,
    carried: MeanCurves | None,
    conditions: list[str],
    scale: Possible,
) -> list[CurvePoint]:
    """Return the means of each condition at the times at which it has an exposure."""
    if curves is None:
        return []
    points = []
    for row, condition in enumerate(conditions):
        for place, time in enumerate(curves.times_s):
            if not curves.n[row, place]:
                continue
            mean, half = float(curves.mean[row, place]), float(curves.half[row, place])
            known = not np.isnan(half)
            points.append(
                CurvePoint(
                    condition=condition,
                    time_s=float(time),
                    n=int(curves.n[row, place]),
                    mean=mean,
                    low=scale.held(mean - half) if known else None,
                    high=scale.held(mean + half) if known else None,
                    carried_forward=None if carried is None else float(carried.mean[row, place]),
                )
            )
    return points


def time_course_paragraph(
    *, several: bool, again: bool, assumptions: bool, errors: Errors
) -> MethodsParagraph:
    """Return the paragraph on time courses.

    Parameters
    ----------
    several
        Whether there are several conditions.
    again
        Whether participants rated more than one exposure.
    """
    text = "The ratings of an exposure were reduced to summary measures (Matthews et al., 1990). "
    cited = ["matthews_1990"]
    if several or again:
        model = (
            "mixed model with a random intercept per participant"
            if again
            else "linear model of the conditions, as each participant has one exposure"
        )
        text += f"Each was analysed with a {model}. Standard errors are {ERRORS[errors]} "
        cited += CITED[errors]
    text += "Times count only while the stimulus was visible, where recorded. "
    if several and not again:
        text += "Means over time have t intervals, as each participant rated one exposure. "
    elif several:
        text += (
            "Means over time are those of such a model of the last ratings at each time. Their "
            "intervals are within-participant (Cousineau, 2005, with the correction of Morey, "
            "2008); without missing ratings they equal those of Loftus and Masson (1994). "
        )
        cited += ["cousineau_2005", "morey_2008", "loftus_1994"]
    if assumptions:
        text += (
            "Sensitivity analyses took completed exposures alone, or carried the last rating, or "
            "the highest possible one, from dropout to the planned end."
        )
    return MethodsParagraph("Ratings during exposure", text.strip(), tuple(cited))
