"""Compares times as they are recorded: decimal text, to the microsecond and finer."""

from __future__ import annotations

TOLERANCE_S = 1e-6
"""The clock of people's sessions is recorded to the microsecond, and sums of times are rounded."""


def before(one_s: float, other_s: float) -> bool:
    """Return whether a time is earlier than another, by more than rounding."""
    return one_s < other_s - TOLERANCE_S


def within(time_s: float, start_s: float, end_s: float) -> bool:
    """Return whether a time lies between two, but for rounding."""
    return not before(time_s, start_s) and not before(end_s, time_s)
