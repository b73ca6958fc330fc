"""How regularly the frames of a trial came, and what they cost."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from vrcomfort.frame import DROPPED_INTERVAL_PERIODS, Frame
from vrcomfort.records import TimingRow, TrialRow

STEP_MS = 0.01
"""Times are counted in steps of this: exact enough, and never more memory for a longer trial."""


class Durations:
    """Counts times, and knows how long most of them were."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()

    def add(self, time_ms: float) -> None:
        """Count a time."""
        self._counts[round(time_ms / STEP_MS)] += 1

    def percentile_ms(self, percent: float) -> float | None:
        """Return the smallest time that `percent` of all do not exceed; None without any."""
        left = math.ceil(percent / 100 * self._counts.total())
        for step in sorted(self._counts):
            left -= self._counts[step]
            if left <= 0:
                return round(step * STEP_MS, 2)
        return None

    def summary(self, name: str) -> dict[str, float | None]:
        """Return median and tail, named as the columns of ``timing.csv``."""
        return {
            f"{name}_median_ms": self.percentile_ms(50),
            f"{name}_p95_ms": self.percentile_ms(95),
            f"{name}_p99_ms": self.percentile_ms(99),
        }


def seen_between_ns(before: Frame, frame: Frame) -> int:
    """Return how much of the time between two frames something was seen, and so is exposure.

    Where poses jump (a cut of a trace, another place), the frame before was seen for its period.
    """
    passed_ns = frame.predicted_display_time_ns - before.predicted_display_time_ns
    if not frame.discontinuity:
        return passed_ns
    return min(passed_ns, before.period_ns) if passed_ns > 0 else before.period_ns


@dataclass
class SeenTime:
    """What a participant saw in the seconds of a trial: their sum is the trial's length.

    Parameters
    ----------
    live_s
        A frame was shown for its period.
    frozen_s
        A frame stood for longer: refreshes passed without a new one.
    hidden_s
        Nothing was seen: the headset was taken off or asleep, or the runtime wanted no picture.
    unfocused_s
        The frame was shown, and something of the runtime's had the input.
    """

    live_s: float = 0.0
    frozen_s: float = 0.0
    hidden_s: float = 0.0
    unfocused_s: float = 0.0
    _frame: Frame | None = None
    """The last frame, whose time is not over."""

    def add(self, frame: Frame) -> None:
        """Close the time of the frame before."""
        before, self._frame = self._frame, frame
        if before is None:
            return
        passed_ns = frame.predicted_display_time_ns - before.predicted_display_time_ns
        if before.seen:
            seen_ns = seen_between_ns(before, frame)
            self.hidden_s += max(passed_ns - seen_ns, 0) / 1e9
            passed_ns = seen_ns
        self._count(before, passed_ns)

    def end(self) -> None:
        """Give the last frame its period."""
        if self._frame is not None:
            self._count(self._frame, self._frame.period_ns)
            self._frame = None

    def _count(self, frame: Frame, passed_ns: int) -> None:
        if not frame.seen:
            self.hidden_s += passed_ns / 1e9
            return
        late = passed_ns > DROPPED_INTERVAL_PERIODS * frame.period_ns
        shown_ns = frame.period_ns if late else passed_ns
        self.frozen_s += (passed_ns - shown_ns) / 1e9
        if frame.unfocused:
            self.unfocused_s += shown_ns / 1e9
        else:
            self.live_s += shown_ns / 1e9

    @property
    def frozen_percent(self) -> float:
        """Return the frozen share of the time in which something was seen."""
        seen_s = self.live_s + self.frozen_s + self.unfocused_s
        return round(100 * self.frozen_s / seen_s, 2) if seen_s else 0.0

    def cells(self) -> dict[str, Any]:
        """Return the seconds, named as the columns of ``trials.csv``."""
        names = ("live_s", "frozen_s", "hidden_s", "unfocused_s")
        return {name: round(getattr(self, name), 9) for name in names}


@dataclass
class TrialTiming:
    """The frames of one trial so far."""

    frames: int = 0
    dropped: int = 0
    missed_refreshes: int = 0
    untracked: int = 0
    """Frames whose head pose the headset had not measured."""
    seen: SeenTime = field(default_factory=SeenTime)
    intervals: Durations = field(default_factory=Durations)
    cpu: Durations = field(default_factory=Durations)
    gpu: Durations = field(default_factory=Durations)

    @property
    def frozen_so_far_s(self) -> float:
        """Return for how long the picture stood still."""
        return self.seen.frozen_s

    @property
    def dropped_percent(self) -> float | None:
        """Return the share of dropped frames, None without frames."""
        return round(100 * self.dropped / self.frames, 2) if self.frames else None

    def summary(self) -> dict[str, Any]:
        """Return medians and tails, named as the columns of ``timing.csv``."""
        parts = {"interval": self.intervals, "cpu": self.cpu, "gpu": self.gpu}
        return {k: v for name, part in parts.items() for k, v in part.summary(name).items()}


def missed_refreshes(passed_ns: int, period_ns: int) -> int:
    """Return how many refreshes passed between two frames without a new one."""
    late = passed_ns > DROPPED_INTERVAL_PERIODS * period_ns
    return max(round(passed_ns / period_ns) - 1, 1) if late else 0


def trial_flags(timing: TrialTiming, limit_percent: float) -> list[str]:
    """Say what an analyst should know of a trial, a clause each; nothing where all was well.

    Parameters
    ----------
    limit_percent
        How many per cent of the frames may be dropped, and of the time frozen.
    """
    flags, seen = [], timing.seen
    if (timing.dropped_percent or 0) > limit_percent:
        flags.append(f"{timing.dropped_percent:g} % of {timing.frames} frames dropped")
    if seen.frozen_percent > limit_percent:
        frozen = f"the picture stood still for {seen.frozen_s:.2f} s, {seen.frozen_percent:g} %"
        flags.append(f"{frozen} of the time, and was live for {seen.live_s:.2f} s")
    if flags:
        flags.append(f"the limit is {limit_percent:g} %")
    if 2 * timing.untracked > timing.frames:
        flags.append(f"the head was not tracked in {timing.untracked} of {timing.frames} frames")
    if seen.unfocused_s:
        text = f"a menu of the runtime's was in front for {seen.unfocused_s:.2f} s"
        flags.append(f"{text}: the participant saw it, and could not stop")
    return flags


def timing_row(trial: TrialRow, timing: TrialTiming, flags: Sequence[str]) -> TimingRow:
    """Return a trial's row of ``timing.csv``."""
    percent = timing.dropped_percent
    return TimingRow(
        participant=trial.participant,
        session=trial.session,
        trial=trial.trial,
        condition=trial.condition,
        attempt=trial.attempt,
        frames=timing.frames,
        dropped=timing.dropped,
        dropped_percent=percent,
        **timing.summary(),
        flagged=int(bool(flags)),
    )
