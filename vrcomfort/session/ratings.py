"""Ratings during exposure, and the rules that stop a participant."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from vrcomfort.protocol import Ask, Protocol, Ratings
from vrcomfort.questionnaire import Instrument, score
from vrcomfort.questionnaire.answers import Answer
from vrcomfort.respondent import Respondent, Withdrew

Ends: TypeAlias = Literal["exposure", "session", "study"]

OF_THE_SESSION = "_session"
"""Suffix of the code of a trial's end that ended the session alone."""


class StopRule(Exception):  # noqa: N818 - the protocol's decision, not an error
    """Ratings, or a score, have reached the protocol's limit.

    Attributes
    ----------
    ends
        The exposure, the session, or the participant's study.
    by
        ``rating``, ``score``, ``gaze`` (its validation) or ``practice``.
    """

    def __init__(self, reason: str, ends: Ends = "study", by: str = "rating") -> None:
        super().__init__(reason)
        self.ends = ends
        self.by = by


def ends_of(reason: Withdrew | StopRule, protocol: Protocol) -> Ends:
    """Return the scope of a participant's wish to stop, or of a rule."""
    return reason.ends if isinstance(reason, StopRule) else protocol.stop.participant


def trial_ending(reason: Withdrew | StopRule, protocol: Protocol) -> tuple[str, str]:
    """Return status and code of a trial that ends the session."""
    ends = ends_of(reason, protocol)
    by = reason.by if isinstance(reason, StopRule) else "participant"
    if ends == "exposure":
        return "completed", by
    status = "stopped" if isinstance(reason, StopRule) else "withdrawn"
    return status, by if ends == "study" else by + OF_THE_SESSION


class ScoreWatch:
    """Compares the scores after trials with those of the session's start."""

    def __init__(self, protocol: Protocol) -> None:
        self._protocol = protocol
        self._baseline: dict[tuple[str, str], float] = {}

    def hear(self, ask: Ask, answers: Mapping[str, Answer | None]) -> None:
        """Take the answers to a whole questionnaire.

        Raises
        ------
        StopRule
            If a score has risen as far as a rule allows.
        """
        for rule in self._protocol.stop.score_rise:
            if rule.instrument != ask.instrument:
                continue
            instrument = self._protocol.instrument(rule.instrument)
            found = score(instrument, answers).get(rule.scale)
            if found is None:
                continue  # too few answers
            key = rule.instrument, rule.scale
            if ask.when == "session_start":
                self._baseline[key] = found.points
            elif ask.when == "after_trial" and key in self._baseline:
                before = self._baseline[key]
                if found.points - before >= rule.by:
                    what = (
                        f"{rule.instrument} {rule.scale} rose from {before:g} to {found.points:g}"
                    )
                    raise StopRule(f"{what}; the limit is {rule.by:g}", rule.ends, "score")


LATE_S = 0.001
"""Grace period after which an unanswered question counts as missed, where no frame marks its
end."""


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
    """Asks one question at its times.

    Parameters
    ----------
    due_s
        When, since the exposure began, in the protocol's time; rising.
    """

    def __init__(
        self,
        settings: Ratings,
        instrument: Instrument,
        respondent: Respondent,
        due_s: Sequence[float],
    ) -> None:
        self.instrument = instrument
        self.due_s = tuple(due_s)
        self._settings = settings
        self._respondent = respondent
        self._asked = 0
        self._high = 0
        self._pending: _Pending | None = None

    @property
    def asking(self) -> bool:
        """Return whether the question is open."""
        return self._pending is not None

    @property
    def missed_code(self) -> int:
        """Return the code of a missed rating in the column `missed`."""
        return self._settings.missed_code

    def answer(self, elapsed_s: float, now_s: float) -> Rated | None:
        """Return the rating if it was answered or missed by now; see `RatingSchedules.update`."""
        pending = self._pending
        if pending is None:
            return None
        response = self._respondent.rating(elapsed_s)
        late = elapsed_s - pending.elapsed_s > self._settings.timeout_s
        if response is None and not late:
            return None
        self._pending = None
        latency_s = None if response is None else now_s - pending.onset_s
        return Rated(pending.onset_s, latency_s, response)

    def missed_while_frozen(self, elapsed_s: float, now_s: float, time_scale: float) -> list[Rated]:
        """Return the ratings that fell due while the picture stood still, as missed.

        Also those that fell due before, while another question was open.

        Parameters
        ----------
        elapsed_s, now_s
            At the first frame after it, as for `update`.
        time_scale
            Seconds of the protocol that each shown second stands for.
        """
        missed = []
        while (due_s := self.next_s) is not None and due_s <= elapsed_s:
            self._asked += 1
            missed.append(Rated(now_s - (elapsed_s - due_s) / time_scale, None, None))
        return missed

    @property
    def late_s(self) -> float | None:
        """Return when the open question is missed, None where none is open."""
        pending = self._pending
        return None if pending is None else pending.elapsed_s + self._settings.timeout_s + LATE_S

    @property
    def next_s(self) -> float | None:
        """Return when the next question is due, None after the last."""
        return self.due_s[self._asked] if self._asked < len(self.due_s) else None

    def ask(self, elapsed_s: float, now_s: float) -> None:
        """Ask the question that is due."""
        self._asked += 1
        self._pending = _Pending(elapsed_s, now_s)
        self._respondent.prompt(self.instrument, elapsed_s, self._settings.timeout_s)

    def close(self) -> Rated | None:
        """Return the rating that was open when the exposure ended, as missed."""
        pending, self._pending = self._pending, None
        return None if pending is None else Rated(pending.onset_s, None, None)

    def check(self, rated: Rated) -> None:
        """Raise `StopRule` after as many high ratings in a row as the protocol allows."""
        settings = self._settings
        if settings.stop_at is None or rated.response is None:
            return
        self._high = self._high + 1 if rated.response >= settings.stop_at else 0
        if self._high >= settings.stop_in_a_row:
            times = "" if self._high == 1 else f" {self._high} times in a row"
            said = f"{self.instrument.name} {rated.response} reached the limit {settings.stop_at}"
            raise StopRule(f"{said}{times}", settings.stop_ends)


class RatingSchedules:
    """All questions of an exposure, one at a time: a second one waits for the first."""

    def __init__(self, schedules: Sequence[RatingSchedule]) -> None:
        self._schedules = tuple(schedules)

    @property
    def planned(self) -> str:
        """Return in words when which question is due."""
        return "; ".join(
            f"{each.instrument.name} at {', '.join(f'{due:g}' for due in each.due_s)} s"
            for each in self._schedules
        )

    def update(self, elapsed_s: float, now_s: float) -> tuple[RatingSchedule, Rated] | None:
        """Ask the due question; return a rating that is answered or missed by now.

        Parameters
        ----------
        elapsed_s
            Since the exposure began, in the protocol's time: decides what is due and what is late.
        now_s
            The session clock: decides what is recorded.
        """
        for schedule in self._schedules:
            if schedule.asking:
                rated = schedule.answer(elapsed_s, now_s)
                return None if rated is None else (schedule, rated)
        due = [
            (each.next_s, n) for n, each in enumerate(self._schedules) if each.next_s is not None
        ]
        if due and min(due)[0] <= elapsed_s:
            self._schedules[min(due)[1]].ask(elapsed_s, now_s)
        return None

    @property
    def next_s(self) -> float:
        """Return when `update` has something to do at the latest; infinite: never again."""
        for schedule in self._schedules:
            if (late_s := schedule.late_s) is not None:
                return late_s
        due = [each.next_s for each in self._schedules if each.next_s is not None]
        return min(due, default=math.inf)

    def missed_while_frozen(
        self, elapsed_s: float, now_s: float, time_scale: float
    ) -> list[tuple[RatingSchedule, Rated]]:
        """Return the ratings of all questions that fell due unseen; see `RatingSchedule`."""
        return [
            (schedule, rated)
            for schedule in self._schedules
            for rated in schedule.missed_while_frozen(elapsed_s, now_s, time_scale)
        ]

    def close(self) -> tuple[RatingSchedule, Rated] | None:
        """Return the rating that was open when the exposure ended, as missed."""
        for schedule in self._schedules:
            if rated := schedule.close():
                return schedule, rated
        return None


def schedules_of(
    protocol: Protocol, respondent: Respondent, duration_s: float, *key: int
) -> RatingSchedules:
    """Return the schedules of an exposure, for a duration in the protocol's time.

    Parameters
    ----------
    key
        The study's seed, and what else the drawn times depend on.
    """
    return RatingSchedules(
        [
            RatingSchedule(
                each,
                protocol.rated(each),
                respondent,
                each.due_times(duration_s, np.random.default_rng((*key, index))),
            )
            for index, each in enumerate(protocol.ratings)
        ]
    )
