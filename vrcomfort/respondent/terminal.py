"""Answers that the experimenter asks for aloud and types, as in Carnegie & Rhee (2015)."""

from __future__ import annotations

import time
from collections.abc import Callable

from rich.console import Console
from rich.table import Table

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import Answers, Instrument
from vrcomfort.respondent import keyboard
from vrcomfort.respondent.base import Exposure, Form, Heard, InstructionContent, Withdrew, Written
from vrcomfort.respondent.keyboard import input_over, waiting_line

_KEYS = f"number = answer, {keyboard.HELP}"
_STOP = f"{keyboard.STOP} + Enter = withdraw"
_YES_OR_NO = {keyboard.YES: True, "yes": True, keyboard.NO: False, "no": False}
_LOOKS_EVERY_S = 0.05
"""Interval at which typed lines are read during an instruction."""


class TerminalRespondent:
    """A person in the headset, and an experimenter at the keyboard.

    Parameters
    ----------
    console
        Prints text as it is, without markup.
    read_line
        Shows a prompt and returns what was typed; raises `EOFError` at the end of input.
    waiting_line
        Returns a line typed during exposure, or None, without waiting.
    """

    name = "terminal"

    def __init__(
        self,
        console: Console,
        *,
        read_line: Callable[[str], str] = input,
        waiting_line: Callable[[], str | None] = waiting_line,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._console = console
        self._read_line = read_line
        self._waiting_line = waiting_line
        self._now_s = now_s
        self._rating = TypedRating()
        self._asked_whether_to_stop = False
        self._exposed = False
        self._told: InstructionContent | None = None

    def start_session(self, session: int) -> None:
        """Say which session begins, and how to end it."""
        self._console.rule(f"Session {session}")
        self._console.print(f"{_STOP}, at any time.")

    def start_exposure(self, exposure: Exposure) -> None:
        """Print the scene and how to stop it, without the condition: the room may hear."""
        self._rating = TypedRating()
        self._finish_asking_whether_to_stop()
        self._console.print(f"Exposure {exposure.trial}, {exposure.scene}. {_STOP}.")

    def update(self, elapsed_s: float) -> None:
        """Take typed lines: a withdrawal, or the present rating.

        Raises
        ------
        Withdrew
            If the participant stops, and that was typed twice.
        """
        line = (self._waiting_line() or "").strip().lower()
        if line and not self._stops(line, "withdrew during exposure"):
            self._tell(self._rating.take(line, elapsed_s))

    def end_exposure(self, elapsed_s: float) -> None:
        """Say that it is over."""
        self._rating.close()
        self._exposed = True
        self._console.print(f"Exposure over after {elapsed_s:.0f} s.")

    def prompt(self, instrument: Instrument, elapsed_s: float, timeout_s: float) -> None:
        """Show the question; the answer is picked up by `update`."""
        self._rating = TypedRating(instrument, elapsed_s + timeout_s)
        self._console.print(f"{instrument.instruction} ({timeout_s:.0f} s)", style="bold")

    def rating(self, elapsed_s: float) -> int | None:  # noqa: ARG002
        """Return the rating that has been typed since `prompt`."""
        return self._rating.response

    def resting(self, left_s: float) -> bool:  # noqa: ARG002 - the bar shows it
        """Take typed lines: a withdrawal."""
        self._clear_typed()
        return False

    def rest(self, duration_s: float) -> None:
        """Say that the rest is over.

        Raises
        ------
        Withdrew
            If the participant wanted to stop, and that is confirmed now.
        """
        self._finish_asking_whether_to_stop()
        self._console.print(f"{duration_s / 60:.1f} minutes of rest are over.")

    def read(
        self,
        content: InstructionContent,
        elapsed_s: float,  # noqa: ARG002
        *,
        may_go_on: bool,
    ) -> float | None:
        """Print an instruction, to be read aloud; Enter goes on.

        Raises
        ------
        Withdrew
            If the participant stops, and that was typed twice.
        InputError
            If nothing can be typed any more.
        """
        if self._told is not content:
            self._told = content
            self._console.rule(content.name)
            self._console.print(content.text or "(nothing to read)")
            self._console.print(f"Enter = go on. {_STOP}.", style="dim")
        typed = self._waiting_line()
        if typed is None:
            if may_go_on and input_over():
                message = "the input ended before anybody went on; what was recorded is kept"
                raise InputError(message)
            return _LOOKS_EVERY_S
        line = typed.strip().lower()
        if line and self._stops(line, "withdrew between exposures"):
            return _LOOKS_EVERY_S
        if not may_go_on:
            self._tell("It cannot go on yet.")
        return None if may_go_on and not line else _LOOKS_EVERY_S

    def leave(self) -> None:
        """Wait for the confirmation of a withdrawal.

        Raises
        ------
        Withdrew
            If that is confirmed.
        """
        self._told = None
        self._finish_asking_whether_to_stop()

    def _clear_typed(self) -> None:
        """Take lines typed before the question was there: a late rating is no answer to it."""
        while (typed := self._waiting_line()) is not None:
            line = typed.strip().lower()
            if line and not self._stops(line, "withdrew between exposures"):
                self._tell(self._rating.too_late(line))

    def _tell(self, remark: str) -> None:
        if remark:
            self._console.print(remark, style="red")

    def _stops(self, line: str, note: str) -> bool:
        """Return whether a line is about stopping; a wish to is asked once more.

        Raises
        ------
        Withdrew
            Where it is confirmed.
        """
        asked, self._asked_whether_to_stop = self._asked_whether_to_stop, line == keyboard.STOP
        if self._asked_whether_to_stop:
            self._console.print(keyboard.SURE, style="bold")
            return True
        if asked and line in {keyboard.YES, "yes"}:
            raise Withdrew(note)
        if asked:
            self._console.print("The session continues.")
        return asked and line in {keyboard.NO, "no"}

    def _finish_asking_whether_to_stop(self) -> None:
        """Wait for the answer, where a step ends before it has come."""
        if self._asked_whether_to_stop:
            self._asked_whether_to_stop = False
            self._stop_if_sure()

    def ask(self, form: Form, heard: Heard) -> None:
        """Ask item by item, then show all answers for correction."""
        if self._exposed:
            self._exposed = False
            self._clear_typed()
        self._finish_asking_whether_to_stop()
        instrument = form.instrument
        self._console.rule(f"{instrument.title}, {form.timepoint}")
        self._console.print(f"{instrument.instruction}\n{_scale(instrument.answers)}")
        self._console.print(_KEYS, style="dim")
        answers: dict[int, int | None] = {}
        self._fill(instrument, answers, heard)
        self._review(instrument, answers, heard)

    def write(self, question: str) -> Written:
        """Ask, and take lines until an empty one."""
        self._finish_asking_whether_to_stop()
        self._clear_typed()
        self._console.print(question, style="bold")
        self._console.print(f"Type the answer; an empty line ends it. {_STOP}.", style="dim")
        since_s, lines = self._now_s(), list[str]()
        while line := self._typed("> ").rstrip():
            if not lines and line.strip().lower() == keyboard.STOP:
                self._stop_if_sure()
            else:
                lines.append(line)
        return Written("\n".join(lines), self._now_s() - since_s)

    def decide(self, question: str) -> bool:
        """Ask the experimenter a yes-or-no question."""
        self._finish_asking_whether_to_stop()
        self._clear_typed()
        while (line := self._read(f"{question} ({keyboard.YES}/{keyboard.NO}) ")) not in _YES_OR_NO:
            self._tell(f"type {keyboard.YES} to go on, {keyboard.NO} to stop")
        return _YES_OR_NO[line]

    def _fill(self, instrument: Instrument, answers: dict[int, int | None], heard: Heard) -> None:
        index = 0
        while index < len(instrument.items):
            index = index + 1 if self._one(instrument, index, answers, heard) else max(index - 1, 0)

    def _one(
        self, instrument: Instrument, index: int, answers: dict[int, int | None], heard: Heard
    ) -> bool:
        """Ask one item until it is answered; return False to go back."""
        item = instrument.items[index]
        since = self._now_s()
        while True:
            line = self._line(f"{index + 1:2d}. {item.text}: ")
            if line == keyboard.BACK:
                return False
            response = None if line == keyboard.DECLINE else self._number(line, item.answers)
            if line == keyboard.DECLINE or response is not None:
                answers[index] = response
                heard(item.name, response, self._now_s() - since)
                return True

    def _review(self, instrument: Instrument, answers: dict[int, int | None], heard: Heard) -> None:
        while True:
            self._console.print(_answer_table(instrument, answers))
            line = self._line("Enter = all correct, or the number of a question to correct: ")
            if not line:
                return
            if line.isdecimal() and 1 <= int(line) <= len(instrument.items):
                self._one(instrument, int(line) - 1, answers, heard)

    def _line(self, prompt: str) -> str:
        """Return the text typed after a prompt; a wish to stop is asked once more."""
        while True:
            line = self._read(prompt)
            if line != keyboard.STOP:
                return line
            self._stop_if_sure()

    def _stop_if_sure(self) -> None:
        if self._read(f"{keyboard.SURE}: ") in {keyboard.YES, "yes"}:
            raise Withdrew("withdrew at a question")

    def _read(self, prompt: str) -> str:
        return self._typed(prompt).strip().lower()

    def _typed(self, prompt: str) -> str:
        try:
            return self._read_line(prompt)
        except EOFError as error:
            message = "the input ended while a question was open; answers until here are kept"
            raise InputError(message) from error

    def _number(self, line: str, answers: Answers) -> int | None:
        if line.isdecimal() and answers.offers(int(line)):
            return int(line)
        self._tell(f"{answers.asked_in_words}; {_KEYS}")
        return None


def _scale(answers: Answers) -> str:
    """Name every answer, or the two ends of a long scale."""
    if answers.named and len(answers.labels) > 2:
        named = zip(answers.asked, answers.labels, strict=True)
        return ", ".join(f"{number} {label}" for number, label in named)
    if not answers.labels:
        return answers.asked_in_words
    low, high = answers.labels[0], answers.labels[-1]
    steps = "" if answers.asked_step == 1 else f", in steps of {answers.asked_step}"
    return f"{answers.low} {low} to {answers.high} {high}{steps}"


def _answer_table(instrument: Instrument, answers: dict[int, int | None]) -> Table:
    table = Table(box=None)
    for column in ("", instrument.title, "answer"):
        table.add_column(column)
    for index, item in enumerate(instrument.items):
        response = answers[index]
        table.add_row(str(index + 1), item.text, "–" if response is None else str(response))
    return table


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
        """Take a line; return a message on one that is not recorded, else nothing."""
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
        """Return a message on a line that came too late."""
        return f"{line!r} came too late and was not recorded"
