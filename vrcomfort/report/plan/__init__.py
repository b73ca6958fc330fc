"""Analysis plans: their model, and rules that types cannot say; `plan_files` reads them."""

from vrcomfort.report.plan.data_files import data_files
from vrcomfort.report.plan.model import (
    INDEPENDENT,
    PAIRED,
    Contrast,
    Entry,
    Exclusion,
    Factor,
    Family,
    Plan,
)
from vrcomfort.report.plan.rules import problems

__all__ = [
    "INDEPENDENT",
    "PAIRED",
    "Contrast",
    "Entry",
    "Exclusion",
    "Factor",
    "Family",
    "Plan",
    "data_files",
    "problems",
]
