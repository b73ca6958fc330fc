"""Measures that stand in columns: of trials.csv, of a side table of tasks, of participants.csv."""

from __future__ import annotations

from collections import defaultdict
from fractions import Fraction
from typing import TYPE_CHECKING, ClassVar

from vrcomfort.errors import InputError
from vrcomfort.report.measures.model import Measure, Quantity, Value, exactly, number_of
from vrcomfort.report.study_data import trial_s
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vrcomfort.report.study_data import StudyData

NOT_RECORDED = "not recorded"
TRIAL_QUANTITIES = {
    "frames": Quantity("Frames", "", "", "the frames that were drawn in an exposure"),
    "dropped": Quantity("Dropped frames", "", "lower", "the frames that were late"),
    "dropped_percent": Quantity("Dropped frames", "%", "lower", "the share of late frames"),
    "missed_refreshes": Quantity("Missed refreshes", "", "lower", "refreshes without a new frame"),
    "length_s": Quantity("Length of exposure", "s", "", "from the start of an exposure to its end"),
    "live_s": Quantity("Live time", "s", "", "the time in which new frames were seen"),
    "frozen_s": Quantity("Frozen time", "s", "lower", "the time for which a frame stood still"),
    "hidden_s": Quantity("Hidden time", "s", "", "the time in which no frame was seen"),
    "unfocused_s": Quantity("Time behind a menu", "s", "", "the time with a menu in front"),
}


class Trials:
    """``trials.csv``: what every trial has, and any other column with numbers."""

    quantities: ClassVar[dict[str, Quantity]] = TRIAL_QUANTITIES
    of_whole_exposures: ClassVar[bool] = False

    def values(self, study: StudyData, measure: Measure) -> Iterator[Value]:
        """Yield the value of each exposure."""
        derived = {"length_s", "dropped_percent"}
        if measure.quantity not in derived:
            _check_column(study.trials, measure.quantity, "trials.csv")
        for trial in study.trials:
            key = trial["participant"], trial["session"], trial["trial"], trial["condition"]
            found = _of_trial(trial, measure.quantity)
            yield Value(*key, found, "" if found is not None else NOT_RECORDED)


def _of_trial(trial: dict[str, str], name: str) -> Fraction | None:
    if name == "length_s":
        length = trial_s({**trial, "live_s": ""})
        return None if length is None else exactly(length)
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


class Tasks:
    """``tasks.csv``: participant, trial or condition, and columns with numbers.

    Several rows of one exposure, such as shots, are averaged.
    """

    quantities: ClassVar[dict[str, Quantity]] = TASK_QUANTITIES
    of_whole_exposures: ClassVar[bool] = True

    def values(self, study: StudyData, measure: Measure) -> Iterator[Value]:
        """Yield the value of each exposure, or of each person under each condition."""
        kind = _SHARES.get(measure.quantity)
        column, factor = ("hit", 100) if kind else (measure.quantity, 1)
        for each in (column, "kind") if kind else (column,):
            _check_column(study.tasks, each, "tasks.csv")
        found: dict[tuple[str, ...], list[Fraction]] = defaultdict(list)
        for row in study.tasks:
            key = tuple(row.get(n, "") for n in ("participant", "session", "trial", "condition"))
            counts = kind is None or row.get("kind") == kind
            number = _cell(row, column, "tasks.csv") if counts else None
            found[key] += [] if number is None else [factor * number]
        conditions = {(t["participant"], t["session"], t["trial"]): t for t in study.trials}
        for (who, session, trial, condition), numbers in found.items():
            said = condition or conditions.get((who, session, trial), {}).get("condition", "")
            mean = sum(numbers, Fraction(0)) / len(numbers) if numbers else None
            reason = "" if numbers else "blank in tasks.csv"
            yield Value(who, session, trial, said, mean, reason)


class Participants:
    """``participants.csv``: any column with numbers, such as age or a score of susceptibility."""

    quantities: ClassVar[dict[str, Quantity]] = {}
    of_whole_exposures: ClassVar[bool] = False

    def values(self, study: StudyData, measure: Measure) -> Iterator[Value]:
        """Yield the value of each person."""
        _check_column(study.participants, measure.quantity, "participants.csv")
        for person in study.participants:
            number = _cell(person, measure.quantity, "participants.csv")
            reason = "" if number is not None else "blank in participants.csv"
            yield Value(person["participant"], "", "", "", number, reason)


def _check_column(rows: tuple[dict[str, str], ...], column: str, file: str) -> None:
    there = {name for row in rows for name in row}
    if not there:
        raise InputError(f"the study has no {file}, of which column `{column}` is an outcome")
    if column not in there:
        raise InputError(f"`{column}` is no column of {file}; {did_you_mean(column, there)}")


def _cell(row: dict[str, str], column: str, file: str) -> Fraction | None:
    text = row.get(column, "")
    try:
        return number_of(text)
    except ValueError:
        raise InputError(
            f"{file}: {column} of participant {row['participant']} is `{text}`, which is no number;"
            " an outcome needs numbers"
        ) from None
