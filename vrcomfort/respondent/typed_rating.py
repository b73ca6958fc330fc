"""A rating during exposure that somebody types, in time or not."""

from __future__ import annotations

from vrcomfort.questionnaire import Instrument


class TypedRating:
    """The rating that is asked for, until it is given or its time is over.

    Parameters
    ----------
    instrument
        The scale; None while nothing is asked.
    until_s
        When the time is over, in seconds since the exposure began.
    """

    def __init__(self, instrument: Instrument | None = None, until_s: float = 0.0) -> None:
        self._instrument = instrument
        self._until_s = until_s
        self.response: int | None = None

    def close(self) -> None:
        """End the time to answer, with the exposure."""
        self._until_s = -1.0

    def take(self, line: str, elapsed_s: float) -> str:
        """Take a line; return what to say of one that is not recorded, else nothing."""
        scale = self._instrument
        if scale is None:
            return f"{line!r} was not recorded: nothing was asked"
        if self.response is not None:
            return f"{line!r} was not recorded: {self.response} was given before"
        if elapsed_s > self._until_s:
            return self.too_late(line)
        answers = scale.items[0].answers
        if not (line.isdecimal() and answers.offers(int(line))):
            return f"{line!r} was not recorded: {answers.asked_in_words} is a rating"
        self.response = int(line)
        return ""

    def too_late(self, line: str) -> str:
        """Return what to say of a line that nobody waits for any more."""
        return f"{line!r} came too late and was not recorded"
