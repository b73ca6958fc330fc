"""Times of frames: their reliability, the refresh period, and a test of their regularity."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from statistics import median_low

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import DROPPED_INTERVAL_PERIODS
from vrcomfort.headset.base import Headset

SIMULATORS = ("simulat", "emulat", "remote hmd", "qwerty", "null", "dummy")
"""Words in the names of runtimes and headsets that show nothing to anybody."""


class TimingTrust(StrEnum):
    """Trust in the times of frames, in rising order.

    None of them is an onset: that takes a light sensor on the display.
    """

    NONE = "none"
    """When the program drew; nothing is known of the display."""
    LOCKSTEP = "lockstep"
    """Times of a trace that is played back: exact, and nothing was displayed."""
    SIMULATED = "simulated"
    """A runtime that shows nothing made them up; their order and spacing are right."""
    RUNTIME = "runtime"
    """Predictions of a compositor that drives a display; OpenXR does not tell what came of them."""


@dataclass(frozen=True)
class Timing:
    """A rating, and the reason in words."""

    trust: TimingTrust
    reason: str


def rate_runtime(runtime: str, headset: str) -> Timing:
    """Rate the times of an OpenXR runtime by the names that it gives itself and its headset."""
    names = f"{runtime} {headset}".casefold()
    if any(word in names for word in SIMULATORS):
        return Timing(
            TimingTrust.SIMULATED, f"{headset} is no display: its runtime makes the times up"
        )
    return Timing(
        TimingTrust.RUNTIME,
        "the runtime predicts when a frame is displayed; OpenXR does not tell when it was",
    )


@dataclass(frozen=True)
class TimingTest:
    """How regularly frames came.

    Parameters
    ----------
    seconds
        From the first to the last predicted display time.
    frames
        That came.
    dropped
        Refreshes that passed without a frame, where an interval exceeded 1.2 periods.
    period_ms
        That the runtime states (median).
    interval_median_ms, interval_p99_ms
        Between predicted display times.
    wait_median_ms, wait_p99_ms
        Between the moments at which the program got its frames, by its own clock.
    """

    seconds: float
    frames: int
    dropped: int
    period_ms: float
    interval_median_ms: float
    interval_p99_ms: float
    wait_median_ms: float
    wait_p99_ms: float


def time_frames(
    headset: Headset, eyes: tuple[moderngl.Texture, moderngl.Texture], seconds: float
) -> TimingTest | None:
    """Show two still images for a time and count; None with fewer than two visible frames."""
    shown_ns: list[int] = []
    period_ns: list[int] = []
    got_ns: list[int] = []
    for frame in headset.frames():
        got_ns.append(time.monotonic_ns())
        headset.submit(frame, eyes if frame.should_render else None)
        if not frame.seen:
            got_ns.clear()
            continue
        shown_ns.append(frame.predicted_display_time_ns)
        period_ns.append(frame.period_ns)
        if shown_ns[-1] - shown_ns[0] >= seconds * 1e9:
            break
    if len(shown_ns) < 2:
        return None
    return _summary(np.diff(shown_ns) / 1e6, np.array(period_ns) / 1e6, np.diff(got_ns) / 1e6)


def _summary(
    interval_ms: NDArray[np.float64], period_ms: NDArray[np.float64], wait_ms: NDArray[np.float64]
) -> TimingTest:
    periods = interval_ms / period_ms[1:]
    late = periods > DROPPED_INTERVAL_PERIODS
    return TimingTest(
        seconds=float(interval_ms.sum() / 1e3),
        frames=len(interval_ms) + 1,
        dropped=int(np.maximum(np.round(periods[late]) - 1, 1).sum()),
        period_ms=float(np.median(period_ms)),
        interval_median_ms=float(np.median(interval_ms)),
        interval_p99_ms=float(np.percentile(interval_ms, 99)),
        wait_median_ms=float(np.median(wait_ms)),
        wait_p99_ms=float(np.percentile(wait_ms, 99)),
    )


REMEMBERED = 63
"""Frames whose predicted periods are remembered: under a second of most displays."""
MEASURED = 9
"""Intervals of which the period is measured, where nothing tells it."""


class RefreshPeriod:
    """Takes the usual one of the periods that a runtime has predicted lately.

    Some runtimes predict the program's own period: after a frame that took a second, it is a
    second, and goes back slowly. Measured against that, no frame would ever be late.

    Others predict none (0). Then the display's refresh rate gives the period, or else the median
    interval between the first display times; it is kept, for later intervals are the program's own.

    Parameters
    ----------
    display_hz
        Returns the display's refresh rate as the runtime tells it; 0 where it does not.

    Attributes
    ----------
    source
        Where the period comes from, in words; empty while it is not known.
    """

    def __init__(self, display_hz: Callable[[], float] = lambda: 0.0) -> None:
        self._display_hz = display_hz
        self._predicted_ns: deque[int] = deque(maxlen=REMEMBERED)
        self._otherwise_ns: int | None
        self.forget()

    def update(self, predicted_ns: int, display_ns: int | None = None) -> int:
        """Return the refresh period, from a frame's predicted period and display time.

        Parameters
        ----------
        display_ns
            When the frame is displayed; None where it is not.

        Returns
        -------
        period_ns
            0 while it is not known.
        """
        if predicted_ns > 0:
            self._predicted_ns.append(predicted_ns)
            self.source = "predicted by the runtime"
        if self._predicted_ns:
            return median_low(self._predicted_ns)
        if self._otherwise_ns is None:
            self._otherwise_ns = self._told_ns() or self._measured_ns(display_ns)
        return self._otherwise_ns or 0

    def forget(self) -> None:
        """Begin anew: the display's rate has changed."""
        self._predicted_ns.clear()
        self._intervals_ns: list[int] = []
        self._last_ns: int | None = None
        self._otherwise_ns = None
        self.source = ""

    def _told_ns(self) -> int | None:
        display_hz = self._display_hz()
        if display_hz <= 0:
            return None
        self.source = "the display's refresh rate; the runtime predicts no period"
        return round(1e9 / display_hz)

    def _measured_ns(self, display_ns: int | None) -> int | None:
        before_ns, self._last_ns = self._last_ns, display_ns
        if before_ns is not None and display_ns is not None and display_ns > before_ns:
            self._intervals_ns.append(display_ns - before_ns)
        if len(self._intervals_ns) < MEASURED:
            return None
        self.source = (
            f"measured: the median of {MEASURED} intervals between predicted display times; the "
            "runtime predicts no period"
        )
        return median_low(self._intervals_ns)
