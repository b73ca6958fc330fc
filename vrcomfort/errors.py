"""Exceptions for users: faults of their input, and a runtime that went away."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path


def pip_install(*packages: str, again: bool = False) -> str:
    """Return the install command for a missing or damaged package that pyproject.toml names.

    It names that package alone: vrcomfort is on no index, so its own extras can only be installed
    from a checkout.

    >>> pip_install("pylsl")
    'pip install pylsl'
    >>> pip_install("pylsl>=1.17", again=True)
    'pip install --force-reinstall "pylsl>=1.17"'
    """
    # A shell reads < and > as redirections.
    quoted = (f'"{each}"' if set(each) & set("<>") else each for each in packages)
    return " ".join(("pip install", *(["--force-reinstall"] if again else []), *quoted))


class InputError(ValueError):
    """Input that cannot be used, said in one sentence with its place.

    Parameters
    ----------
    message
        What is wrong and what to do about it.
    file, line, column
        Where: a path, a 1-based line, and a column name (tables) or 1-based column (text).
    others
        What else is wrong with the same file; the message says how many there are.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        column: str | int | None = None,
        others: Sequence[InputError] = (),
    ) -> None:
        self.message = message
        self.others = tuple(others)
        self.file = file
        self.line = line
        self.column = column
        place = [str(file)] if file is not None else []
        if line is not None:
            place.append(f"line {line}")
        if column is not None:
            place.append(f"column {column}")
        problems = "problems" if len(others) > 1 else "problem"
        told = f"{message} ({len(others)} more {problems} in this file)" if others else message
        super().__init__(f"{', '.join(place)}: {told}" if place else told)

    @property
    def alone(self) -> InputError:
        """Return this error without the others."""
        return InputError(self.message, file=self.file, line=self.line, column=self.column)


def spare(sources: Iterable[Path | None], outputs: Iterable[Path]) -> None:
    """Make sure that writing `outputs` replaces none of the files that are read.

    Two paths are one file also where one is a link to the other.

    Raises
    ------
    InputError
        Names the file.
    """
    read = [source for source in sources if source is not None and source.exists()]
    for output in outputs:
        if output.exists() and any(output.samefile(source) for source in read):
            message = "is read here, and would be overwritten; choose another --out"
            raise InputError(message, file=output)


class RuntimeLostError(InputError):
    """The headset's runtime went away in the middle of a session; the records stay."""


def headset_ended(when: str) -> RuntimeLostError:
    """Return the exception for a headset that gives no more frames; `when` completes a sentence."""
    return RuntimeLostError(
        f"the headset ended the session {when}; what was recorded until here is kept: "
        "run with --resume"
    )
