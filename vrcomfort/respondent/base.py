"""The interface of respondents, and the forms that they answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vrcomfort.questionnaire import Instrument


class Withdrew(Exception):  # noqa: N818 - a decision of the participant, not an error
    """The participant wants to stop; the message is the note that is kept."""


@dataclass(frozen=True)
class Exposure:
    """The facts of an exposure that is about to begin.

    Parameters
    ----------
    duration_s
        The protocol's duration. Shortened demonstrations pass their time stretched to it.
    """

    session: int
    trial: int
    scene: str
    condition: str
    duration_s: float


@dataclass(frozen=True)
class Form:
    """A questionnaire at a moment of the session.

    Parameters
    ----------
    after_withdrawal
        True where the participant has just stopped an exposure and may well refuse.
    compared
        Conditions that the answers 1, 2, … mean, as the participant has met them; none where the
        answers mean something else.
    """

    instrument: Instrument
    timepoint: str
    after_withdrawal: bool = False
    compared: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class InstructionContent:
    """The content of an instruction: words, a picture, a sound.

    Parameters
    ----------
    text
        Words to read; blank where there are none.
    picture
        (height, width, 4) pixels to look at, or None.
    sound_s
        Length of the sound that plays meanwhile; None where none does.
    away
        The headset may be taken off.
    """

    name: str
    text: str = ""
    picture: NDArray[np.uint8] | None = None
    sound_s: float | None = None
    away: bool = False


Heard: TypeAlias = Callable[[str, int | None, float], None]
"""Takes (item, response, seconds it took) as soon as an answer is given; a correction of an
earlier answer is given as a further call. None is "rather not say"."""


class Written(NamedTuple):
    """An answer in one's own words, and the seconds it took; blank where nothing was said."""

    text: str
    took_s: float


class Respondent(Protocol):
    """A participant, real or simulated. All times are seconds since the exposure began."""

    @property
    def name(self) -> str:
        """Return the kind of respondent for the manifest."""

    def start_session(self, session: int) -> None:
        """Take note that a session begins (counted from 1)."""

    def start_exposure(self, exposure: Exposure) -> None:
        """Take note that an exposure begins."""

    def update(self, elapsed_s: float) -> None:
        """Live through the training or exposure up to now; called every frame.

        Raises
        ------
        Withdrew
            If the participant stops here.
        """

    def end_exposure(self, elapsed_s: float) -> None:
        """Take note that the exposure is over."""

    def prompt(self, instrument: Instrument, elapsed_s: float, timeout_s: float) -> None:
        """Ask for a rating during exposure, without waiting for it."""

    def rating(self, elapsed_s: float) -> int | None:
        """Return the rating if it has been given by now; called every frame after `prompt`."""

    def resting(self, left_s: float) -> bool:
        """Live through a moment of a rest; return True if that took its time (a frame passed).

        Raises
        ------
        Withdrew
            If the participant stops here.
        """

    def rest(self, duration_s: float) -> None:
        """Take note that a rest is over.

        Raises
        ------
        Withdrew
            If the participant stops here.
        """

    def read(
        self, content: InstructionContent, elapsed_s: float, *, may_go_on: bool
    ) -> float | None:
        """Live through a moment of an instruction.

        Returns
        -------
        float or None
            For how many seconds nothing comes of it (0: a frame has passed, which took its time);
            None where the participant goes on.

        Raises
        ------
        Withdrew
            If the participant stops here.
        """

    def leave(self) -> None:
        """Take note that an instruction is over."""

    def ask(self, form: Form, heard: Heard) -> None:
        """Answer every item in the order of the instrument.

        Raises
        ------
        Withdrew
            If the participant stops at a question; what was heard before is kept.
        """

    def write(self, question: str) -> Written:
        """Answer a question in one's own words.

        Raises
        ------
        Withdrew
            If the participant stops at it.
        """

    def decide(self, question: str) -> bool:
        """Ask the experimenter; return whether the session goes on."""
