"""What is said to people and programs: printing, notes, errors, progress.

Everything that is printed may be data, in which square brackets are square brackets: nothing here
reads markup. What is to look different has a `style`.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TimeRemainingColumn
from rich.table import Column
from rich.text import Text

SILENT_S = 2.0
"""Where no bar can be shown, a line says after so long that work is under way."""

LINE_EVERY_S = 10.0
"""So often, from then on, another says how far it has come."""


def _console(**settings: Any) -> Console:
    return Console(markup=False, highlight=False, emoji=False, **settings)


_errors = _console(stderr=True, soft_wrap=True)


def complain(sentence: str) -> None:
    """Say on stderr what went wrong."""
    _errors.print(Text("error:", style="bold red"), sentence)


def warn(sentence: str) -> None:
    """Say on stderr what the user should know, although the command goes on."""
    _errors.print(Text("note:", style="yellow"), sentence)


def answer(data: Any) -> None:
    """Print JSON for a program to read; NaN and infinity, which JSON lacks, are errors."""
    typer.echo(json.dumps(data, indent=2, allow_nan=False, default=str))


def console(quiet: bool = False, *, wrap: bool = False) -> Console:
    """Return where people read, silent if `quiet`; `wrap` fits tables into the window."""
    return _console(quiet=quiet, soft_wrap=not wrap)


class _Words(ProgressColumn):
    """What is done, as text that is nothing but text."""

    def render(self, task: Task) -> Text:
        """Return the title, and how far it has come."""
        return Text(_how_far(task.description, task.completed, task.total, task.fields["unit"]))


@contextmanager
def progress_bar(title: str, total: int | None, *, quiet: bool, unit: str = "") -> Iterator[Any]:
    """Show a bar on stderr, or now and then a line where stderr is no terminal.

    Parameters
    ----------
    unit
        Of `total`, such as s or frames.

    Yields
    ------
    callable
        ``advance(steps=1, title=None)``.
    """
    if not quiet and not sys.stderr.isatty():
        yield _Lines(title, total, unit).advance
        return
    columns = (_Words(Column(no_wrap=True)), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=_errors, disable=quiet, transient=True) as progress:
        task = progress.add_task(title, total=total, unit=unit)

        def advance(steps: float = 1, title: str | None = None) -> None:
            progress.update(task, advance=steps, description=title)

        yield advance


class _Lines:
    """Says how far work has come, in lines: the first after `SILENT_S`, then rarely."""

    def __init__(
        self,
        title: str,
        total: float | None,
        unit: str,
        *,
        now_s: Callable[[], float] = time.monotonic,
        say: Callable[[str], None] = lambda line: _errors.print(line),
    ) -> None:
        self._title, self._total, self._unit = title, total, unit
        self._now_s, self._say = now_s, say
        self._done = 0.0
        self._due_s = now_s() + SILENT_S

    def advance(self, steps: float = 1, title: str | None = None) -> None:
        """Count steps, and say so where a line is due."""
        self._done += steps
        self._title = title or self._title
        if self._now_s() >= self._due_s:
            self._due_s = self._now_s() + LINE_EVERY_S
            self._say(f"{_how_far(self._title, self._done, self._total, self._unit)} ...")


def _how_far(title: str, done: float, total: float | None, unit: str) -> str:
    counts = f"{done:.0f}" if total is None else f"{done:.0f} of {total:.0f}"
    return f"{title}: {counts} {unit}".rstrip()
