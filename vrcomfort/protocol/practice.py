"""Practice: exposures that are no trials of the study, until they go well enough."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.protocol.conditions import Seconds
from vrcomfort.protocol.order import Trial
from vrcomfort.settings import Settings, Word

Count = Annotated[int, Field(ge=1, le=100)]


class Practice(Settings):
    """A block of practice, before a trial. It is in `practice.csv`, and in no other analysis."""

    name: Word
    """As `practice.csv` has it."""
    before_trial: Annotated[int, Field(ge=1, le=1000)] = 1
    """Number of the trial, within the session, that it comes before."""
    sessions: tuple[Annotated[int, Field(ge=1, le=1000)], ...] = ()
    """Numbers of the sessions that have it; without it, all."""
    trials: tuple[Trial, ...] = ()
    """What is shown, in this order."""
    draw: Count | None = None
    """Instead of `trials`: so many of the session's own, drawn with the study's seed."""
    exposure_s: Seconds | None = None
    """How long each is shown; without it, as long as in the study."""
    score_at_least: Annotated[float, Field(ge=-1e6, le=1e6)] | None = None
    """The criterion: mean score of the block's tasks (docs/tasks.md)."""
    hits_at_least: Annotated[int, Field(ge=1, le=100_000)] | None = None
    """The criterion: hits of the block's tasks, added up."""
    at_most: Count = 1
    """The block is repeated until its criterion is met, so many times in all."""
    otherwise: Literal["go_on", "session", "study"] = "go_on"
    """Where it is still not met: the trial comes, or the session, or the participant's study,
    ends."""

    def is_due(self, session: int, trial: int) -> bool:
        """Return whether it comes before a trial."""
        return trial == self.before_trial and (not self.sessions or session in self.sessions)

    @property
    def has_criterion(self) -> bool:
        """Return whether anything must be reached."""
        return self.score_at_least is not None or self.hits_at_least is not None

    def met(self, scores: list[float], hits: int) -> bool | None:
        """Return whether a block was good enough; None without a criterion.

        Parameters
        ----------
        scores
            Of its tasks, as far as they have one.
        hits
            Of all of them.
        """
        if not self.has_criterion:
            return None
        if self.hits_at_least is not None and hits < self.hits_at_least:
            return False
        wanted = self.score_at_least
        return wanted is None or (bool(scores) and sum(scores) / len(scores) >= wanted)
