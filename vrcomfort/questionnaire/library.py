"""Finds instruments: the shipped ones, a lab's own files, those kept in a study."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.installed import file_of, installed
from vrcomfort.questionnaire.instrument_file import read_instrument
from vrcomfort.questionnaire.instruments import Instrument
from vrcomfort.resources import data_folder
from vrcomfort.settings import did_you_mean

FOLDER = "instruments"
"""Where a study keeps the instruments that are not shipped."""


ENTRY_POINTS = "vrcomfort.instruments"
"""Group of the entry points of installed packages: the name of an instrument → its TOML file."""


@cache
def shipped_instruments() -> Mapping[str, Instrument]:
    """Return name → shipped instrument."""
    files = sorted(data_folder("instruments").glob("*.toml"))
    return {file.stem: read_instrument(file) for file in files}


def usual_instruments() -> tuple[Instrument, ...]:
    """Return the shipped instruments that may be meant where none is named, the longest first.

    A variant is not among them: a file with its answers names it.
    """
    usual = [each for each in shipped_instruments().values() if not each.variant_of]
    return tuple(sorted(usual, key=lambda each: (-len(each.asked), each.name)))


def find_instrument(
    name_or_file: str | Path,
    *,
    beside: Path | None = None,
    known: Mapping[str, Instrument] | None = None,
) -> Instrument:
    """Return an instrument by its name, or from its file.

    Parameters
    ----------
    beside
        The folder in which a relative file is looked for first.
    known
        Instruments that are there besides the shipped ones, by name. Those of installed packages
        (group ``vrcomfort.instruments``) are found by name, too.

    Raises
    ------
    InputError
        If there is none, or its file is wrong, with line and column; or a lab's file has the name
        of a shipped one.
    """
    there = {**shipped_instruments(), **(known or {})}
    text = str(name_or_file)
    if text in there:
        return there[text]
    for file in ([beside / text] if beside else []) + [Path(text)]:
        if file.is_file():
            return own_instrument(file)
    for found in installed(ENTRY_POINTS):
        if found.name == text:
            return own_instrument(file_of(found))
    if text.endswith(".toml"):
        raise InputError("there is no such instrument file; check the path", file=text)
    hint = did_you_mean(text, there)
    raise InputError(
        f"there is no instrument `{text}`; {hint} (a lab's own is given as a file, NAME.toml)"
    )


def own_instrument(file: Path) -> Instrument:
    """Read a lab's own instrument.

    Raises
    ------
    InputError
        As `find_instrument`.
    """
    found = read_instrument(file)
    same = shipped_instruments().get(found.name)
    if same is not None and same.text != found.text:
        message = f"`{found.name}` is a shipped instrument; give this one another `name`"
        raise InputError(message, file=file)
    return found


def instruments_in(folders: Iterable[Path]) -> dict[str, Instrument]:
    """Return name → instrument of the TOML files in the subfolders ``instruments``.

    Raises
    ------
    InputError
        If a file is wrong, or two different ones have one name.
    """
    found: dict[str, Instrument] = {}
    for folder in folders:
        for file in sorted((folder / FOLDER).glob("*.toml")):
            own = own_instrument(file)
            if found.setdefault(own.name, own).text != own.text:
                message = f"another instrument is called `{own.name}` too; rename one of them"
                raise InputError(message, file=file)
    return found


def asked_in(tables: Iterable[CsvTable], known: Mapping[str, Instrument]) -> dict[str, float]:
    """Return the name of each instrument → about how many of its questionnaires there are.

    Those after exposures come first, and before those the more frequent ones. Rows that name no
    instrument are of the one whose items they have, if there is one. A name that is not known
    stands there with its number of rows.
    """
    counts: Counter[tuple[str, bool]] = Counter()
    nameless: set[str] = set()
    for table in tables:
        names = _column(table, "instrument")
        exposed = [bool(cell.strip()) for cell in _column(table, "condition")]
        items = _column(table, "item")
        lower = {name: name.strip().lower() for name in set(names)}
        counts.update(zip(map(lower.__getitem__, names), exposed, strict=True))
        if "" in lower.values():
            nameless |= {i for i, name in zip(items, names, strict=True) if not name.strip()}
    guessed = guess(sorted(nameless), known)
    totals: dict[str, list[float]] = {}
    for (name, after_exposure), rows in counts.items():
        found = name or (guessed.name if guessed else "")
        size = len(known[found].asked) if found in known else 1
        total = totals.setdefault(found, [0.0, 0.0])
        total[0] += after_exposure * rows / size
        total[1] += rows / size
    order = sorted(totals, key=lambda name: totals[name], reverse=True)
    return {name: totals[name][1] for name in order if name}


def guess(headings: Sequence[str], known: Mapping[str, Instrument]) -> Instrument | None:
    """Return the instrument that knows most of the headings and lacks the fewest; None if two do.

    A variant of another is never guessed: its answers would say something else.
    """
    fits: dict[tuple[int, int], list[Instrument]] = {}
    for instrument in known.values():
        found = {item.name for item in map(instrument.item, headings) if item is not None}
        if found and not instrument.variant_of:
            lacking = sum(item.name not in found for item in instrument.asked)
            fits.setdefault((len(found), -lacking), []).append(instrument)
    best = fits[max(fits)] if fits else []
    return best[0] if len(best) == 1 else None


def guess_for_file(file: Path) -> Instrument:
    """Return the shipped instrument that a wide or a long CSV file holds.

    Raises
    ------
    InputError
        If the file holds none, or several.
    """
    table = CsvTable.read(file)
    if not table.header:
        raise InputError("this file is empty", file=file)
    known = shipped_instruments()
    headings = {heading.lower() for heading in table.header}
    if {"item", "response"} <= headings:
        names = list(asked_in([table], known))
    else:
        found = guess(table.header, known)
        names = [found.name] if found else []
    if len(names) == 1 and names[0] in known:
        return known[names[0]]
    what = "holds answers to " + " and ".join(names) if names else "has the items of no instrument"
    hint = f"give --instrument NAME ({', '.join(known)}), or the file of your own"
    hint += "; for other layouts there is `vrcomfort import FILE --suggest`"
    raise InputError(f"this {what}; {hint}", file=file)


def _column(table: CsvTable, name: str) -> list[str]:
    headings = [heading.lower() for heading in table.header]
    if name not in headings:
        return [""] * len(table.rows)
    place = headings.index(name)
    return [cells[place] for cells in table.rows]
