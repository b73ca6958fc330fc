"""Session time: real for people, virtual (and so reproducible) for simulated participants."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Seconds since the session began."""

    @property
    def is_real(self) -> bool:
        """Whether it is the machine's, which passes by itself."""

    def start(self, at_s: float = 0.0) -> None:
        """Set the time: 0, or where an interrupted session goes on."""

    def now_s(self) -> float:
        """Return the time."""

    def advance(self, duration_s: float) -> None:
        """Take note that something took this long (a frame, an answer)."""

    def wait(self, duration_s: float) -> None:
        """Let this much time pass."""

    def of_people(self, duration_s: float) -> float:
        """Return how much of a time on the wall clock has passed for the participant."""


class VirtualClock:
    """Passes only when told. Counts nanoseconds, so that sums are exact."""

    is_real = False

    def __init__(self) -> None:
        self._now_ns = 0

    def start(self, at_s: float = 0.0) -> None:
        """Set the time."""
        self._now_ns = round(at_s * 1e9)

    def now_s(self) -> float:
        """Return the time."""
        return self._now_ns / 1e9

    def advance(self, duration_s: float) -> None:
        """Move the time on."""
        self._now_ns += round(duration_s * 1e9)

    def wait(self, duration_s: float) -> None:
        """Move the time on, without waiting."""
        self.advance(duration_s)

    def of_people(self, duration_s: float) -> float:  # noqa: ARG002
        """Return 0: simulated participants do not live on while the program is not running."""
        return 0.0


class WallClock:
    """The machine's monotonic clock."""

    is_real = True

    def __init__(self) -> None:
        self.start()

    def start(self, at_s: float = 0.0) -> None:
        """Set the time."""
        self._start_s = time.monotonic() - at_s

    def now_s(self) -> float:
        """Return the time, to the microsecond."""
        return round(time.monotonic() - self._start_s, 6)

    def advance(self, duration_s: float) -> None:
        """Do nothing: the time has passed by itself."""

    def wait(self, duration_s: float) -> None:
        """Sleep."""
        time.sleep(duration_s)

    def of_people(self, duration_s: float) -> float:
        """Return all of it."""
        return duration_s
