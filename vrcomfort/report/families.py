"""What a test decides, alone or in a family, and the intervals that say the same.

One rule for whatever a report says of a test. The p that decides is the adjusted one where there is
a family. The intervals beside it are those of the level at which Holm's method decides on the test,
so that they hold no difference exactly where none was shown.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from vrcomfort.report.words import value_of
from vrcomfort.stats.multiplicity import holm_levels

if TYPE_CHECKING:
    from collections.abc import Callable


Row = dict[str, Any]
Verdict = Literal["higher", "lower", "not_shown", "not_possible"]
"""Of the first side; `not_possible`: so few people cannot give a p at which a difference is shown,
whatever they answer."""
UNDECIDED: Row = {
    "family": None, "p_holm": None, "level": None, "verdict": None, "smallest_p": None,
    "higher": None, "simultaneous": None,
}  # fmt: skip
"""What is decided of a test once all are made; it stays so where there is no test."""
INTERVALS = ("shift", "difference", "effect")


def decide(row: Row, level: float, p_values: list[float | None], place: int) -> None:
    """Set the level at which a test decides among others, and its verdict."""
    row["level"] = holm_levels(p_values, level)[place]
    if row["p"] <= row["level"]:
        row["verdict"] = "higher" if row["higher"] else "lower"
        return
    best = [*p_values]
    best[place] = smallest = row["smallest_p"]
    own = holm_levels(best, level)[place]
    row["verdict"] = "not_shown" if own is not None and smallest <= own else "not_possible"


def add_intervals(row: Row, level: float, again: Callable[[float], Row]) -> None:
    """Set `simultaneous`, the intervals of a test in a family; None where it decides at `level`.

    Parameters
    ----------
    again
        Confidence → the test with its intervals.
    """
    if row["level"] is not None and row["level"] < level:
        found = again(1 - row["level"])
        row["simultaneous"] = {name: found[name] for name in INTERVALS if name in found}


def reported(row: Row, name: str) -> Any:
    """Return the estimate with the interval that belongs to the p that decides."""
    return (row["simultaneous"] or row)[name]


def verdict_alone(
    p: float | None, smallest_p: float, confidence: float, *, higher: bool
) -> Verdict | None:
    """Return the verdict of a test that is in no family; None where there is no p."""
    if p is None:
        return None
    row: Row = {"p": p, "smallest_p": smallest_p, "higher": higher}
    decide(row, 1 - confidence, [p], 0)
    found: Verdict = row["verdict"]
    return found


def is_shown(row: Any) -> bool:
    """Return whether a test has shown what it looked for."""
    return value_of(row, "verdict") not in {None, "not_shown", "not_possible"}


def disagreement(row: Any, found: Any, null: float = 0.0) -> str:
    """Say that an interval and the verdict of its test differ about the null value; or nothing.

    Those of the default methods do not, but for rank-biserials and correlations, whose intervals
    are not inversions of the printed test; nor is that of a plan that asks for order statistics.
    """
    if not found or (value_of(found, "low") is None and value_of(found, "high") is None):
        return ""
    if holds(found, null) != is_shown(row):
        return ""
    value = f"{null:g}".removeprefix("0") or "0"
    if is_shown(row):
        return f" (which includes {value}, though the test rejects it)"
    return f" (which excludes {value}, though the test does not reject it)"


def holds(found: Any, value: float) -> bool:
    """Return whether a value is in an interval, whose ends may be open or missing."""
    low, high = value_of(found, "low"), value_of(found, "high")
    if value_of(found, "holds_rejected_zero") and value == 0:
        return False
    above = low is None or low < value or (low == value and value_of(found, "low_closed", True))
    below = high is None or high > value or (high == value and value_of(found, "high_closed", True))
    return bool(above and below)
