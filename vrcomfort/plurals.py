"""Numbers with their nouns and verbs."""

from __future__ import annotations

_OF_ONE = {"are": "is", "do": "does", "have": "has", "were": "was"}
"""Verbs that do not take an s."""


def counted(number: int, plural: str) -> str:
    """Return a number and its noun: 1 row of ratings.csv, 2 complete pairs.

    Parameters
    ----------
    plural
        The noun in the plural, the first word that ends as one; others may stand around it.
    """
    words = plural.split(" ")
    if number == 1:
        at = next(i for i, word in enumerate(words) if word == "people" or word.endswith("s"))
        words[at] = "person" if words[at] == "people" else words[at].removesuffix("s")
    return " ".join([str(number), *words])


def counted_doing(number: int, plural: str, verb: str) -> str:
    """Return `counted` with a verb, given in the plural: 1 row has, 2 rows have."""
    said = _OF_ONE.get(verb, f"{verb}s") if number == 1 else verb
    return f"{counted(number, plural)} {said}"
