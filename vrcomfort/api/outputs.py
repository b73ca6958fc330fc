"""Where results, notes and progress go."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError, spare

Note = Callable[[str], None]
"""Takes a sentence that the user should know, although the work goes on."""


def as_warning(sentence: str) -> None:
    """Pass a note on as a Python warning."""
    warnings.warn(sentence, stacklevel=3)


Progress = Callable[..., AbstractContextManager[Callable[..., None]]]
"""Shows the progress of work: called as ``progress(title, total, unit="")``, it returns a context
that yields a counter of steps, called as ``advance(steps=1, title=None)``."""


@contextmanager
def no_progress(title: str, total: float | None, *, unit: str = "") -> Iterator[Callable[..., Any]]:
    """Show nothing."""
    del title, total, unit
    yield lambda *_, **__: None


def output_folder(path: Path) -> Path:
    """Return a folder for results, which is made with the first of them; earlier ones are replaced.

    Raises
    ------
    InputError
        If `path` is a file, takes no files, or holds recordings, which are never overwritten.
    """
    if path.exists() and not path.is_dir():
        raise InputError("is a file; the output needs a folder", file=path)
    _refuse_recordings(path)
    there = next(each for each in (path, *path.absolute().parents) if each.exists())
    if not there.is_dir():
        raise InputError("is a file; the output needs a folder", file=there)
    if not os.access(there, os.W_OK):  # now, and not after minutes of work
        raise InputError("cannot be written to; choose another output folder", file=there)
    return path


def output_file(path: Path, source: Path) -> Path:
    """Return `path` for a result of `source`; an earlier one is replaced.

    Raises
    ------
    InputError
        If it would lie among recordings or in a folder that is not there, or is the source itself.
    """
    if not path.absolute().parent.is_dir():
        raise InputError("there is no such folder; make it first", file=path.parent)
    _refuse_recordings(path.resolve().parent)  # where a link leads
    spare([source], [path])
    return path


def _refuse_recordings(folder: Path) -> None:
    if any((folder / name).exists() for name in ("participants.csv", "manifest.json")):
        message = "is a study folder, or a session of one"
        raise InputError(f"{message}; choose another output folder for the results", file=folder)
