"""Measures: outcomes that are no scores of a questionnaire."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

from pydantic import Field

from vrcomfort.csv_table import number_in
from vrcomfort.settings import Name, Settings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from vrcomfort.report.study_data import StudyData


Limit = Annotated[float, Field(allow_inf_nan=False)]


class MeasureSettings(Settings):
    """An entry of a plan's `measures`: an outcome that is no score of a questionnaire."""

    name: Name
    measure: str
    """``source.quantity``: ratings.peak, tasks.time_s, participants.age, frames.head_path_m, …"""
    label: str = ""
    unit: str = ""
    better: Literal["lower", "higher", ""] = ""
    """Which direction is the good one."""
    instrument: str = ""
    """Of ratings: which instrument, where several were rated."""
    threshold: Limit | None = None
    """Of ratings.time_to: the rating that is to be reached."""


Better = Literal["lower", "higher", ""]
DIGITS = 12
"""Digits of the largest value of a measure to which values are compared: what is alike in them is
tied."""


@dataclass(frozen=True)
class Measure:
    """An outcome from a file of the study, in steps of one size.

    Parameters
    ----------
    name
        In plans and tables.
    title
        In sentences and figures.
    source, quantity
        File of the study (a key of `measures.SOURCES`), and quantity in it.
    unit_label
        Unit, such as s; blank for a pure number.
    better
        The good direction; blank where it is not known.
    instrument
        Of ratings; blank where only one was rated.
    threshold
        Of a time to a threshold: the rating.
    """

    name: str
    title: str
    source: str
    quantity: str
    unit_label: str = ""
    better: Better = ""
    instrument: str = ""
    threshold: float | None = None

    # A measure's steps are its values: tables multiply steps by units, of scores as of measures.
    unit = 1.0
    parts: tuple[str, ...] = ()


class MeasuredValue(NamedTuple):
    """A measure of one exposure, of one person under a condition, or of one person."""

    participant: str
    session: str
    trial: str
    condition: str
    """Blank, as session and trial are, where the file does not say it."""
    number: Fraction | None
    reason: str = ""
    """Why there is no number."""


class Quantity(NamedTuple):
    """A quantity of a source, with its title, unit and definition."""

    title: str
    unit: str
    better: Better
    definition: str
    """A clause for the methods section."""


@dataclass(frozen=True)
class MeasureSource:
    """A file of the study, and its measures.

    Parameters
    ----------
    values
        Returns the values of a study; raises an `InputError` for one without the measure's data.
    quantities
        Those with a name of their own.
    other_names
        Whether any column with numbers, or any dial, may be named as well.
    whole_exposures
        Whether an exposure that was cut short has no value: there was less time for it.
    """

    values: Callable[[StudyData, Measure], Iterable[MeasuredValue]]
    quantities: Mapping[str, Quantity]
    other_names: bool = False
    whole_exposures: bool = False


def number_of(text: str) -> Fraction | None:
    """Return the number that a cell holds, exactly; None of a blank one, and of NA.

    Raises
    ------
    ValueError
        If it is no finite number.
    """
    # Of the text, not of its float: 0.1 + 0.2 ties with 0.3, as in the file.
    return None if number_in(text, words=True) is None else Fraction(text.strip())


def exactly(value: float | Fraction) -> Fraction | None:
    """Return a computed number; None of NaN and infinity."""
    return Fraction(value) if math.isfinite(value) else None


def in_steps(values: list[MeasuredValue]) -> list[MeasuredValue]:
    """Return the values to `DIGITS` digits of the largest, so that those that are alike tie."""
    largest = max((abs(v.number) for v in values if v.number is not None), default=Fraction(0))
    if not largest:
        return values
    power = math.floor(math.log10(largest)) + 1 - DIGITS
    step = Fraction(10) ** power
    return [
        v if v.number is None else v._replace(number=round(v.number / step) * step) for v in values
    ]
