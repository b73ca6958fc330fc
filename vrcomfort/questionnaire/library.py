"""Finds instruments: the shipped ones, a lab's own files, those kept in a study."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from vrcomfort.errors import InputError
from vrcomfort.questionnaire.instrument_file import read_instrument
from vrcomfort.questionnaire.instruments import Instrument
from vrcomfort.resources import data_folder
from vrcomfort.settings import did_you_mean

FOLDER = "instruments"
"""Where a study keeps the instruments that are not shipped."""


@cache
def shipped_instruments() -> Mapping[str, Instrument]:
    """Return name → shipped instrument."""
    files = sorted(data_folder("instruments").glob("*.toml"))
    return {file.stem: read_instrument(file) for file in files}


def usual_instruments() -> tuple[Instrument, ...]:
    """Return the shipped instruments that may be meant where none is named, the longest first.

    A variant is not among them: nobody means other answers without saying so.
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
        Instruments that are there besides the shipped ones, by name.

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
