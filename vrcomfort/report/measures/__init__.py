"""Outcomes that are no scores: measures of the files of a study.

A plan names them ``source.quantity``, such as ``ratings.peak`` or ``tasks.time_s``, or gives them a
name, a label, a unit and a direction of its own in ``[[measures]]``.
"""

from vrcomfort.report.measures.model import Limit, Measure, MeasuredValue, MeasureSettings
from vrcomfort.report.measures.sources import (
    SOURCES,
    definition_of,
    fault_of,
    measure_of,
    possible_values,
    values_of,
)

__all__ = [
    "SOURCES",
    "Limit",
    "Measure",
    "MeasureSettings",
    "MeasuredValue",
    "definition_of",
    "fault_of",
    "measure_of",
    "possible_values",
    "values_of",
]
