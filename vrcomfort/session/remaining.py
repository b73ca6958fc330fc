"""Estimates the remaining time of a session: the plan, corrected by the steps so far."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

from vrcomfort.protocol.timeline import PlannedStep, StepKind

_BELIEVED_S = 60.0
"""So much planned time of a kind of step is believed as much as what its steps have taken."""


class SessionTime:
    """Follows a session through its planned steps.

    Each kind of step has a factor, which begins at 1: the time that its steps have taken over the
    time that was planned for them, where `_BELIEVED_S` of the plan count as taken. A pause is in
    none of them, and neither is a step that an operator has ended.

    Parameters
    ----------
    steps
        In their order.
    now_s
        Returns the session clock.
    """

    def __init__(self, steps: Sequence[PlannedStep], now_s: Callable[[], float]) -> None:
        self._steps, self._now_s = tuple(steps), now_s
        self._at = -1
        self._current: PlannedStep | None = None
        self._planned_s: defaultdict[StepKind, float] = defaultdict(float)
        self._taken_s: defaultdict[StepKind, float] = defaultdict(float)
        self._began_s = self._paused_s = 0.0
        self._pause_began_s: float | None = None
        self._share: float | None = None

    def begin(
        self, kind: StepKind, words: str, *, again: bool = False, cut_short: bool = False
    ) -> None:
        """Take note that a step begins.

        Parameters
        ----------
        again
            It is the one before, once more.
        cut_short
            An operator has ended the one before: how long it took says nothing of others.
        """
        self.end_pause()
        if not cut_short:
            self._learn()
        self._began_s, self._paused_s, self._share = self._now_s(), 0.0, None
        if again and self._current is not None:
            return
        index = self._next(kind, words)
        self._current = None if index is None else self._steps[index]
        self._at = self._at if index is None else index

    def come(self, share: float) -> None:
        """Take note of how much of the step is done, 0 to 1."""
        self._share = share

    def pause(self) -> None:
        """Stop to count the step's time."""
        if self._pause_began_s is None:
            self._pause_began_s = self._now_s()

    def end_pause(self) -> None:
        """Go on."""
        began_s, self._pause_began_s = self._pause_began_s, None
        if began_s is not None:
            self._paused_s += self._now_s() - began_s

    @property
    def position(self) -> int:
        """Return the number of planned steps that have begun, or were passed over."""
        return self._at + 1

    def remaining_s(self) -> float:
        """Return the time that is expected to be left."""
        later_s = sum(self._expected_s(step) for step in self._steps[self._at + 1 :])
        if self._current is None:
            return later_s
        expected_s = self._expected_s(self._current)
        if self._share is not None:
            return later_s + expected_s * (1 - self._share)
        return later_s + max(expected_s - self._elapsed_s(), 0.0)

    def _next(self, kind: StepKind, words: str) -> int | None:
        """Return which step begins: none where it is not planned before the next exposure."""
        for index in range(self._at + 1, len(self._steps)):
            step = self._steps[index]
            if step.kind == kind and words.startswith(step.words):
                return index
            if step.kind == "exposure":
                return None
        return None

    def _learn(self) -> None:
        if self._current is not None:
            self._planned_s[self._current.kind] += self._current.planned_s
            self._taken_s[self._current.kind] += self._elapsed_s()

    def _elapsed_s(self) -> float:
        paused_s, began_s = self._paused_s, self._pause_began_s
        now_s = self._now_s() if began_s is None else began_s
        return now_s - self._began_s - paused_s

    def _expected_s(self, step: PlannedStep) -> float:
        taken_s = self._taken_s[step.kind] + _BELIEVED_S
        return step.planned_s * taken_s / (self._planned_s[step.kind] + _BELIEVED_S)
