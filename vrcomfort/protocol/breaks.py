"""Breaks between exposures that last as long as participants want, within limits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from vrcomfort.settings import Problem, Settings

Duration = Annotated[float, Field(ge=0, le=86_400)]


class Breaks(Settings):
    """A break is over when the participant, or the experimenter, goes on."""

    min_s: Duration = 0.0
    """Nobody goes on sooner, but for the experimenter, which is recorded."""
    max_s: Duration | None = None
    """After it the experimenter is told, which is recorded; the break goes on."""
    after_trials: tuple[Annotated[int, Field(ge=1, le=1000)], ...] = ()
    """Numbers of the trials of a session after which there is one; without it, after each but the
    last."""

    def is_due(self, trial: int) -> bool:
        """Return whether there is one after a trial."""
        return not self.after_trials or trial in self.after_trials


def break_problems(breaks: Breaks | None, break_s: float) -> Iterator[Problem]:
    """Yield what is wrong with [breaks]."""
    if breaks is None:
        return
    if break_s:
        message = "`break_s` is a rest of a fixed length, and [breaks] say how long theirs are"
        yield Problem(("break_s",), f"{message}; remove one of the two")
    if breaks.max_s is not None and breaks.max_s < breaks.min_s:
        yield Problem(("breaks", "max_s"), "`max_s` is less than `min_s`; make it longer")
