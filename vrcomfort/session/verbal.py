"""The experimenter asks aloud and enters the answers on the console."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from vrcomfort.operator_interface import Command, OperatorInterface
from vrcomfort.protocol.texts import ENGLISH, Words
from vrcomfort.questionnaire import Instrument, Item
from vrcomfort.respondent import Exposure, Form
from vrcomfort.respondent.base import Heard, InstructionContent, Written
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.session.panel_screen import PanelScreen


class VerbalRespondent:
    """Questions asked aloud; the experimenter enters the answers at a console.

    The answers have the rows of any other respondent; the events `operator_answer` and
    `operator_rate` say who entered them.

    Parameters
    ----------
    screen
        Of the headset; None where it has none.
    words
        In the participant's language.
    """

    name = "console"

    def __init__(
        self,
        interface: OperatorInterface,
        operators: OperatorControl,
        screen: PanelScreen | None = None,
        *,
        words: Words = ENGLISH,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._interface, self._operators, self._screen, self._now_s = (
            interface,
            operators,
            screen,
            now_s,
        )
        self._words = words
        self._rated: float | None = None
        self._rates_until_s: float | None = None
        self._nothing_asked = operators.entry_fault

    def start_session(self, session: int) -> None:
        """Do nothing: the page shows it."""

    def start_exposure(self, exposure: Exposure) -> None:  # noqa: ARG002
        """Forget the rating before."""
        self._close_rating()

    def update(self, elapsed_s: float) -> None:
        """Take the rating that was entered; close the question when its time is over."""
        while self._operators.entries:
            self._rated = self._operators.entries.popleft().value
            self._close_rating()
        if self._rates_until_s is not None and elapsed_s > self._rates_until_s:
            self._close_rating()

    def end_exposure(self, elapsed_s: float) -> None:  # noqa: ARG002
        """Close the question."""
        self._close_rating()

    def prompt(self, instrument: Instrument, elapsed_s: float, timeout_s: float) -> None:
        """Have a rating asked for; it is picked up by `update`."""
        item = instrument.items[0]
        self._rated, self._rates_until_s = None, elapsed_s + timeout_s
        self._operators.entry_fault = lambda entry: _fault_of(item, entry, "rate")
        self._interface.ask(
            {"action": "rate", "title": instrument.title, "instruction": instrument.instruction,
             "timeout_s": timeout_s, "items": [_shown(item, None, answered=False)], "current": 0}
        )  # fmt: skip

    def rating(self, elapsed_s: float) -> int | None:  # noqa: ARG002
        """Return the rating that has been entered since `prompt`."""
        return None if self._rated is None else int(self._rated)

    def _close_rating(self) -> None:
        if self._rates_until_s is not None:
            self._rates_until_s = None
            self._operators.entry_fault = self._nothing_asked
            self._interface.ask(None)

    def resting(self, left_s: float) -> bool:
        """Let a frame pass in the headset, if there is one."""
        if self._screen is None:
            return False
        self._screen.allow_absence(left_s)
        self._screen.rest_on(self._words.rest_aloud)
        self._operators.idle()
        return True

    def rest(self, duration_s: float) -> None:  # noqa: ARG002
        """Clear the view."""
        self._show(None)

    def read(
        self,
        content: InstructionContent,  # noqa: ARG002
        elapsed_s: float,  # noqa: ARG002
        *,
        may_go_on: bool,  # noqa: ARG002
    ) -> float | None:
        """Leave it to the operators to go on, by *Skip*."""
        self._operators.idle()
        return 0.0

    def leave(self) -> None:
        """Clear the view."""
        self._show(None)

    def ask(self, form: Form, heard: Heard) -> None:
        """Have every item asked, and all answers looked through."""
        sheet = _Sheet(form, self._now_s)
        self._show(self._words.listen)
        self._operators.entry_fault = sheet.fault
        try:
            self._interface.ask(sheet.shown())
            while not sheet.confirmed:
                self._operators.look()
                while self._operators.entries:
                    sheet.take(self._operators.entries.popleft(), heard)
                    self._interface.ask(sheet.shown())
                self._operators.idle()
        finally:
            self._operators.entry_fault = self._nothing_asked
            self._interface.ask(None)
            self._show(None)

    def decide(self, question: str) -> bool:
        """Have the operators decide whether it goes on."""
        self._operators.entry_fault = _fault_of_decision
        item = {**_open(question), "values": [1, 0], "labels": ["continue", "stop"]}
        shown = {"action": "decide", "title": "To be decided", "instruction": "", "current": 0}
        self._interface.ask({**shown, "items": [item]})
        try:
            while not self._operators.entries:
                self._operators.look()
                self._operators.idle()
            return bool(self._operators.entries.popleft().value)
        finally:
            self._operators.entry_fault = self._nothing_asked
            self._interface.ask(None)

    def write(self, question: str) -> Written:
        """Have a question answered in the participant's own words, and typed here."""
        since_s = self._now_s()
        self._show(self._words.listen)
        self._operators.entry_fault = _fault_of_text
        shown = {"action": "write", "title": "In the participant's own words"}
        self._interface.ask({**shown, "instruction": "", "items": [_open(question)], "current": 0})
        try:
            while not self._operators.entries:
                self._operators.look()
                self._operators.idle()
            return Written(self._operators.entries.popleft().text, self._now_s() - since_s)
        finally:
            self._operators.entry_fault = self._nothing_asked
            self._interface.ask(None)
            self._show(None)

    def _show(self, words: str | None) -> None:
        if self._screen is not None:
            self._screen.rest_on(words)


class _Sheet:
    """A questionnaire that is being filled in."""

    def __init__(self, form: Form, now_s: Callable[[], float]) -> None:
        self._form, self._now_s = form, now_s
        self._items = {item.name: item for item in form.instrument.items}
        self._answers: dict[str, float | None] = {}
        self._since_s = now_s()
        self.confirmed = False

    def fault(self, entry: Command) -> str:
        """Return why an entry cannot be taken; blank where it can."""
        if entry.action == "confirm":
            left = len(self._items) - len(self._answers)
            return f"{left} questions are open; answer them first" if left else ""
        item = self._items.get(entry.text)
        if item is None:
            return f"this questionnaire has no question {entry.text[:40]!r}"
        return _fault_of(item, entry, "answer")

    def take(self, entry: Command, heard: Heard) -> None:
        """Take an entry that has no fault."""
        if entry.action == "confirm":
            self.confirmed = True
            return
        now_s = self._now_s()
        took_s, self._since_s = now_s - self._since_s, now_s
        self._answers[entry.text] = entry.value
        value = entry.value
        heard(entry.text, None if value is None else int(value), took_s)

    def shown(self) -> dict[str, Any]:
        """Return the questionnaire as the page shows it."""
        instrument, items = self._form.instrument, list(self._items.values())
        left = [place for place, item in enumerate(items) if item.name not in self._answers]
        return {
            "action": "answer",
            "title": f"{instrument.title}, {self._form.timepoint}",
            "instruction": instrument.instruction,
            "items": [
                _shown(item, self._answers.get(item.name), answered=item.name in self._answers)
                for item in items
            ],
            "current": left[0] if left else len(items),
        }


def _fault_of(item: Item, entry: Command, action: str) -> str:
    if entry.action != action:
        return f"this question takes no {entry.action}"
    value = entry.value
    if value is None and action == "answer":
        return ""
    if value is not None and float(value).is_integer() and item.answers.offers(value):
        return ""
    return f"{item.answers.asked_in_words} is an answer to {item.text!r}"


def _fault_of_decision(entry: Command) -> str:
    taken = entry.action == "decide" and entry.value in (0, 1)
    return "" if taken else "this question takes go on (1) or stop (0)"


def _fault_of_text(entry: Command) -> str:
    return "" if entry.action == "write" else f"this question takes no {entry.action}"


def _open(question: str) -> dict[str, Any]:
    """Return a question without answers to choose from, as the page shows it."""
    nothing: dict[str, Any] = {"values": [], "labels": [], "ends": [], "answer": None}
    return {"name": "text", "text": question, "answered": False, **nothing}


def _shown(item: Item, answer: float | None, *, answered: bool) -> dict[str, Any]:
    """Return an item as the page shows it."""
    answers = item.answers
    labels = answers.labels
    return {
        "name": item.name,
        "text": item.text,
        "values": list(answers.asked),
        "labels": list(labels) if answers.named else [],
        "ends": [labels[0], labels[-1]] if labels and not answers.named else [],
        "answer": answer,
        "answered": answered,
    }
