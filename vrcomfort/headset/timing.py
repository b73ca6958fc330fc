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

from vrcomfort.frame import DROPPED_INTERVAL_PERIODS, HeadsetEvent
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


SECOND_NS = 1_000_000_000
REMEMBERED = 63
"""Frames whose predicted periods are remembered: under a second of most displays."""
MEASURED = 9
"""Stable predictions, or else intervals, of which the period is taken where no rate is known."""
SAME_RATE = 0.05
"""Share of a period by which another one may differ, and be of the same rate."""
RATE_CHANGED, RATE_RESTORED = "refresh_rate_changed", "refresh_rate_restored"
"""Events: the display's rate is another than at the start; it is that of the start."""


class RefreshPeriod:
    """Fixes the display's period at the start; a change of it is told, and changes nothing else.

    It is that of the rate that was asked for, or of the rate that the runtime tells; else the
    median of the first predicted periods that are stable; else, of a runtime that predicts none
    (0), the median interval between the first display times. A runtime that halves its rate
    doubles the periods that it predicts: measured against these, no frame would ever be late.

    Parameters
    ----------
    display_hz
        Returns the display's refresh rate as it was asked for, or as the runtime tells it; 0 where
        neither is known.
    notify
        Called when the rate is no longer, or again, that of the start.

    Attributes
    ----------
    source
        Where the period comes from, in words; empty while it is not known.
    """

    def __init__(
        self,
        display_hz: Callable[[], float] = lambda: 0.0,
        notify: Callable[[HeadsetEvent], None] = lambda _: None,
    ) -> None:
        self._display_hz, self._notify = display_hz, notify
        self._predicted_ns: deque[int] = deque(maxlen=REMEMBERED)
        self._intervals_ns: list[int] = []
        self._last_ns: int | None = None
        self._fixed_ns: int | None = None
        self._first_predicted_ns: int | None = None
        self._told_ns: int | None = None
        self._tells_rate = False
        self.source = ""

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
        if self._fixed_ns is None:
            self._fixed_ns = (
                self._rate_ns() or self._predicted_period_ns() or self._measured_ns(display_ns)
            )
        if self._fixed_ns is not None:
            self._compare()
            return self._fixed_ns
        return median_low(self._predicted_ns) if self._predicted_ns else 0

    def take_rate(self, before_hz: float, now_hz: float) -> None:
        """Take note of a rate to which the runtime says that it has switched the display."""
        if now_hz > 0:
            words = f"from {before_hz:g} Hz to {now_hz:g} Hz"
            self._become(round(SECOND_NS / now_hz), words, always=True)
            self._tells_rate = True  # and then its predictions need not be the display's

    def _rate_ns(self) -> int | None:
        display_hz = self._display_hz()
        if display_hz <= 0:
            return None
        self.source = "the display's refresh rate"
        return round(SECOND_NS / display_hz)

    def _predicted_period_ns(self) -> int | None:
        if self._predicted_ns:
            self.source = "predicted by the runtime"
        return self._stable_ns()

    def _stable_ns(self) -> int | None:
        if not self._predicted_ns:
            return None
        latest = list(self._predicted_ns)[-MEASURED:]
        period_ns = median_low(latest)
        stable = all(_is_alike(each, period_ns) for each in latest)
        return period_ns if stable and len(latest) == MEASURED else None

    def _measured_ns(self, display_ns: int | None) -> int | None:
        if self._predicted_ns:
            return None
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

    def _compare(self) -> None:
        """Tell where the predictions of most of the last frames are of another rate."""
        if self._first_predicted_ns is None:  # it need not be the display's
            self._first_predicted_ns = self._stable_ns()
        few = len(self._predicted_ns) < REMEMBERED
        if few or self._tells_rate or self._first_predicted_ns is None:
            return
        period_ns = median_low(self._predicted_ns)
        like_first = _is_alike(period_ns, self._first_predicted_ns)
        now_ns = self._fixed_ns if like_first else period_ns
        words = f"the runtime predicts a period of {period_ns / 1e6:.2f} ms"
        self._become(now_ns or period_ns, words)

    def _become(self, period_ns: int, words: str, *, always: bool = False) -> None:
        """Tell of a period that is not the one told before."""
        start_ns = self._fixed_ns or period_ns
        told_ns, self._told_ns = self._told_ns or start_ns, period_ns
        if always or not _is_alike(period_ns, told_ns):
            restored = _is_alike(period_ns, start_ns)
            name = RATE_RESTORED if restored else RATE_CHANGED
            self._notify(HeadsetEvent(name, f"{words}; {start_ns / 1e6:.2f} ms at the start"))


def _is_alike(one_ns: int, other_ns: int) -> bool:
    return abs(one_ns - other_ns) <= SAME_RATE * other_ns
