"""Puts measures beside the scores of the exposures that they belong to."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import Sheet
from vrcomfort.report.asked import Unscored
from vrcomfort.report.facts import SAME_EXPOSURE, Cell, Row, RowKey
from vrcomfort.report.measures import Measure, MeasuredValue, values_of

if TYPE_CHECKING:
    from fractions import Fraction

    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


def measured(study: StudyData, plan: Plan, measure: Measure) -> list[MeasuredValue]:
    """Return the values of all participants not excluded by the experimenter.

    Raises
    ------
    InputError
        If the study does not have what is measured, with the place in the plan.
    """
    excluded = {p["participant"] for p in study.participants if p["status"] == "excluded"}
    try:
        values = values_of(study, measure)
    except InputError as error:
        raise plan.fault(error.message, "outcomes", plan.outcomes.index(measure.name)) from None
    return [value for value in values if value.participant not in excluded]


def exposure_of(value: MeasuredValue, timepoint: str) -> Sheet:
    """Return the exposure of a value as a questionnaire response without answers."""
    keys = {name: str(getattr(value, name)) for name in _WHOSE}
    return Sheet(0, keys | {"timepoint": timepoint})


_WHOSE = ("participant", "session", "trial", "condition")


def unmeasured(value: MeasuredValue, measure: Measure) -> Unscored:
    """Return the row that says why an exposure has no value."""
    where = [
        f"session {value.session}" if value.session else "",
        f"exposure {value.trial}" if value.trial else "",
        value.condition,
    ]
    name = ", ".join(part for part in (measure.name, *where) if part)
    return Unscored(value.participant, name, value.reason, f"{measure.source}.csv")


class Beside:
    """The rows of exposures at one timepoint, found by the exposure or by person and condition."""

    def __init__(self, rows: dict[RowKey, Row], timepoint: str) -> None:
        self._rows = rows
        self._of_exposure: dict[RowKey, Row] = {}
        self._of_condition: dict[RowKey, list[Row]] = defaultdict(list)
        self._of_person: dict[Cell, list[Row]] = defaultdict(list)
        for row in rows.values():
            if row["timepoint"] == timepoint:
                self._index(row)

    def _index(self, row: Row) -> None:
        if row["number"]:
            key = row["participant"], row["session"], row["number"]
            self._of_exposure.setdefault(key, row)
        self._of_condition[row["participant"], row["condition"]].append(row)
        self._of_person[row["participant"]].append(row)

    def put(self, row: Row, name: str, number: Fraction) -> None:
        """Add a measure to the row of its exposure, if there is one, else as a row of its own.

        What is said of a person (under a condition), of no one exposure, goes to the only one.
        """
        who, condition = row["participant"], row["condition"]
        if row["number"]:
            same = [self._of_exposure.get((who, row["session"], row["number"]))]
        else:
            same = [*(self._of_condition[who, condition] if condition else self._of_person[who])]
        found = same[0] if len(same) == 1 else None
        if found is None or name in found:
            found = dict(row)
            key = tuple(row[each] for each in SAME_EXPOSURE)
            while key in self._rows:
                key = (*key, name)
            self._rows[key] = found
            self._index(found)
        found[name] = number
