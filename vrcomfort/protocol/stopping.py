"""What ends more than an exposure, and how much of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from vrcomfort.questionnaire import Instrument
from vrcomfort.settings import Problem, Settings, did_you_mean


class ScoreRise(Settings):
    """A score that has risen too far over that of the session's start."""

    instrument: str = "ssq"
    """Asked at the session's start and after exposures."""
    scale: str = "T"
    """Of the instrument."""
    by: Annotated[float, Field(gt=0, le=1e6)]
    """So much over the first score of the session, after a trial, ends what `ends` says."""
    ends: Literal["session", "study"] = "session"
    """`session`: the participant may come back for the next. `study`: the participant's study."""


class Stopping(Settings):
    """Who and what ends a session, or somebody's study; [[ratings]] have rules of their own."""

    participant: Literal["session", "study"] = "study"
    """What a participant's wish to stop ends; after `session` they may come back for the next."""
    score_rise: tuple[ScoreRise, ...] = ()
    """Rules on scores of questionnaires."""


def rise_problems(
    stop: Stopping, whens: Mapping[str, set[str]], instruments: Mapping[str, Instrument]
) -> list[Problem]:
    """Return what is wrong with rules on scores.

    Parameters
    ----------
    whens
        Instrument → when it is asked.
    """
    found: list[Problem] = []
    for index, rule in enumerate(stop.score_rise):
        path = ("stop", "score_rise", index)
        asked = whens.get(rule.instrument, set())
        if not {"session_start", "after_trial"} <= asked:
            message = f"`{rule.instrument}` is not asked both at session_start and after_trial"
            found.append(Problem((*path, "instrument"), f"{message}; ask it in [[questionnaires]]"))
            continue
        scales = [scale.name for scale in instruments[rule.instrument].scales]
        if rule.scale not in scales:
            message = f"the {instruments[rule.instrument].short} has no scale `{rule.scale}`"
            hint = did_you_mean(rule.scale, scales)
            found.append(Problem((*path, "scale"), f"{message}; {hint}"))
    return found
