"""Compares recorded times, and tells the attempt at a trial that a frame is of."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

from vrcomfort.records.tables import RecordedRow

TOLERANCE_S = 1e-6
"""The clock of people's sessions is recorded to the microsecond, and sums of times are rounded."""


def before(one_s: float, other_s: float) -> bool:
    """Return whether a time is earlier than another, by more than rounding."""
    return one_s < other_s - TOLERANCE_S


def within(time_s: float, start_s: float, end_s: float) -> bool:
    """Return whether a time lies between two, but for rounding."""
    return not before(time_s, start_s) and not before(end_s, time_s)


Attempt: TypeAlias = tuple[int, int]
"""Numbers of a trial and of an attempt at it."""


class FramesOfAttempts:
    """Counts the frames of each attempt, row by row in the order of ``frames.csv``.

    An attempt may begin at the very time of the last frame of the one before it: after an
    interruption the session's clock goes on where it stopped.

    Parameters
    ----------
    attempts
        Rows of ``trials.csv``, and what the manifest has of the exposure under way.

    Attributes
    ----------
    counts
        Attempt → frames until now.
    """

    def __init__(self, attempts: Iterable[RecordedRow | Mapping[str, Any]]) -> None:
        self.counts: Counter[Attempt] = Counter()
        self._of_trial: dict[int, list[_Span]] = {}
        for each in attempts:
            self._of_trial.setdefault(each["trial"], []).append(_Span(each))

    def add(self, row: RecordedRow | Mapping[str, Any]) -> Attempt | None:
        """Count a frame; return the attempt that it is of, None where there is none.

        A row of a pause is no frame that was shown, and not counted.
        """
        found = [
            each
            for each in self._of_trial.get(row["trial"], ())
            if within(row["session_s"], each.start_s, each.end_s)
        ]
        if len(found) > 1:
            found = [each for each in found if each.resumed == row["resumed"]] or found
            found = [each for each in found if self.counts[each.attempt] < each.frames] or found
        if not found:
            return None
        values = row.values if isinstance(row, RecordedRow) else row
        self.counts[found[0].attempt] += values.get("paused") != 1
        return found[0].attempt


class _Span:
    """When an attempt was, and how many frames it had; one under way has no end."""

    def __init__(self, row: RecordedRow | Mapping[str, Any]) -> None:
        values = row.values if isinstance(row, RecordedRow) else row
        self.attempt: Attempt = values["trial"], values["attempt"]
        self.start_s: float = values["start_s"]
        self.end_s: float = values.get("end_s", math.inf)
        self.frames: float = values.get("frames", math.inf)
        self.resumed: int = values["resumed"]
