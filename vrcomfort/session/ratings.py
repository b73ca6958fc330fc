"""Ratings during exposure: when they are due, answered or missed, and when they say stop."""

from __future__ import annotations

from dataclasses import dataclass

from vrcomfort.protocol import Ratings
from vrcomfort.questionnaire import Instrument
from vrcomfort.respondent import Respondent


class StopRule(Exception):  # noqa: N818 - the protocol's decision, not an error
    """A rating has reached the protocol's limit."""


@dataclass(frozen=True)
class Rated:
    """One rating; times are the session clock's, `response` is None where it was missed."""

    onset_s: float
    latency_s: float | None
    response: int | None


@dataclass(frozen=True)
class _Pending:
    """A question that is open: when it was asked, in the protocol's time and the session's."""

    elapsed_s: float
    onset_s: float


class RatingSchedule:
    """Asks every `every_s` seconds, as long as the time to answer lies within the exposure."""

    def __init__(
        self,
        settings: Ratings,
        instrument: Instrument,
        respondent: Respondent,
        duration_s: float,
    ) -> None:
        self.instrument = instrument
        self._settings = settings
        self._respondent = respondent
        self._duration_s = duration_s
        self._asked = 0
        self._pending: _Pending | None = None

    def update(self, elapsed_s: float, now_s: float) -> Rated | None:
        """Ask if a rating is due; return one that was answered or missed by now.

        Parameters
        ----------
        elapsed_s
            Since the exposure began, in the protocol's time: decides what is due and what is late.
        now_s
            The session clock: decides what is recorded.
        """
        pending = self._pending
        if pending is None:
            self._prompt_if_due(elapsed_s, now_s)
            return None
        response = self._respondent.rating(elapsed_s)
        late = elapsed_s - pending.elapsed_s > self._settings.timeout_s
        if response is None and not late:
            return None
        self._pending = None
        latency_s = None if response is None else now_s - pending.onset_s
        return Rated(pending.onset_s, latency_s, response)

    def missed_while_frozen(self, elapsed_s: float, now_s: float, stretch: float) -> list[Rated]:
        """Return the ratings that are due after the picture stood still: nobody was asked.

        Also those that fell due before, while another question was open.

        Parameters
        ----------
        elapsed_s, now_s
            At the first frame after it, as for `update`.
        stretch
            Seconds of the protocol that each shown second stands for.
        """
        missed = []
        last_s = min(elapsed_s, self._duration_s - self._settings.timeout_s)
        while (due_s := self._due_s()) <= last_s:
            self._asked += 1
            missed.append(Rated(now_s - (elapsed_s - due_s) / stretch, None, None))
        return missed

    def _due_s(self) -> float:
        return self._settings.every_s * (self._asked + 1)

    def _prompt_if_due(self, elapsed_s: float, now_s: float) -> None:
        if self._due_s() <= elapsed_s <= self._duration_s - self._settings.timeout_s:
            self._asked += 1
            self._pending = _Pending(elapsed_s, now_s)
            self._respondent.prompt(self.instrument, elapsed_s, self._settings.timeout_s)

    def close(self) -> Rated | None:
        """Return the rating that was open when the exposure ended, as missed."""
        pending, self._pending = self._pending, None
        return None if pending is None else Rated(pending.onset_s, None, None)

    def check(self, rated: Rated) -> None:
        """Raise `StopRule` where the rating is as high as the protocol allows."""
        limit = self._settings.stop_at
        if limit is not None and rated.response is not None and rated.response >= limit:
            raise StopRule(f"{self.instrument.name} {rated.response} reached the limit {limit}")
