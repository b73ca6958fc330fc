"""An operator who follows a script."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from vrcomfort.operator_interface import Command, OperatorStep, SessionOrder


@dataclass(frozen=True)
class Wanted:
    """One action in a kind of step, after so many looks at it; `step` None is the one under way."""

    kind: str
    action: str
    text: str = ""
    after: int = 3
    number: int | None = None
    value: float | None = None


def Given(  # noqa: N802 - reads like the class that it makes
    action: str, step: int, operator: str, text: str, value: float | None = None
) -> Command:
    """Return a command as a session gets it."""
    return Command("", action, step, text, value, operator)


@dataclass
class ScriptedDesk:
    """Does one thing after the other, each in the first step of its kind that comes."""

    script: Sequence[Wanted] = ()
    starts_sessions: bool = False
    steps: list[OperatorStep] = field(default_factory=list)
    replies: list[tuple[str, str]] = field(default_factory=list)
    ratings: list[tuple[float, float | None]] = field(default_factory=list)
    seen: list[Any] = field(default_factory=list)
    asked: list[bool] = field(default_factory=list)
    order: SessionOrder | None = None
    done: int = 0
    looks: int = 0

    def open(self, order: SessionOrder) -> None:
        self.order = order

    def begin(self, step: OperatorStep) -> None:
        self.steps.append(step)
        self.looks = 0

    def see(self, frame: Any, rendered: Any, trial: Any) -> None:
        assert (rendered is None) == frame.paused
        self.seen.append((frame, trial.frames, trial.frozen_so_far_s))

    def rated(self, instrument: str, elapsed_s: float, response: float | None) -> None:
        assert instrument == "fms"
        self.ratings.append((elapsed_s, response))

    def next_command(self) -> Command | None:
        self.looks += 1
        if self.done == len(self.script):
            return None
        step, wanted = self.steps[-1], self.script[self.done]
        if step.kind != wanted.kind or self.looks <= wanted.after:
            return None
        self.done += 1
        self.looks = 0
        number = step.number if wanted.number is None else wanted.number
        return Given(wanted.action, number, "A", wanted.text, wanted.value)

    def reply(self, command: Command, refusal: str) -> None:
        self.replies.append((command.action, refusal))

    def ask_whether_to_withdraw(self, *, asked: bool) -> None:
        self.asked.append(asked)

    def ask(self, question: Any) -> None:
        pass
