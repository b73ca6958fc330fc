"""The analysis of ratings during exposure and of time to withdrawal."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import MethodsParagraph
from vrcomfort.report.possible import Possible
from vrcomfort.report.rated_exposures import (
    ALL,
    COMPLETERS,
    UNKNOWN,
    WORST,
    LiveClock,
    RatedExposure,
    rated_exposures,
    rated_instrument,
)
from vrcomfort.report.ratings.survival import (
    SurvivalAnalysis,
    survival_analysis,
    survival_paragraph,
    survival_tables,
    times_to_threshold,
    times_to_withdrawal,
)
from vrcomfort.report.ratings.symptom_model import (
    SymptomModelAnalysis,
    symptom_model,
    symptom_model_paragraph,
    symptom_model_tables,
)
from vrcomfort.report.ratings.time_courses import (
    CurvePoint,
    DropoutSensitivity,
    SummaryModel,
    SummaryStatistics,
    condition_curves,
    curve_points,
    describe,
    exposure_lines,
    models,
    planned_s,
    possible_summaries,
    sensitivity,
    time_course_paragraph,
)
from vrcomfort.report.rows import INLINE, Cells, as_json, rounded

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vrcomfort.report.analyses.contract import SectionData
    from vrcomfort.report.ratings.settings import RatingAnalysis
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.stats.means import MeanCurves


@dataclass(frozen=True)
class RatingCounts:
    """Numbers of rated exposures, of ratings, and of seconds that do not count."""

    exposures: int
    people: int
    asked: int
    missed: int
    without_answer: int
    left_early: int
    endings_recorded: bool
    not_live_s: float
    freezes: int
    unplaced: int
    planned_s: float


@dataclass(frozen=True)
class Threshold:
    """The rating that is an event, and where it is from.

    Parameters
    ----------
    threshold_in_a_row
        Successive ratings that have to be so high.
    """

    threshold: float
    threshold_in_a_row: int
    threshold_from: Literal["plan", "stop rule", "middle of the scale"]


@dataclass(frozen=True)
class ThresholdAnalysis:
    """The time to the threshold of some exposures, `analysis` by name."""

    analysis: str
    found: SurvivalAnalysis = field(metadata=INLINE)


@dataclass(frozen=True)
class RatingTimeCourses:
    """The analysis of ratings; key `ratings` of results.json."""

    instrument: str
    short: str
    low: float
    high: float
    conditions: list[str]
    counts: RatingCounts = field(metadata=INLINE)
    summaries: list[SummaryStatistics]
    models: list[SummaryModel]
    sensitivity: list[DropoutSensitivity]
    threshold_rule: Threshold = field(metadata=INLINE)
    reached: list[ThresholdAnalysis]
    symptom_model: SymptomModelAnalysis | None
    curves: list[CurvePoint]

    @property
    def threshold(self) -> float:
        """Return the rating that is the event of the time to it."""
        return self.threshold_rule.threshold


@dataclass(frozen=True)
class TimeCourseAnalysis:
    """Ratings during exposure and times to events, with the exposures and curves behind them.

    Parameters
    ----------
    conditions
        Those with a rating or an exposure, in the order of the report.
    scale
        The ratings that there can be.
    carried
        Curves with last observations carried forward (LOCF); None without withdrawals.
    ratings, leaving
        None where the data do not hold it.
    """

    exposures: list[RatedExposure]
    conditions: list[str]
    scale: Possible
    confidence: float
    curves: MeanCurves | None
    carried: MeanCurves | None
    ratings: RatingTimeCourses | None
    leaving: SurvivalAnalysis | None

    @property
    def results(self) -> dict[str, RatingTimeCourses | SurvivalAnalysis | None]:
        """Return the part of results.json."""
        return {"ratings": self.ratings, "leaving": self.leaving}


def analyse_time_courses(data: SectionData, asked: RatingAnalysis) -> TimeCourseAnalysis:
    """Analyse ratings during exposure, and time to withdrawal.

    Raises
    ------
    InputError
        If the plan names an instrument that was not rated, or ratings are damaged.
    """
    study, plan = data.study, data.plan
    instrument = rated_instrument(study, asked.instrument)
    exposures = rated_exposures(study, instrument, without=_left_out(data), clock=LiveClock(study))
    conditions = _conditions(exposures, list(data.labels))
    exposures = [e for e in exposures if e.condition in conditions]
    answered = [e for e in exposures if e.course.answered.ratings.size]
    scale, curves, carried = scale_of(study, instrument), None, None
    if answered:
        curves = condition_curves(answered, conditions, plan.confidence)
        if any(e.left for e in answered):
            carried = condition_curves(answered, conditions, plan.confidence, carried=True)
    ratings = None
    if any(e.course.times_s.size for e in exposures):
        points = curve_points(curves, carried, conditions, scale)
        ratings = _ratings(data, asked, exposures, conditions, instrument, points)
    leaving = _leaving(data, exposures, conditions)
    return TimeCourseAnalysis(
        exposures, conditions, scale, plan.confidence, curves, carried, ratings, leaving
    )


def _left_out(data: SectionData) -> set[str]:
    """Return the participants excluded by the experimenter or by a rule of the plan."""
    people = {p["participant"] for p in data.study.participants if p["status"] == "excluded"}
    return people | {row.participant for row in data.exclusions if row.is_person}


def _conditions(exposures: list[RatedExposure], labels: list[str]) -> list[str]:
    there = {e.condition for e in exposures} - {""} or {""}
    order = {name: place for place, name in enumerate(labels)}
    return sorted(there, key=lambda name: (order.get(name, len(order)), natural(name)))


def reference_of(data: SectionData, conditions: list[str]) -> str:
    """Return the reference condition: b of the only pair, or the first."""
    if len(data.pairs) == 1 and data.pairs[0][1] in conditions:
        return data.pairs[0][1]
    return conditions[0]


def _times(asked: tuple[float, ...], longest: float) -> list[float]:
    quarters = [longest * part / 4 for part in (1, 2, 3, 4)]
    return sorted(asked) or [float(f"{time:.6g}") for time in quarters if time > 0]


def _ratings(
    data: SectionData,
    asked: RatingAnalysis,
    exposures: list[RatedExposure],
    conditions: list[str],
    instrument: str,
    points: list[CurvePoint],
) -> RatingTimeCourses:
    plan = data.plan
    known = data.study.instruments.get(instrument)
    rated = [e for e in exposures if e.course.times_s.size]
    answered = [e for e in rated if e.course.answered.ratings.size]
    low, high = (known.low, known.high) if known else (0.0, _highest(rated))
    threshold = _threshold(data, asked, instrument, (low + high) / 2)
    reference = reference_of(data, conditions)
    ranges = possible_summaries(answered, scale_of(data.study, instrument))
    modelled = asked.symptom_model == "fast_slow"
    return RatingTimeCourses(
        instrument=instrument,
        short=known.short if known else instrument or "rating",
        low=low,
        high=high,
        conditions=conditions,
        counts=_counts(rated),
        summaries=[row for s in asked.summaries for row in describe(answered, s, conditions)],
        models=models(answered, asked.summaries, reference, plan, ranges),
        sensitivity=sensitivity(
            [e for e in exposures if e.course.answered.ratings.size or e.left],
            asked.summaries,
            reference,
            float(high),
            plan,
            ranges,
        ),
        threshold_rule=threshold,
        reached=_reached(data, answered, conditions, threshold, asked.times_s),
        symptom_model=symptom_model(answered, conditions, asked, plan.confidence)
        if modelled
        else None,
        curves=points,
    )


def scale_of(study: StudyData, instrument: str) -> Possible:
    """Return the range of an instrument's ratings; that of an unknown one is not known."""
    known = study.instruments.get(instrument)
    return Possible(float(known.low), float(known.high)) if known else Possible()


def _threshold(
    data: SectionData, asked: RatingAnalysis, instrument: str, middle: float
) -> Threshold:
    """Return the plan's threshold; else that of the protocol's stop rule; else the middle."""
    if asked.threshold is not None:
        return Threshold(asked.threshold, 1, "plan")
    rule = data.study.stop_rule(instrument)
    if rule is not None and rule.stop_at is not None:
        return Threshold(rule.stop_at, rule.stop_in_a_row, "stop rule")
    return Threshold(middle, 1, "middle of the scale")


def _highest(rated: list[RatedExposure]) -> float:
    return max((e.course.peak() or 0.0 for e in rated), default=0.0)


def _counts(rated: list[RatedExposure]) -> RatingCounts:
    return RatingCounts(
        exposures=len(rated),
        people=len({e.participant for e in rated}),
        asked=sum(e.course.ratings.size for e in rated),
        missed=sum(int(np.isnan(e.course.ratings).sum()) for e in rated),
        without_answer=sum(not e.course.answered.ratings.size for e in rated),
        left_early=sum(e.left for e in rated),
        endings_recorded=any(e.ending != UNKNOWN for e in rated),
        not_live_s=sum(e.not_live_s for e in rated),
        freezes=sum(len(e.freezes) for e in rated),
        unplaced=sum(e.unplaced for e in rated),
        planned_s=planned_s(rated),
    )


def _reached(
    data: SectionData,
    answered: list[RatedExposure],
    conditions: list[str],
    threshold: Threshold,
    times_s: tuple[float, ...],
) -> list[ThresholdAnalysis]:
    """Return the time to the threshold: of all, and, with withdrawals, under assumptions."""
    if not answered:
        return []
    plan = data.plan
    times = _times(times_s, max(e.ended_s for e in answered))
    ways = [ALL]
    if any(e.left for e in answered):
        ways += [COMPLETERS, WORST]
    found = []
    for how in ways:
        events = times_to_threshold(
            answered, threshold.threshold, threshold.threshold_in_a_row, how=how
        )
        if events:
            reference, pairs = reference_of(data, conditions), list(data.pairs)
            made = survival_analysis(events, conditions, pairs, times, reference, plan.confidence)
            found.append(ThresholdAnalysis(how, made))
    return found


def _leaving(
    data: SectionData, exposures: list[RatedExposure], conditions: list[str]
) -> SurvivalAnalysis | None:
    """Return the time to withdrawal; None without recorded trials or without withdrawals."""
    events = times_to_withdrawal(exposures)
    if not any(e.came for e in events):
        return None
    times = _times((), max(e.time_s for e in events))
    reference, pairs = reference_of(data, conditions), list(data.pairs)
    return survival_analysis(events, conditions, pairs, times, reference, data.plan.confidence)


def course_tables(courses: TimeCourseAnalysis) -> dict[str, list[Cells]]:
    """Return name → lines of the CSV tables of ratings and of times to events."""
    ratings, leaving = rounded(courses.ratings), rounded(courses.leaving)
    found: dict[str, list[Cells]] = {}
    if ratings is not None:
        found |= {
            "rated_exposures": exposure_lines(
                e for e in courses.exposures if e.course.times_s.size
            ),
            "rating_curves": as_json(ratings.curves),
            "rating_summaries": as_json(ratings.summaries),
            "rating_models": [line for model in ratings.models for line in _model_lines(model)],
            "rating_sensitivity": as_json(ratings.sensitivity),
        }
        for way in ratings.reached:
            for name, lines in survival_tables("reached", way.found).items():
                found.setdefault(name, []).extend({"analysis": way.analysis, **x} for x in lines)
        if ratings.symptom_model:
            found |= symptom_model_tables(ratings.symptom_model)
    if leaving is not None:
        found |= survival_tables("leaving", leaving)
    return found


def _model_lines(model: SummaryModel) -> list[Cells]:
    found = model.found
    if found is None:
        return [{"summary": model.summary, "not_fitted": model.not_fitted}]
    same: Cells = {
        "summary": model.summary,
        "reference": found.reference,
        "n_participants": found.n_participants,
        "n_values": found.n_values,
        "participant_sd": found.participant_sd,
        "residual_sd": found.residual_sd,
    }
    terms = {"(intercept)": found.intercept, **found.terms, **found.omnibus}
    return [{**same, "term": name, **as_json(effect)} for name, effect in terms.items()]


def course_paragraphs(courses: TimeCourseAnalysis) -> Iterator[MethodsParagraph]:
    """Yield the paragraphs of the methods section."""
    ratings, leaving = courses.ratings, courses.leaving
    rated = ratings if ratings is not None and ratings.curves else None
    if rated:
        several = len(rated.conditions) > 1
        errors = next((each.found.errors for each in rated.models if each.found), None)
        yield time_course_paragraph(
            several=several,
            again=rated.counts.exposures > rated.counts.people,
            assumptions=bool(rated.sensitivity),
            errors=errors or "cluster_robust",
        )
    reached = [way.found for way in rated.reached[:1]] if rated else []
    made = [*reached, *([leaving] if leaving else [])]
    if made:
        yield survival_paragraph(again=any(each.repeated for each in made))
    if rated and rated.symptom_model:
        yield symptom_model_paragraph(rated.symptom_model.constants)
