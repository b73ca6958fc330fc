"""What the times of frames are worth, and how regularly they come."""

from __future__ import annotations

import time
from dataclasses import dataclass
from enum import StrEnum

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import DROPPED_INTERVAL_PERIODS
from vrcomfort.headset.base import Headset

SIMULATORS = ("simulat", "emulat", "remote hmd", "qwerty", "null", "dummy")
"""Words in the names of runtimes and headsets that show nothing to anybody."""


class TimingTrust(StrEnum):
    """What the times of frames are worth, from nothing upwards.

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
    """Show two still images for a time and count; None where nobody saw two frames."""
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
