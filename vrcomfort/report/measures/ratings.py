"""Measures of the ratings during exposure: one number for each exposure."""

from __future__ import annotations

import math
from collections import defaultdict
from fractions import Fraction
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from vrcomfort.errors import InputError
from vrcomfort.report.measures.model import Measure, Quantity, Value, exactly, number_of
from vrcomfort.stats.rating_courses import RatingCourse

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from vrcomfort.report.study_data import StudyData

    Exposure = tuple[str, str, str]

_ANSWERED = "of the ratings that were answered"
QUANTITIES = {
    "peak": Quantity("Peak rating", "", "", f"the highest {_ANSWERED}"),
    "mean": Quantity("Mean rating", "", "", f"the mean {_ANSWERED}"),
    "last": Quantity(
        "Last rating", "", "",
        "the last rating that was answered, carried forward where the exposure ended early",
    ),
    "area": Quantity(
        "Area under the ratings", "rating × s", "",
        "the area under the answered ratings by trapezia, from the first to the last of them",
    ),
    "slope": Quantity(
        "Slope of the ratings", "rating per min", "",
        "the least-squares slope of the answered ratings over time",
    ),
    "time_to": Quantity(
        "Time to threshold", "s", "higher",
        "the time from the start of the exposure to the first rating at or above the threshold; "
        "those who finished below it are tied at the longest exposure of the study, those who left "
        "below it have no value",
    ),
}  # fmt: skip
"""What is measured; ratings that were missed, because nobody answered or the picture stood still,
count in none of them."""


class Ratings:
    """``ratings.csv``."""

    quantities: ClassVar[dict[str, Quantity]] = QUANTITIES
    of_whole_exposures: ClassVar[bool] = False

    def values(self, study: StudyData, measure: Measure) -> Iterator[Value]:
        """Yield the value of each exposure that was rated, or was to be."""
        courses = courses_of(study, measure.instrument)
        trials = {(t["participant"], t["session"], t["trial"]): t for t in study.trials}
        longest = _longest_s(trials, courses)
        for key in dict.fromkeys([*trials, *courses]):
            trial, course = trials.get(key, {}), courses.get(key)
            condition = course.condition if course else trial.get("condition", "")
            if course is None or course.ratings.peak() is None:
                reason = "no rating was answered" if course else "nothing was rated"
                yield Value(*key, condition, None, reason)
                continue
            if measure.quantity == "time_to":
                finished = trial.get("status", "completed") == "completed"
                otherwise = longest if finished else None
                found = _time_to(course.ratings, measure.threshold, otherwise)
                reason = "left below the threshold"
            else:
                summary = _SUMMARIES[measure.quantity](course.ratings)
                found = None if summary is None else exactly(summary)
                reason = "only one rating was answered"
            yield Value(*key, condition, found, "" if found is not None else reason)


class Course(NamedTuple):
    """The ratings of one exposure, from its start on, and its condition."""

    condition: str
    ratings: RatingCourse


def courses_of(study: StudyData, instrument: str = "") -> dict[Exposure, Course]:
    """Return the ratings of each exposure that was asked for any.

    Of an exposure that was begun again, those of the last attempt count.

    Parameters
    ----------
    instrument
        The one meant; blank: the only one.

    Raises
    ------
    InputError
        If nothing was rated, or ratings are of several instruments and none is named.
    """
    asked = sorted({row.get("instrument", "") for row in study.ratings})
    if not asked:
        raise InputError("the study has no ratings (ratings.csv)")
    if not instrument and len(asked) > 1:
        raise InputError(f"ratings are of {', '.join(asked)}; name the instrument that is meant")
    if instrument and instrument not in asked:
        raise InputError(f"nothing was rated with {instrument}; ratings are of {', '.join(asked)}")
    trials = {(t["participant"], t["session"], t["trial"]): t for t in study.trials}
    due: dict[Exposure, list[tuple[float, float]]] = defaultdict(list)
    conditions: dict[Exposure, str] = {}
    for row in study.ratings:
        if instrument and row.get("instrument", "") != instrument:
            continue
        key = row.get("participant", ""), row.get("session", ""), row.get("trial", "")
        trial = trials.get(key, {})
        at_s, rating = _at_s(row, trial), _number(row.get("response", ""), row)
        if at_s is None:
            continue
        conditions.setdefault(key, row.get("condition", "") or trial.get("condition", ""))
        missed = rating is None or row.get("missed", "") not in {"", "0"}
        due[key].append((at_s, math.nan if rating is None or missed else rating))
    return {
        key: Course(conditions[key], RatingCourse.of(*zip(*each, strict=True)))
        for key, each in due.items()
    }


def _at_s(row: dict[str, str], trial: dict[str, str]) -> float | None:
    """Return when a rating fell due, from the start of the exposure; None of an earlier attempt."""
    onset = _number(row.get("onset_s", ""), row) or 0.0
    start, end = (_number(trial.get(name, ""), trial) for name in ("start_s", "end_s"))
    if start is None or end is None:
        return onset
    return onset - start if start - 1e-6 <= onset <= end + 1e-6 else None


def _number(text: str, row: dict[str, str]) -> float | None:
    try:
        found = number_of(text)
    except ValueError:
        who = row.get("participant", "")
        message = f"a rating of {who} has `{text}` where a number is needed"
        raise InputError(message) from None
    return None if found is None else float(found)


def _longest_s(trials: dict[Exposure, dict[str, str]], courses: dict[Exposure, Course]) -> float:
    lengths = [float(course.ratings.times_s[-1]) for course in courses.values()]
    for trial in trials.values():
        start, end = (_number(trial.get(name, ""), trial) for name in ("start_s", "end_s"))
        lengths += [] if start is None or end is None else [end - start]
    return max(lengths, default=0.0)


def _time_to(
    course: RatingCourse, threshold: float | None, otherwise: float | None
) -> Fraction | None:
    found = course.time_to(math.inf if threshold is None else threshold)
    if found and found.reached:
        return exactly(found.time_s)
    return None if otherwise is None else exactly(otherwise)


def _mean(course: RatingCourse) -> Fraction | None:
    """Return the mean of ratings as they were given, without rounding."""
    given = course.answered.ratings.tolist()
    return sum(map(Fraction, given), Fraction(0)) / len(given) if given else None


def _area(course: RatingCourse) -> float | None:
    return course.area() if course.answered.ratings.size > 1 else None


_SUMMARIES: dict[str, Callable[[RatingCourse], float | Fraction | None]] = {
    "peak": RatingCourse.peak,
    "mean": _mean,
    "last": RatingCourse.last,
    "area": _area,
    "slope": RatingCourse.slope_per_min,
}
