"""Analysis plans: read, checked, derived from data, and written again."""

from vrcomfort.report.plan.data_files import data_files
from vrcomfort.report.plan.derived import plan_of, with_outcomes
from vrcomfort.report.plan.designs import (
    INDEPENDENT,
    PAIRED,
    Agreed,
    Correlated,
    Equivalent,
    Preferred,
)
from vrcomfort.report.plan.model import Contrast, Exclusion, Factor, Family, Plan
from vrcomfort.report.plan.reading import (
    ShippedPlan,
    find_plan,
    load_plan,
    read_plan,
    shipped_files,
    shipped_plans,
)

__all__ = [
    "INDEPENDENT",
    "PAIRED",
    "Agreed",
    "Contrast",
    "Correlated",
    "Equivalent",
    "Exclusion",
    "Factor",
    "Family",
    "Plan",
    "Preferred",
    "ShippedPlan",
    "data_files",
    "find_plan",
    "load_plan",
    "plan_of",
    "read_plan",
    "shipped_files",
    "shipped_plans",
    "with_outcomes",
]
