"""Numbers with their nouns."""

from __future__ import annotations


def counted(number: int, plural: str) -> str:
    """Return a number and its noun: 1 row of ratings.csv, 2 rows of ratings.csv.

    Parameters
    ----------
    plural
        The noun in the plural; other words may follow it.
    """
    noun, space, rest = plural.partition(" ")
    if number == 1:
        noun = "person" if noun == "people" else noun.removesuffix("s")
    return f"{number} {noun}{space}{rest}"
