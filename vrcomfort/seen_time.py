"""One account of seen time: each display interval of an exposure is in exactly one state.

Recorder, verify and reports take the states from here, so that they agree on every second.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import DROPPED_INTERVAL_PERIODS, Frame

FREEZE_S = 0.5
"""A picture that stands still for longer than this beyond its period is frozen: questions that fell
due in it were missed. After a shorter one, they are asked late."""
UNTOLD_PERIODS = 2.0
"""No frame need tell of so much of an exposure's time: it begins before its first frame is shown,
and its clock is not the display's."""


class SeenState(StrEnum):
    """The states of a display interval; of those that hold, the first counts."""

    OFF = "off"
    """The headset was off: its presence sensor saw nobody."""
    HIDDEN = "hidden"
    """Nothing was visible: a pause, a session that the runtime does not show, no frames at all."""
    NOT_DRAWN = "not_drawn"
    """The runtime wanted no picture (`shouldRender` of OpenXR)."""
    FROZEN = "frozen"
    """A frame stood still: longer than its period by more than `FREEZE_S`."""
    HALF_RATE = "half_rate"
    """The next frame came late: at half the display's rate, or less."""
    UNTRACKED = "untracked"
    """The head's pose was not measured: inferred, or the last known."""
    UNFOCUSED = "unfocused"
    """A menu of the runtime's was in front: the participant could not stop."""
    LIVE = "live"
    """None of these: seen as it was meant."""

    @property
    def column(self) -> str:
        """Return the column of ``trials.csv`` with its seconds."""
        return f"{self.value}_s"


UNSEEN = (SeenState.OFF, SeenState.HIDDEN, SeenState.NOT_DRAWN)
"""In which the participant saw nothing: the exposure waits."""
SEEN = (SeenState.HALF_RATE, SeenState.UNTRACKED, SeenState.UNFOCUSED, SeenState.LIVE)
"""In which the participant saw the stimulus: the exposure's dose."""
LIMITED = (SeenState.FROZEN, *SEEN[:-1])
"""Flagged beyond the protocol's limits."""


FRAME_COLUMNS = (
    *("xr_time_ns", "period_ns", "discontinuity", "user_present", "paused"),
    *("should_render", "head_tracked", "session_state"),
)
"""Of ``frames.csv``, from which states are made again."""


class ShownFrame(NamedTuple):
    """The state of a frame, which holds until the next one.

    Parameters
    ----------
    cut
        Nothing is known of the time before the frame but that a frame's period was shown.
    """

    time_ns: int
    period_ns: int
    cut: bool
    off: bool
    hidden: bool
    drawn: bool
    tracked: bool
    unfocused: bool

    @classmethod
    def of(cls, frame: Frame) -> Self:
        """Return the state of a headset's frame."""
        return cls(
            frame.predicted_display_time_ns,
            frame.period_ns,
            frame.discontinuity,
            frame.user_present is False,
            frame.paused,
            frame.should_render,
            frame.head_tracked,
            frame.session_state == "visible",
        )

    @classmethod
    def of_row(cls, row: Mapping[str, Any]) -> Self:
        """Return the state of a row of ``frames.csv``; a blank cell (None) leaves it unknown."""
        return cls(
            row["xr_time_ns"],
            row["period_ns"],
            row["discontinuity"] == 1,
            row["user_present"] == 0,
            row["paused"] == 1,
            row["should_render"] != 0,
            row["head_tracked"] != 0,
            row["session_state"] == "visible",
        )

    @property
    def state(self) -> SeenState:
        """Return the state of the frame while it is shown for its period."""
        if self.off:
            return SeenState.OFF
        if self.hidden:
            return SeenState.HIDDEN
        if not self.drawn:
            return SeenState.NOT_DRAWN
        if not self.tracked:
            return SeenState.UNTRACKED
        return SeenState.UNFOCUSED if self.unfocused else SeenState.LIVE


def unseen_rows(columns: Mapping[str, NDArray[np.float64]]) -> NDArray[np.bool_]:
    """Return (n,) whether the state of each row is one of `UNSEEN`.

    Parameters
    ----------
    columns
        ``user_present``, ``paused`` and ``should_render`` of ``frames.csv``, shape (n,); a blank
        cell (NaN) leaves it unknown, which is seen.
    """
    off, hidden = columns["user_present"] == 0, columns["paused"] == 1
    unseen: NDArray[np.bool_] = off | hidden | (columns["should_render"] == 0)
    return unseen


def is_late(passed_ns: int, period_ns: int) -> bool:
    """Return whether a frame came later than it was due."""
    return passed_ns > DROPPED_INTERVAL_PERIODS * period_ns


def passed_between_ns(before: ShownFrame, frame: ShownFrame) -> int:
    """Return the display time between two frames; where it jumps back, the first one's period."""
    passed_ns = frame.time_ns - before.time_ns
    return passed_ns if passed_ns > 0 else before.period_ns


def display_intervals(before: ShownFrame, frame: ShownFrame) -> Iterator[tuple[SeenState, int]]:
    """Yield the states between two frames with their nanoseconds, which sum to the interval."""
    state, period_ns = before.state, before.period_ns
    passed_ns = passed_between_ns(before, frame)
    late = is_late(passed_ns, period_ns)
    if state in UNSEEN:
        yield state, passed_ns
    elif frame.cut:
        yield state, min(passed_ns, period_ns)
        yield SeenState.HIDDEN, max(passed_ns - period_ns, 0)
    elif late and passed_ns - period_ns > FREEZE_S * 1e9:
        yield state, period_ns
        yield SeenState.FROZEN, passed_ns - period_ns
    elif late:
        yield SeenState.HALF_RATE, passed_ns
    else:
        yield state, passed_ns


@dataclass
class SeenTime:
    """The seconds of an exposure by state: they add up to it."""

    _ns: dict[SeenState, int] = field(default_factory=lambda: dict.fromkeys(SeenState, 0))
    _frame: ShownFrame | None = None
    """The last frame, whose time is not over."""

    @classmethod
    def of(cls, frames: Iterable[ShownFrame], elapsed_s: float) -> Self:
        """Return the account of an exposure that took `elapsed_s` on the session's clock."""
        account = cls()
        for frame in frames:
            account.add(frame)
        account.end(elapsed_s)
        return account

    def add(self, frame: ShownFrame) -> None:
        """Close the time of the frame before."""
        before, self._frame = self._frame, frame
        if before is not None:
            for state, passed_ns in display_intervals(before, frame):
                self._ns[state] += passed_ns

    def pass_without_frames(self, duration_s: float) -> None:
        """Count time as seen, in a session that draws no frames."""
        self._ns[SeenState.LIVE] += round(duration_s * 1e9)

    def end(self, elapsed_s: float) -> None:
        """Give the last frame its period; the time without frames was not visible."""
        untold_ns = round(elapsed_s * 1e9) - sum(self._ns.values())
        before, self._frame = self._frame, None
        if before is not None:
            self._ns[before.state] += before.period_ns
            untold_ns -= before.period_ns
        waits = before is None or before.state in UNSEEN
        if untold_ns > (0 if before is None or waits else UNTOLD_PERIODS * before.period_ns):
            state = before.state if before is not None and waits else SeenState.HIDDEN
            self._ns[state] += untold_ns

    def seconds(self, *states: SeenState) -> float:
        """Return the seconds in some states, in all of them without any."""
        return sum(self._ns[state] for state in states or SeenState) / 1e9

    def percent(self, state: SeenState) -> float:
        """Return the share of a state in the time in which the exposure did not wait."""
        shown_s = self.seconds(SeenState.FROZEN, *SEEN)
        return round(100 * self.seconds(state) / shown_s, 2) if shown_s else 0.0

    def beyond(self, limits_percent: Mapping[str, float]) -> list[SeenState]:
        """Return the states that are to be flagged, by limits in per cent of the same time."""
        return [
            state
            for state in LIMITED
            if self.percent(state) > limits_percent.get(state.value, math.inf)
        ]

    @classmethod
    def of_cells(cls, row: Mapping[str, Any]) -> Self:
        """Return the account that a row of ``trials.csv`` has; blank cells (None) are 0 s."""
        return cls({state: round((row[state.column] or 0.0) * 1e9) for state in SeenState})

    def cells(self) -> dict[str, Any]:
        """Return the seconds, named as the columns of ``trials.csv``."""
        return {state.column: round(self.seconds(state), 9) for state in SeenState}
