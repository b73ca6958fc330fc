"""A column of words of a recording, as numbers: names are few, and rows are many."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vrcomfort.recordings.memory import column
from vrcomfort.recordings.source import rows_of, told_with_its_place

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vrcomfort.recordings.memory import Memory
    from vrcomfort.recordings.source import Source


class Words(NamedTuple):
    """The words of a column.

    Parameters
    ----------
    places
        (rows,) of each row's word in `words`; −1 where the cell is blank.
    words
        Each once, in alphabetical order.
    """

    places: NDArray[np.int32]
    words: tuple[str, ...]


def read_words(source: Source, name: str, memory: Memory) -> Words | None:
    """Return a column of words, whole; None where the recording does not have it, or only blanks.

    Raises
    ------
    InputError
        If the recording is damaged, with its place.
    """
    cell = column(name)
    with (
        told_with_its_place(source),
        memory.database() as database,
        rows_of(source) as (table, columns),
    ):
        if name not in columns:
            return None
        each = f"SELECT DISTINCT {cell} FROM {table} WHERE {cell} <> '' ORDER BY 1"  # noqa: S608
        words = [str(word) for (word,) in database.execute(each).fetchall()]
        if not words:
            return None
        place = f"coalesce(list_position(?, {cell}), 0) - 1"
        query = f"SELECT CAST({place} AS INTEGER) AS place FROM {table}"  # noqa: S608
        found = database.execute(query, [words]).fetchnumpy()
    return Words(np.asarray(found["place"], np.int32), tuple(words))
