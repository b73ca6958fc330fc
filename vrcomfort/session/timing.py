"""How regularly the frames of a trial came, and what they cost."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

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


@dataclass
class TrialTiming:
    """The frames of one trial so far."""

    frames: int = 0
    dropped: int = 0
    intervals: Durations = field(default_factory=Durations)
    cpu: Durations = field(default_factory=Durations)
    gpu: Durations = field(default_factory=Durations)

    @property
    def dropped_percent(self) -> float | None:
        """Return the share of dropped frames, None without frames."""
        return round(100 * self.dropped / self.frames, 2) if self.frames else None

    def summary(self) -> dict[str, Any]:
        """Return medians and tails, named as the columns of ``timing.csv``."""
        parts = {"interval": self.intervals, "cpu": self.cpu, "gpu": self.gpu}
        return {k: v for name, part in parts.items() for k, v in part.summary(name).items()}


def timing_row(trial: TrialRow, timing: TrialTiming, limit_percent: float) -> TimingRow:
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
        flagged=int(percent is not None and percent > limit_percent),
    )
