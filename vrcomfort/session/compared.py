"""Which exposures a question compares, and after which trials it is asked."""

from __future__ import annotations

from vrcomfort.errors import InputError
from vrcomfort.protocol import Ask, Sequence
from vrcomfort.session.event_log import TrialPlace


def is_due(ask: Ask, place: TrialPlace) -> bool:
    """Return whether a questionnaire of this moment is asked: a pair's, after its second one."""
    return ask.compares != "pair" or (place.trial or 0) % 2 == 0


def compared(ask: Ask, sequence: Sequence, session: int, place: TrialPlace) -> tuple[str, ...]:
    """Return the conditions that answers 1, 2, … mean, as the participant has met them.

    Raises
    ------
    InputError
        If a pair is twice the same condition.
    """
    if ask.compares is None:
        return ()
    trials = sequence.sessions[session - 1]
    if ask.compares == "pair":
        last = place.trial or 0
        pair = tuple(trial.condition for trial in trials[last - 2 : last])
        if pair[0] == pair[1]:
            message = f"exposures {last - 1} and {last} of session {session} in order"
            raise InputError(
                f"{message} `{sequence.name}` are both in condition `{pair[0]}`, and "
                f"`{ask.instrument}` asks which of a pair; let pairs differ"
            )
        return pair
    before = sequence.sessions[: session - 1] if ask.compares == "study" else ()
    met = [trial.condition for each in (*before, trials) for trial in each]
    return tuple(dict.fromkeys(met))
