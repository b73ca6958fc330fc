"""Sources of measures: the values that each file of a study holds, and their quantities."""

from __future__ import annotations

import math
from collections import defaultdict
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.report.measures.model import (
    Measure,
    MeasuredValue,
    MeasureSettings,
    MeasureSource,
    Quantity,
    exactly,
    in_steps,
    number_of,
)
from vrcomfort.report.possible import Possible
from vrcomfort.report.rated_exposures import FINISHED, LiveClock, possible_area, rated_exposures
from vrcomfort.report.study_data import cut_short, length_s, seen_s
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.rating_courses import RatingCourse

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from vrcomfort.report.study_data import StudyData

    Exposure = tuple[str, str, str]

NOT_RECORDED = "not recorded"
_KEYS = ("participant", "session", "trial", "condition")


def _trials_of(study: StudyData) -> dict[Exposure, dict[str, str]]:
    """Return the trial of each exposure: participant, session, trial."""
    return {(t["participant"], t["session"], t["trial"]): t for t in study.trials}


TRIAL_QUANTITIES = {
    "frames": Quantity("Frames", "", "", "the frames that were drawn in an exposure"),
    "dropped": Quantity("Dropped frames", "", "lower", "the frames that were late"),
    "dropped_percent": Quantity("Dropped frames", "%", "lower", "the share of late frames"),
    "missed_refreshes": Quantity("Missed refreshes", "", "lower", "refreshes without a new frame"),
    "length_s": Quantity("Length of exposure", "s", "", "from the start of an exposure to its end"),
    "seen_s": Quantity("Seen time", "s", "", "the time in which the stimulus was seen"),
    "live_s": Quantity("Live time", "s", "", "the time in which new frames were seen"),
    "frozen_s": Quantity("Frozen time", "s", "lower", "the time for which a frame stood still"),
    "hidden_s": Quantity("Hidden time", "s", "", "the time in which no frame was seen"),
    "unfocused_s": Quantity("Time behind a menu", "s", "", "the time with a menu in front"),
    "off_s": Quantity("Headset off", "s", "lower", "the time in which nobody wore the headset"),
    "not_drawn_s": Quantity("Not drawn", "s", "", "the time without pictures"),
    "half_rate_s": Quantity("Half rate", "s", "lower", "the time of late frames"),
    "untracked_s": Quantity("Untracked", "s", "lower", "the time without a measured head pose"),
}


def trial_values(study: StudyData, measure: Measure) -> Iterator[MeasuredValue]:
    """Yield the value of each exposure: a column of trials.csv, or one of `TRIAL_QUANTITIES`."""
    derived = {"length_s", "seen_s", "dropped_percent"}
    if measure.quantity not in derived:
        _check_column(study.trials, measure.quantity, "trials.csv")
    for trial in study.trials:
        key = trial["participant"], trial["session"], trial["trial"], trial["condition"]
        found = _of_trial(trial, measure.quantity)
        yield MeasuredValue(*key, found, "" if found is not None else NOT_RECORDED)


def _of_trial(trial: dict[str, str], name: str) -> Fraction | None:
    if name == "length_s":
        length = length_s(trial)
        return None if length is None else exactly(length)
    if name == "seen_s":
        seen = seen_s(trial)
        return None if seen is None else exactly(seen)
    if name == "dropped_percent":
        frames, dropped = (_cell(trial, each, "trials.csv") for each in ("frames", "dropped"))
        return 100 * dropped / frames if frames and dropped is not None else None
    return _cell(trial, name, "trials.csv")


TASK_QUANTITIES = {
    "reaction_s": Quantity("Reaction time", "s", "lower", "the mean time until a target was met"),
    "error_deg": Quantity("Error", "°", "lower", "the mean angle between aim and target"),
    "targets_hit_percent": Quantity("Targets hit", "%", "higher", "the share of targets met"),
    "shots_hit_percent": Quantity("Shots that hit", "%", "higher", "the share of shots that hit"),
}
_SHARES = {"targets_hit_percent": "target", "shots_hit_percent": "shot"}
"""Measure → the kind of the rows whose `hit` it averages."""


def task_values(study: StudyData, measure: Measure) -> Iterator[MeasuredValue]:
    """Yield the value of each exposure, or of each person under each condition, of tasks.csv.

    Several rows of one exposure, such as shots, are averaged.
    """
    kind = _SHARES.get(measure.quantity)
    column, factor = ("hit", 100) if kind else (measure.quantity, 1)
    for each in (column, "kind") if kind else (column,):
        _check_column(study.tasks, each, "tasks.csv")
    found: dict[tuple[str, ...], list[Fraction]] = defaultdict(list)
    for row in study.tasks:
        key = tuple(row.get(name, "") for name in _KEYS)
        counts = kind is None or row.get("kind") == kind
        number = _cell(row, column, "tasks.csv") if counts else None
        found[key] += [] if number is None else [factor * number]
    trials = _trials_of(study)
    for (who, session, trial, condition), numbers in found.items():
        said = condition or trials.get((who, session, trial), {}).get("condition", "")
        mean = sum(numbers, Fraction(0)) / len(numbers) if numbers else None
        reason = "" if numbers else "blank in tasks.csv"
        yield MeasuredValue(who, session, trial, said, mean, reason)


def participant_values(study: StudyData, measure: Measure) -> Iterator[MeasuredValue]:
    """Yield the value of each person: a column of participants.csv, such as age."""
    _check_column(study.participants, measure.quantity, "participants.csv")
    for person in study.participants:
        number = _cell(person, measure.quantity, "participants.csv")
        reason = "" if number is not None else "blank in participants.csv"
        yield MeasuredValue(person["participant"], "", "", "", number, reason)


def _check_column(rows: tuple[dict[str, str], ...], column: str, file: str) -> None:
    there = {name for row in rows for name in row}
    if not there:
        raise InputError(f"the outcome `{column}` needs {file}, which the study does not have")
    if column not in there:
        raise InputError(f"{file} has no column `{column}`; {did_you_mean(column, there)}")


def _cell(row: dict[str, str], column: str, file: str) -> Fraction | None:
    text = row.get(column, "")
    try:
        return number_of(text)
    except ValueError:
        raise InputError(
            f"{file}: {column} of participant {row['participant']} is `{text}`, which is no number;"
            " an outcome needs numbers"
        ) from None


_ANSWERED = "of the ratings that were answered"
RATING_QUANTITIES = {
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
"""Missed ratings, without an answer or during a frozen picture, count in none of them."""


def rating_values(study: StudyData, measure: Measure) -> Iterator[MeasuredValue]:
    """Yield the value of each exposure of trials.csv or ratings.csv."""
    instrument = _rated_with(study, measure.instrument)
    exposures = rated_exposures(study, instrument, clock=LiveClock(study))
    longest = max((each.ended_s for each in exposures), default=0.0)
    order = {key: place for place, key in enumerate(_trials_of(study))}
    for each in sorted(exposures, key=lambda each: order.get(each.key[:3], len(order))):
        if each.course.peak() is None:
            reason = "no rating was answered" if each.course.times_s.size else "nothing was rated"
            yield MeasuredValue(*each.key, None, reason)
            continue
        if measure.quantity == "time_to":
            otherwise = longest if each.ending in FINISHED else None
            found = _time_to(each.course, measure.threshold, otherwise)
            reason = "left below the threshold"
        else:
            summary = _SUMMARIES[measure.quantity](each.course)
            found = None if summary is None else exactly(summary)
            gap = each.course.gaps_s.size and measure.quantity == "area"
            reason = "its ratings have a gap" if gap else "only one rating was answered"
        yield MeasuredValue(*each.key, found, "" if found is not None else reason)


def _rated_with(study: StudyData, instrument: str) -> str:
    """Return the instrument that is meant; blank: the only one.

    Raises
    ------
    InputError
        If nothing was rated, or ratings are of several instruments and none is named.
    """
    asked = sorted({each.instrument for each in study.ratings})
    if not asked:
        raise InputError("the study has no ratings (ratings.csv)")
    if not instrument and len(asked) > 1:
        raise InputError(f"ratings are of {', '.join(asked)}; name the instrument that is meant")
    if instrument and instrument not in asked:
        raise InputError(f"nothing was rated with {instrument}; ratings are of {', '.join(asked)}")
    return instrument or asked[0]


def _time_to(
    course: RatingCourse, threshold: float | None, otherwise: float | None
) -> Fraction | None:
    found = course.time_to(math.inf if threshold is None else threshold)
    if found and found.reached:
        return exactly(found.time_s)
    return None if otherwise is None else exactly(otherwise)


def _mean(course: RatingCourse) -> Fraction | None:
    """Return the exact mean of the answered ratings."""
    given, counts = np.unique(course.answered.ratings, return_counts=True)
    if not given.size:
        return None
    pairs = zip(given.tolist(), counts.tolist(), strict=True)
    return sum((Fraction(value) * n for value, n in pairs), Fraction(0)) / int(counts.sum())


def _area(course: RatingCourse) -> float | None:
    return course.area() if course.answered.ratings.size > 1 else None


_SUMMARIES: dict[str, Callable[[RatingCourse], float | Fraction | None]] = {
    "peak": RatingCourse.peak,
    "mean": _mean,
    "last": RatingCourse.last,
    "area": _area,
    "slope": RatingCourse.slope_per_min,
}


def dial_values(study: StudyData, measure: Measure) -> Iterator[MeasuredValue]:
    """Yield the confirmed value of each exposure that had the dial of that name."""
    names = {row["dial"] for row in study.dials}
    if not names:
        message = f"the dial `{measure.quantity}` needs dials.csv"
        raise InputError(f"{message}, which the study does not have")
    if measure.quantity not in names:
        hint = did_you_mean(measure.quantity, names)
        raise InputError(f"dials.csv has no dial `{measure.quantity}`; {hint}")
    found: dict[tuple[str, ...], dict[str, str] | None] = {}
    for row in study.dials:
        if row["dial"] == measure.quantity:
            key = tuple(row.get(name, "") for name in _KEYS)
            found[key] = row if row["kind"] == "confirmed" else found.get(key)
    trials = _trials_of(study)
    for (who, session, trial, condition), last in found.items():
        known = trials.get((who, session, trial), {}).get("condition", "")
        number = None if last is None else _confirmed(last)
        reason = "it was not confirmed" if last is None else "its value is blank"
        said = condition or known
        yield MeasuredValue(who, session, trial, said, number, "" if number is not None else reason)


def _confirmed(row: dict[str, str]) -> Fraction | None:
    try:
        return number_of(row["value"])
    except ValueError:
        who, text = row["participant"], row["value"]
        message = f"dials.csv: the value of participant {who} is `{text}`, which is no number"
        raise InputError(f"{message}; an outcome needs numbers") from None


FRAME_QUANTITIES = {
    "head_path_m": Quantity("Path of the head", "m", "", "the sum of the head’s steps in the room"),
    "head_turning_deg": Quantity(
        "Turning of the head", "°", "", "the sum of the angles that the head turned by"
    ),
    "avatar_path_m": Quantity(
        "Path through the scene", "m", "", "the sum of the steps of what carries the head, jumps "
        "left out",
    ),
    "focus_travel_dioptre": Quantity(
        "Focus changes", "D", "", "the sum of the changes of the focus distance, in dioptres"
    ),
    "focus_lag_dioptre": Quantity(
        "Lag of focus", "D", "", "the mean distance, in dioptres, between the focus and where the "
        "refocus law was moving it to",
    ),
    "blur_changes": Quantity(
        "Changes of the blur limit", "", "", "how often the largest blur of the condition changed"
    ),
}  # fmt: skip


def frame_values(study: StudyData, measure: Measure) -> Iterator[MeasuredValue]:
    """Yield the value of each exposure with frames, as `study_data.with_frames` has summed them."""
    if not study.frames:
        raise InputError(f"{measure.name} needs frames.csv, which the study does not have")
    found = {
        (each.participant, each.session, str(each.trial), each.attempt): each
        for each in study.frames
    }
    for trial in study.trials:
        key = (trial["participant"], trial["session"], trial["trial"])
        frames = found.get((*key, int(trial.get("attempt") or 1)))
        value = None if frames is None else getattr(frames, measure.quantity)
        number = None if value is None else exactly(value)
        reason = "" if number is not None else "no frames say it"
        yield MeasuredValue(*key, trial["condition"], number, reason)


SOURCES = {
    "ratings": MeasureSource(rating_values, RATING_QUANTITIES),
    "trials": MeasureSource(trial_values, TRIAL_QUANTITIES, other_names=True),
    "tasks": MeasureSource(task_values, TASK_QUANTITIES, other_names=True, whole_exposures=True),
    "dials": MeasureSource(dial_values, {}, other_names=True),
    "participants": MeasureSource(participant_values, {}, other_names=True),
    "frames": MeasureSource(frame_values, FRAME_QUANTITIES, whole_exposures=True),
}
"""Name → source. A further kind of measure is a function of values and one more entry."""
CUT_SHORT = "the exposure was cut short"


def fault_of(measure: str) -> str | None:
    """Return the fault of a name that is no measure's; None for a measure."""
    source, dot, quantity = measure.partition(".")
    if not dot or source not in SOURCES:
        known = ", ".join(f"{name}.…" for name in SOURCES)
        return f"`{measure}` is no measure: measures are called {known}"
    known_source = SOURCES[source]
    named = known_source.other_names or quantity in known_source.quantities
    if not quantity or not named:
        names = [f"{source}.{each}" for each in known_source.quantities]
        return f"`{measure}` is no measure; {did_you_mean(measure, names)}"
    return None


def measure_of(name: str, said: MeasureSettings | None = None) -> Measure:
    """Return the measure of a name, with the settings of a plan."""
    source, _, quantity = (said.measure if said else name).partition(".")
    known = SOURCES[source].quantities.get(quantity)
    title = known.title if known else quantity.replace("_", " ").capitalize()
    if said is None:
        unit, better = (known.unit, known.better) if known else ("", "")
        return Measure(name, title, source, quantity, unit, better)
    if quantity == "time_to":
        title = f"Time to a rating of {said.threshold:g}"
    return Measure(
        name=name,
        title=said.label or title,
        source=source,
        quantity=quantity,
        unit_label=said.unit or (known.unit if known else ""),
        better=said.better or (known.better if known else ""),
        instrument=said.instrument,
        threshold=said.threshold,
    )


def possible_values(study: StudyData, measure: Measure) -> Possible:
    """Return the range of the values that a measure can have.

    Of ratings, the scale limits it. The other quantities with a name of their own are times,
    lengths, numbers and shares, which have no sign. Of what a lab calls by its own name, nothing is
    known.
    """
    if measure.source == "ratings" and measure.quantity != "time_to":
        name = _rated_with(study, measure.instrument)
        known = study.instruments.get(name)
        if known is None or measure.quantity == "slope":
            return Possible()
        scale = Possible(float(known.low), float(known.high))
        if measure.quantity != "area":
            return scale
        return possible_area(rated_exposures(study, name, clock=LiveClock(study)), scale)
    quantity = SOURCES[measure.source].quantities.get(measure.quantity)
    if quantity is None:
        return Possible()
    return Possible(0.0, 100.0 if quantity.unit == "%" else None)


def definition_of(measure: Measure) -> str:
    """Return the definition of a measure, as a clause of a methods section."""
    source = SOURCES[measure.source]
    known = source.quantities.get(measure.quantity)
    if known is None and measure.source == "dials":
        return f"the value of the dial {measure.quantity} that was confirmed"
    found = known.definition if known else f"column {measure.quantity} of {measure.source}.csv"
    return f"{found}, of exposures that were not cut short" if source.whole_exposures else found


def values_of(study: StudyData, measure: Measure) -> list[MeasuredValue]:
    """Return the values of a measure, to a common step.

    An exposure that was cut short has none of a measure of whole exposures.

    Raises
    ------
    InputError
        If the study does not have what is measured.
    """
    source = SOURCES[measure.source]
    values = list(source.values(study, measure))
    if source.whole_exposures:
        short = {(t["participant"], t["session"], t["trial"]) for t in study.trials if cut_short(t)}
        values = [
            each._replace(number=None, reason=CUT_SHORT) if each[:3] in short else each
            for each in values
        ]
    return in_steps(values)
