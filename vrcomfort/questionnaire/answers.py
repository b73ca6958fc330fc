"""The answers that a question takes: a range in steps, with names."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

Answer: TypeAlias = int | float
"""Whole numbers are int, so that sums of them are exact."""


@dataclass(frozen=True)
class Answers:
    """A range of answers.

    Parameters
    ----------
    low, high
        The lowest and the highest.
    step
        What two neighbours are apart; `high` is a whole number of steps above `low`.
    asked_step
        What two neighbours on the form are apart: files may be finer than what is asked here.
    labels
        Names of all answers from `low` to `high`, or of the two ends.
    more_labels
        Names in other languages, as many each.
    """

    low: Answer
    high: Answer
    step: Answer = 1
    asked_step: Answer = 1
    labels: tuple[str, ...] = ()
    more_labels: tuple[tuple[str, ...], ...] = field(default=(), repr=False)

    @cached_property
    def resolution(self) -> Fraction:
        """Return the largest number of which every answer is a multiple."""
        return common_divisor(exact(self.step), exact(self.low))

    @cached_property
    def count(self) -> int:
        """Return how many answers a form offers."""
        return int((exact(self.high) - exact(self.low)) / exact(self.asked_step)) + 1

    @cached_property
    def asked(self) -> tuple[Answer, ...]:
        """Return the answers that a form offers, from low to high."""
        step, low = exact(self.asked_step), exact(self.low)
        return tuple(plain_number(low + step * place) for place in range(self.count))

    @property
    def named(self) -> bool:
        """Return whether every answer has a name."""
        return self.step == self.asked_step and len(self.labels) == self.count

    @cached_property
    def plain(self) -> dict[str, Answer]:
        """Return the answers as they mostly stand in files, where they are not too many."""
        steps = int((exact(self.high) - exact(self.low)) / exact(self.step))
        numbers = (exact(self.low) + exact(self.step) * place for place in range(steps + 1))
        return {str(plain_number(n)): plain_number(n) for n in numbers} if steps <= 1000 else {}

    @cached_property
    def words(self) -> dict[str, Answer]:
        """Return name in small letters → answer, in every language; empty where not all have one.

        A name that means two answers, in two languages, means none.
        """
        if not self.named:
            return {}
        found: dict[str, set[Answer]] = {}
        for labels in (self.labels, *self.more_labels):
            for label, answer in zip(labels, self.asked, strict=True):
                found.setdefault(label.strip().casefold(), set()).add(answer)
        return {word: each.pop() for word, each in found.items() if len(each) == 1}

    def has(self, answer: Answer) -> bool:
        """Return whether a number is one of the answers."""
        if not self.low <= answer <= self.high:
            return False
        return ((exact(answer) - exact(self.low)) / exact(self.step)).denominator == 1

    def offers(self, answer: Answer) -> bool:
        """Return whether a number is one of the answers on a form."""
        return answer in self.asked

    @property
    def in_words(self) -> str:
        """Return the possible answers in words, such as "0 to 3" or "0 to 1 in steps of 0.1"."""
        return self._range(self.step)

    @property
    def asked_in_words(self) -> str:
        """Return the answers that a form offers, as `in_words`."""
        return self._range(self.asked_step)

    def _range(self, step: Answer) -> str:
        steps = "" if step == 1 else f" in steps of {step}"
        return f"{self.low} to {self.high}{steps}"


def exact(number: Answer) -> Fraction:
    """Return the decimal number that is written, as a fraction."""
    return Fraction(str(number))


def plain_number(number: Fraction) -> Answer:
    """Return a fraction as an int where it is one."""
    return int(number) if number.denominator == 1 else float(number)


def common_divisor(*numbers: Fraction) -> Fraction:
    """Return the largest fraction of which all are multiples; 0 counts for nothing."""
    found = Fraction(0)
    for number in numbers:
        a, b = abs(found), abs(number)
        while b:
            a, b = b, a % b
        found = a
    return found
