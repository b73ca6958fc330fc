"""What is found of answers: an instrument, its columns, and the words around its items."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from vrcomfort.importing.source import Grid, SourceTable
from vrcomfort.importing.suggest.item_names import Named
from vrcomfort.importing.suggest.vocabulary import tokens
from vrcomfort.questionnaire import Instrument, plain


def mentions(text: str, instruments: Iterable[Instrument]) -> set[str]:
    """Return the instruments that a text names by their short names."""
    return {each.name for each in instruments if _mentions(text, each.name, each.short)}


@lru_cache(maxsize=65536)  # a table is searched for each instrument, with each column as its items
def _mentions(text: str, name: str, short: str) -> bool:
    words, joined = set(tokens(text)), plain(text)
    return bool(words & _acronyms(short)) or any(
        each in words or (len(each) > 4 and each in joined) for each in (plain(name), plain(short))
    )


def named_by_file(
    table: SourceTable | Grid, instruments: Iterable[Instrument], *others: str
) -> set[str]:
    """Return the instruments that the name of a table's file, or of its sheet, names, or others."""
    return mentions(" ".join([table.file.stem, table.sheet, *others]), instruments)


def _acronyms(short: str) -> set[str]:
    """Return the acronyms that a short name is made of: ``NASA-TLX`` is called ``TLX``, too."""
    return {part.casefold() for part in short.split("-") if part.isupper() and len(part) > 2}


Context = tuple[str, ...]


@dataclass(frozen=True)
class FoundAnswers(ABC):
    """Columns of answers, in any layout.

    Parameters
    ----------
    context
        The words that the headings share, but for those that name the instrument.
    """

    instrument: Instrument
    context: Context

    @property
    @abstractmethod
    def columns(self) -> list[int]:
        """Return the indices of the columns."""


def without_name(words: Context, found: FoundAnswers) -> Context:
    """Return words of headings without the instrument's acronym before a letter: ``SSQA``."""
    names = [name for name in _acronyms(found.instrument.short) if len(name) > 2]
    glued = {name + word[-1]: word[-1] for name in names for word in words}
    return tuple(glued.get(word, word) for word in words)


@dataclass(frozen=True)
class Found(FoundAnswers):
    """Columns that are one questionnaire.

    Parameters
    ----------
    items
        Item → index of its column.
    siblings
        Columns of other administrations of the instrument, which are coded as these are.
    """

    items: dict[str, Named]
    siblings: tuple[int, ...] = ()

    @property
    def columns(self) -> list[int]:
        """Return the indices of its columns, in the order of the file."""
        return sorted(named.column for named in self.items.values())

    @property
    def absent(self) -> list[str]:
        """Return the items that have no column."""
        return [item.name for item in self.instrument.asked if item.name not in self.items]
