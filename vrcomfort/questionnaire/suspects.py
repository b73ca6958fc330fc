"""Answers that may be something else: sums in the column of an item, answers counted from 1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from vrcomfort.questionnaire.answers import Answer
from vrcomfort.questionnaire.instruments import Instrument

FEWEST_ANSWERS = 32
"""So many answers without a single 0 are asked about: two whole SSQs."""

MOST_STEPS = 6
"""On longer scales nobody may well have answered 0."""


def never_zero(instrument: Instrument, counts: Mapping[Answer, int]) -> int:
    """Return how many answers there are where none is 0 though that is the lowest, else 0.

    Then all of them may be too high by one: 1 to 4, with no 4 among them, for 0 to 3.

    Parameters
    ----------
    counts
        Answer → how often it was given.
    """
    answered = sum(counts.values())
    short = instrument.low == 0 and instrument.high <= MOST_STEPS
    suspect = short and answered >= FEWEST_ANSWERS and not counts.get(0)
    return answered if suspect else 0


def sum_in_place_of(
    instrument: Instrument,
    item: str,
    answers: Sequence[Mapping[str, Answer | None]],
    others: Mapping[str, Sequence[Answer | None]],
) -> tuple[str, str] | None:
    """Return (column, scale) where an item's column is exactly the raw sum of a scale.

    That is so where the sheet's item has another heading, and the scale's sum the item's. Rows
    with a missing answer prove nothing.

    Parameters
    ----------
    others
        Heading → answers of columns that are no item's, and may be this one's.
    """
    for heading, column in others.items():
        for scale in instrument.scales:
            terms = {term.item: term.slope for term in scale.terms}
            if item not in terms or len(terms) < 3:
                continue
            rows = [
                (sheet[item], sum(terms[name] * _of(sheet, name, item, other) for name in terms))
                for sheet, other in zip(answers, column, strict=True)
                if other is not None and all(sheet.get(name) is not None for name in terms)
            ]
            if len({found for found, _ in rows}) > 1 and all(a == b for a, b in rows):
                return heading, scale.title
    return None


def _of(sheet: Mapping[str, Answer | None], name: str, item: str, other: Answer) -> Answer:
    """Return the answer to an item, that of `other` standing for `item`."""
    found = other if name == item else sheet[name]
    return 0 if found is None else found
