"""What ends a session, or somebody's study, and how much of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

from vrcomfort.protocol import Ask, Protocol
from vrcomfort.questionnaire import score
from vrcomfort.questionnaire.answers import Answer
from vrcomfort.respondent import Withdrew

Ends: TypeAlias = Literal["exposure", "session", "study"]

OF_THE_SESSION = "_session"
"""After the code of what ended a trial: it ended the session alone."""


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
    """Return what somebody's wish to stop, or a rule, ends."""
    return reason.ends if isinstance(reason, StopRule) else protocol.stop.participant


def trial_ending(reason: Withdrew | StopRule, protocol: Protocol) -> tuple[str, str]:
    """Return status and code of the trial in which somebody's session ends."""
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
