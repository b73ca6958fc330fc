"""From the text of a cell to an answer."""

from __future__ import annotations

import math
import re
from difflib import get_close_matches

from vrcomfort.importing.mapping import AnswerCoding, Questionnaire
from vrcomfort.importing.source import SourceTable
from vrcomfort.questionnaire import Answer, Answers, Instrument
from vrcomfort.questionnaire.answers import exact

_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")


def number(text: str, decimal: str) -> float | None:
    """Return the number, or percentage, that a text is with this decimal sign; None for others."""
    text = text.removesuffix("%").rstrip() if text.endswith("%") else text
    if decimal == ",":
        if "." in text:
            return None
        text = text.replace(",", ".")
    found = float(text) if _NUMBER.fullmatch(text) else math.nan
    return found if math.isfinite(found) else None  # of 400 digits, it would be infinite


_TIME_IN_WORDS = re.compile(
    r"(?i)(?:\D*?\b)?(?:(\d+)\s*(?:h|hours?)\b\W*)?(?:(\d+)\s*(?:m|mins?|minutes?|minuten)\b\W*)?"
    r"(?:(\d+(?:\.\d+)?)\s*(?:s|secs?|seconds?|sekunden)\b\W*)?"
)


def time_in_words_s(text: str) -> float | None:
    """Return the seconds of ``11m 56s`` or ``Yes - 7 min``; None where no unit says them."""
    match = _TIME_IN_WORDS.fullmatch(text)
    if match is None or not any(match.groups()):
        return None
    hours, minutes, seconds = (float(each or 0) for each in match.groups())
    return 3600 * hours + 60 * minutes + seconds


def rounded(answer: float, answers: Answers) -> float:
    """Return an answer rounded to the steps of answers that have fractions, as sliders give."""
    if answers.step >= 1:
        return answer
    step = exact(answers.step)
    return float(round(exact(answer) / step) * step)


class AnswerReader:
    """Reads the answers of one item as its mapping says.

    Parameters
    ----------
    source
        What the mapping says of the questionnaire; `item_coding` wins where it has the item.
    """

    def __init__(
        self, table: SourceTable, source: Questionnaire, instrument: Instrument, item: str,
        missing: tuple[str, ...],
    ) -> None:  # fmt: skip
        own = source.item_coding.get(item, AnswerCoding())
        words = own.answers or source.answers
        self._table = table
        self._item = item
        self._name = instrument.short
        found = next(each for each in instrument.items if each.name == item)
        self._answers = found.answers
        self._coded_from = source.coded_from if own.coded_from is None else own.coded_from
        self._times = own.times or source.times or 1
        self._reverse_coded = own.reverse_coded or source.reverse_coded
        self._words = {" ".join(word.split()): answer for word, answer in words.items()}
        self._folded = {word.casefold(): answer for word, answer in self._words.items()}
        self._missing = {"", *missing, *source.missing, *own.missing}
        self._known: dict[str, Answer | None] = {}

    def read(self, text: str, row: int, column: int) -> Answer | None:
        """Return the answer, None where it is missing.

        Raises
        ------
        InputError
            If the text is no answer, with file, row and column.
        """
        if text not in self._known:
            self._known[text] = self._answer(text, row, column)
        return self._known[text]

    def _answer(self, text: str, row: int, column: int) -> Answer | None:
        if text in self._missing:
            return None
        answer = self._words.get(text, self._folded.get(text.casefold()))
        if answer is not None and self._reverse_coded:
            message = (
                f"{text!r} has its number from `answers`, which reverse_coded does not turn round"
            )
            hint = f"write the words of {self._item} the other way round, without reverse_coded"
            raise self._table.fault(f"{message}; {hint}", row, column)
        if answer is None:
            value = number(text, self._table.decimal)
            if value is None:
                raise self._table.fault(self._no_answer(text), row, column)
            answer = self._stretched(value)
            if self._reverse_coded:
                answer = self._answers.low + self._answers.high - answer
            answer = rounded(answer, self._answers)
        answer = int(answer) if float(answer).is_integer() else answer
        if not self._answers.low <= answer <= self._answers.high:
            raise self._table.fault(self._out_of_range(text, answer), row, column)
        if not self._answers.has(answer):
            whole = self._answers.resolution == 1
            what = "no whole number" if whole else f"none of {self._answers.in_words}"
            message = f"{text!r} is {what}, as answers to {self._item} are"
            raise self._table.fault(message, row, column)
        return answer

    def _stretched(self, value: float) -> float:
        if self._coded_from is None:
            return value * self._times
        return self._answers.low + (value - self._coded_from) * self._times

    def _no_answer(self, text: str) -> str:
        near = get_close_matches(text, self._words, n=1)
        hint = f"; is it `{near[0]}`?" if near else ""
        message = f"{text!r} is not an answer to {self._item}{hint}"
        return f"{message}; give the word under answers, or under missing, in the mapping"

    def _out_of_range(self, text: str, answer: Answer) -> str:
        low, high = self._answers.low, self._answers.high
        shown = repr(text)
        if self._coded_from is not None:
            shown = f"{text!r}, counted from {self._coded_from}, is {answer}"
        hint = "; give it under missing if it stands for no answer"
        if self._coded_from is None and answer == high + 1:
            hint = f"; if they are counted from {low + 1}, write coded_from = {low + 1}"
        return f"{shown} is out of range, answers of {self._name} are {low} to {high}{hint}"
