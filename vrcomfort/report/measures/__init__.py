"""Outcomes that are no scores: what each file of a study can measure. One file and one line each.

A plan names them ``source.quantity``, such as ``ratings.peak`` or ``tasks.time_s``, or gives them a
name, a label, a unit and a direction of its own in ``[[measures]]``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from vrcomfort.report.measures.dials import Dials
from vrcomfort.report.measures.frames import Frames
from vrcomfort.report.measures.model import Measure, Quantity, Source, Value, in_steps
from vrcomfort.report.measures.ratings import Course, Ratings, courses_of
from vrcomfort.report.measures.settings import Limit, Measured
from vrcomfort.report.measures.tables import Participants, Tasks, Trials
from vrcomfort.report.study_data import cut_short
from vrcomfort.settings import did_you_mean

if TYPE_CHECKING:
    from vrcomfort.report.study_data import StudyData

__all__ = [
    "SOURCES",
    "Course",
    "Limit",
    "Measure",
    "Measured",
    "Value",
    "courses_of",
    "definition_of",
    "fault_of",
    "measure_of",
    "values_of",
]

SOURCES: dict[str, Source] = {
    "ratings": Ratings(),
    "trials": Trials(),
    "tasks": Tasks(),
    "dials": Dials(),
    "participants": Participants(),
    "frames": Frames(),
}
"""Name → where measures are read from. A further kind of measure is one more entry."""
CUT_SHORT = "the exposure was cut short"
_OPEN = ("trials", "tasks", "dials", "participants")
"""Sources of which any column with numbers, or any dial, may be named."""


def fault_of(measure: str) -> str | None:
    """Say why a name is none of a measure; None where it is one."""
    source, dot, quantity = measure.partition(".")
    if not dot or source not in SOURCES:
        known = ", ".join(f"{name}.…" for name in SOURCES)
        return f"`{measure}` is no measure: measures are called {known}"
    if not quantity or (source not in _OPEN and quantity not in SOURCES[source].quantities):
        names = [f"{source}.{each}" for each in SOURCES[source].quantities]
        return f"`{measure}` is no measure; {did_you_mean(measure, names)}"
    return None


def measure_of(name: str, said: Measured | None = None) -> Measure:
    """Return the measure of a name, with what a plan says of it."""
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


def definition_of(measure: Measure) -> str:
    """Return what it is, as a clause of a methods section."""
    source = SOURCES[measure.source]
    known: Quantity | None = source.quantities.get(measure.quantity)
    if known is None and measure.source == "dials":
        return f"the value of the dial {measure.quantity} that was confirmed"
    found = known.definition if known else f"column {measure.quantity} of {measure.source}.csv"
    return f"{found}, of exposures that were not cut short" if source.of_whole_exposures else found


def values_of(study: StudyData, measure: Measure) -> list[Value]:
    """Return the values of a measure, to a common step.

    An exposure that was cut short has none of a measure of whole exposures.

    Raises
    ------
    InputError
        If the study does not have what is measured.
    """
    source = SOURCES[measure.source]
    values = list(source.values(study, measure))
    if source.of_whole_exposures:
        short = {(t["participant"], t["session"], t["trial"]) for t in study.trials if cut_short(t)}
        values = [
            each._replace(number=None, reason=CUT_SHORT) if each[:3] in short else each
            for each in values
        ]
    return in_steps(values)
