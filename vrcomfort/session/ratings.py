"""Ratings during exposure: when they are due, answered or missed, and when they say stop."""

from __future__ import annotations

from dataclasses import dataclass

from vrcomfort.protocol import Ratings
from vrcomfort.questionnaire import INSTRUMENTS
from vrcomfort.respondent import Respondent


class StopRule(Exception):  # noqa: N818 - the protocol's decision, not an error
    """A rating has reached the protocol's limit."""


@dataclass(frozen=True)
class Rated:
    """One rating; times are seconds since the exposure began, `response` None where missed."""

    onset_s: float
    latency_s: float | None
    response: int | None


class RatingSchedule:
    """Asks every `every_s` seconds, as long as the time to answer lies within the exposure."""

    def __init__(self, settings: Ratings, respondent: Respondent, duration_s: float) -> None:
        self.instrument = INSTRUMENTS[settings.instrument]
        self._settings = settings
        self._respondent = respondent
        self._duration_s = duration_s
        self._asked = 0
        self._pending_since_s: float | None = None

    def update(self, elapsed_s: float) -> Rated | None:
        """Ask if a rating is due; return one that was answered or missed by now."""
        settings, onset_s = self._settings, self._pending_since_s
        if onset_s is None:
            self._prompt_if_due(elapsed_s)
            return None
        response = self._respondent.rating(elapsed_s)
        late = elapsed_s - onset_s > settings.timeout_s
        if response is None and not late:
            return None
        self._pending_since_s = None
        return Rated(onset_s, None if response is None else elapsed_s - onset_s, response)

    def _prompt_if_due(self, elapsed_s: float) -> None:
        due_s = self._settings.every_s * (self._asked + 1)
        if due_s <= elapsed_s <= self._duration_s - self._settings.timeout_s:
            self._asked += 1
            self._pending_since_s = elapsed_s
            self._respondent.prompt(self.instrument, elapsed_s, self._settings.timeout_s)

    def close(self) -> Rated | None:
        """Return the rating that was open when the exposure ended, as missed."""
        onset_s, self._pending_since_s = self._pending_since_s, None
        return None if onset_s is None else Rated(onset_s, None, None)

    def check(self, rated: Rated) -> None:
        """Raise `StopRule` where the rating is as high as the protocol allows."""
        limit = self._settings.stop_at
        if limit is not None and rated.response is not None and rated.response >= limit:
            raise StopRule(f"{self.instrument.name} {rated.response} reached the limit {limit}")
