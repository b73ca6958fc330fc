"""What can be analysed: the scores of every instrument, by the names that plans give them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import INSTRUMENTS, LOADINGS, WEIGHTS, Instrument


@dataclass(frozen=True)
class Outcome:
    """A score of an instrument: a weighted sum of integer answers, times points per step.

    Parameters
    ----------
    loadings
        Item → whole number by which its answer counts.
    unit
        Points per step of that sum.
    parts
        Names of the outcomes that it is summed from; blank for a score of its own.
    """

    name: str
    title: str
    instrument: str
    loadings: Mapping[str, int]
    unit: float
    parts: tuple[str, ...] = ()

    def raw(self, answers: Mapping[str, int | None]) -> int | None:
        """Return the sum of the answers; None where one that counts is missing."""
        total = 0
        for item, times in self.loadings.items():
            answer = answers.get(item)
            if answer is None:
                return None
            total += times * answer
        return total

    def prorated(self, answers: Mapping[str, int | None]) -> Fraction | None:
        """Return the sum that the answered items give if the missing ones are like them."""
        given = {item: answers.get(item) for item in self.loadings}
        counted = sum(self.loadings[item] for item, answer in given.items() if answer is not None)
        if not counted:
            return None
        total = sum(self.loadings[i] * answer for i, answer in given.items() if answer is not None)
        return Fraction(total * sum(self.loadings.values()), counted)


_SSQ_TITLES = {"T": "Total severity", "N": "Nausea", "O": "Oculomotor", "D": "Disorientation"}


def _of_the_ssq() -> Iterable[Outcome]:
    total = {item: len(loads) for item, loads in LOADINGS.items()}
    yield Outcome("T", _SSQ_TITLES["T"], "ssq", total, WEIGHTS["T"], ("N", "O", "D"))
    for part in "NOD":
        loadings = {item: 1 for item, loads in LOADINGS.items() if part in loads}
        yield Outcome(part, _SSQ_TITLES[part], "ssq", loadings, WEIGHTS[part])


def outcomes_of(instrument: Instrument) -> tuple[Outcome, ...]:
    """Return the scores of an instrument; of a single-item scale, the answer."""
    if instrument.name == "ssq":
        return tuple(_of_the_ssq())
    loadings = {item.name: 1 for item in instrument.items}
    return (Outcome(instrument.name, instrument.title, instrument.name, loadings, 1.0),)


def known_outcomes() -> dict[str, Outcome]:
    """Return every score that a plan may name."""
    return {
        outcome.name: outcome
        for instrument in INSTRUMENTS.values()
        for outcome in outcomes_of(instrument)
    }


def outcomes_in(instruments: Iterable[str]) -> tuple[Outcome, ...]:
    """Return the scores of instruments, in the order given."""
    return tuple(outcome for name in instruments for outcome in outcomes_of(INSTRUMENTS[name]))


def find_outcome(name: str) -> Outcome:
    """Return the score of that name.

    Raises
    ------
    InputError
        If no instrument has it, with the nearest one.
    """
    known = known_outcomes()
    if name not in known:
        raise InputError(unknown_outcome(name, known))
    return known[name]


def unknown_outcome(name: str, known: Iterable[str]) -> str:
    """Say that there is no such score, and which may be meant."""
    choices = {each.casefold(): each for each in known}
    near = get_close_matches(name.casefold(), choices, n=1, cutoff=0.6)
    hint = f"did you mean `{choices[near[0]]}`?" if near else f"there are {', '.join(known)}"
    return f"`{name}` is no score of any instrument; {hint}"
