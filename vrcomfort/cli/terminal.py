"""Terminal output: printing, notes, errors, progress.

Everything that is printed may be data, in which square brackets are square brackets: nothing here
reads markup. Styled text has a `style`.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, Self

import typer
from rich.console import Console, ConsoleOptions, RenderableType
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TimeRemainingColumn
from rich.segment import Segment
from rich.table import Column
from rich.text import Text

from vrcomfort.escaping import escape_unprintable

if TYPE_CHECKING:
    from vrcomfort.tasks import TaskCode

EXIT_BAD_INPUT = 2  # as Typer and most Unix programs end where they were typed wrongly

SILENT_S = 2.0
"""Where no bar can be shown, a line says after so long that work is under way."""

LINE_EVERY_S = 10.0
"""So often, from then on, another says how far it has come."""


_NO_WIDTH = 10_000
"""Columns, where nothing limits them."""


class _Terminal(Console):
    r"""Shows control characters as ``\u001b``: a terminal would obey those in data."""

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        """Yield the segments of printed text."""
        for each in super().render(renderable, options):
            yield each if each.control else each._replace(text=escape_unprintable(each.text))


def _console(**settings: Any) -> Console:
    return _Terminal(markup=False, highlight=False, emoji=False, **settings)


_errors = _console(stderr=True, soft_wrap=True)


def complain(sentence: str) -> None:
    """Print an error on stderr."""
    _errors.print(Text("error:", style="bold red"), sentence)


def warn(sentence: str) -> None:
    """Print a note on stderr; the command goes on."""
    _errors.print(Text("note:", style="yellow"), sentence)


def answer(data: Any) -> None:
    """Print JSON for a program to read; NaN and infinity, which JSON lacks, are errors."""
    typer.echo(json.dumps(data, indent=2, allow_nan=False, default=str))


def conclude(sentence: str, facts: Mapping[str, Any], *, quiet: bool, as_json: bool) -> None:
    """Print the result of a command: a sentence for people, or `facts` as JSON for programs."""
    if as_json:
        answer(facts)
    else:
        console(quiet).print(sentence)


def console(quiet: bool = False, *, wrap: bool = False) -> Console:
    """Return where people read, silent if `quiet`; `wrap` fits tables into the window.

    In a file or a pipe, which have no width, tables are as wide as their words.
    """
    has_width = not wrap or sys.stdout.isatty() or "COLUMNS" in os.environ
    return _console(quiet=quiet, soft_wrap=not wrap, width=None if has_width else _NO_WIDTH)


def dialogue() -> Console:
    """Return where a person is asked: beside a progress bar, lines stand above it."""
    return _errors if sys.stdout.isatty() and sys.stderr.isatty() else console()


def ask_for_code(code: TaskCode) -> bool:
    """Ask at the terminal whether a protocol's Python files may run; False without a terminal."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return False
    warn("this protocol runs Python files of its own, which can do whatever you can:")
    for name, sha256 in sorted(code.hashes.items()):
        _errors.print(f"  {code.folder / name}  (SHA-256 {sha256})")
    question = "Have you read them, and may they run? The consent is kept until they change"
    return typer.confirm(question, default=False, err=True)


def ask_to_go_on(sentence: str) -> bool:
    """Name the missing, and ask at the terminal whether to go on; True without a terminal."""
    warn(sentence)
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return True
    return typer.confirm("Go on without it? That is recorded", default=False, err=True)


def ask_to_type(question: str) -> None:
    """Ask the experimenter to type the participant's words; lines are read elsewhere."""
    dialogue().print(question, style="bold")
    dialogue().print("Type what the participant says; an empty line ends it.", style="dim")


class _Words(ProgressColumn):
    """The progress in words, as text without markup."""

    def render(self, task: Task) -> Text:
        """Return the title, and how far it has come."""
        return Text(_how_far(task.description, task.completed, task.total, task.fields["unit"]))


@contextmanager
def progress_bar(title: str, total: float | None, *, quiet: bool, unit: str = "") -> Iterator[Any]:
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
        with _Lines(title, total, unit) as lines:
            yield lines.advance
        return
    columns = (_Words(Column(no_wrap=True)), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=_errors, disable=quiet, transient=True) as progress:
        task = progress.add_task(title, total=total, unit=unit)

        def advance(steps: float = 1, title: str | None = None) -> None:
            progress.update(task, advance=steps, description=title)

        yield advance


class _Lines:
    """Says how far work has come, in lines: the first after `SILENT_S`, then rarely."""

    def __init__(self, title: str, total: float | None, unit: str) -> None:
        self._title, self._total, self._unit = title, total, unit
        self._done = 0.0
        self._over = Event()
        self._thread = Thread(target=self._tell, name="progress", daemon=True)

    def advance(self, steps: float = 1, title: str | None = None) -> None:
        """Count steps."""
        self._done += steps
        self._title = title or self._title

    def _tell(self) -> None:
        wait_s, passed_s = SILENT_S, 0.0
        while not self._over.wait(wait_s):
            passed_s += wait_s
            words = _how_far(self._title, self._done, self._total, self._unit)
            _errors.print(f"{words}{time_left(passed_s, self._done, self._total)} ...")
            wait_s = LINE_EVERY_S

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._over.set()
        self._thread.join()


def time_left(passed_s: float, done: float, total: float | None) -> str:
    """Return the time that the rest takes at the pace so far; blank where there is no pace yet."""
    if not total or not 0 < done < total:
        return ""
    left_s = passed_s * (total - done) / done
    if left_s < 1:
        return ""
    return f", about {left_s:.0f} s left" if left_s < 100 else f", about {left_s / 60:.0f} min left"


def _how_far(title: str, done: float, total: float | None, unit: str) -> str:
    if total is None:
        return title
    return f"{title}: {done:.0f} of {total:.0f} {unit}".rstrip()
