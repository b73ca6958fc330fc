"""What a plan says beyond signed-rank tests of pairs and analyses of variance."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.report.measures import Limit
from vrcomfort.settings import Name, Settings

TestName = Literal[
    "signed_rank", "paired_t", "sign", "mann_whitney", "welch_t", "student_t"
]  # fmt: skip
PAIRED = ("signed_rank", "paired_t", "sign")
INDEPENDENT = ("mann_whitney", "welch_t", "student_t")


class Correlated(Settings):
    """Two outcomes that are correlated."""

    x: str
    y: str
    method: Literal["spearman", "pearson", "kendall", "repeated_measures"] = "spearman"
    """`repeated_measures`: within people, over exposures; others: one value per person."""
    condition: str = ""
    """Of which exposures; blank: of all, each person's mean."""


class Equivalent(Settings):
    """A difference that is to be shown to lie within bounds."""

    outcome: str
    a: str
    b: str
    between: str = ""
    """Blank: of the same people; else as in a contrast."""
    condition: str = ""
    low: Limit
    high: Limit
    """Bounds of the difference of means, in points of the outcome."""


class Preferred(Settings):
    """What people preferred: one thing, the other, or neither."""

    name: Name
    column: str = ""
    """Of participants.csv; or `item`."""
    item: str = ""
    """``instrument.item`` of a questionnaire that compares conditions: 1, 2, … are answered for the
    first, the second, … that somebody met, and 0 for none. Who was asked several times counts for
    what they chose more often."""
    label: str = ""
    a: str
    b: str
    """Values of the column, or conditions."""
    none: tuple[str, ...] = ("none",)
    """Values that say that there is no preference; blank cells are missing."""


class Ordinal(Settings):
    """A single item, or another outcome of few values, whose order alone counts."""

    outcome: str
    """An item of a questionnaire, or an outcome of the plan."""
    factors: Annotated[tuple[str, ...], Field(min_length=1)] = ("condition",)
    """Columns as in the mixed model."""


class Agreed(Settings):
    """How far repeated exposures of the same people agree."""

    outcome: str
    over: Literal["session", "position", "scene", "part", "condition"] = "session"
    condition: str = ""
    """Of which exposures; blank: of all."""
