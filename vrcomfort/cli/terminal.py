"""What is said to people and programs: printing, notes, errors, progress bars."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

_errors = Console(stderr=True, highlight=False, soft_wrap=True)


def complain(sentence: str) -> None:
    """Say on stderr what went wrong."""
    _errors.print(f"[bold red]error:[/] {_escape(sentence)}")


def warn(sentence: str) -> None:
    """Say on stderr what the user should know, although the command goes on."""
    _errors.print(f"[yellow]note:[/] {_escape(sentence)}")


def answer(data: Any) -> None:
    """Print JSON for a program to read; NaN and infinity, which JSON lacks, are errors."""
    typer.echo(json.dumps(data, indent=2, allow_nan=False, default=str))


def console(quiet: bool = False, *, wrap: bool = False) -> Console:
    """Return where people read, silent if `quiet`; `wrap` fits tables into the window."""
    return Console(quiet=quiet, highlight=False, soft_wrap=not wrap)


@contextmanager
def progress_bar(title: str, total: int | None, *, quiet: bool) -> Iterator[Any]:
    """Show a bar on stderr; yields ``advance(steps=1, title=None)``."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    hidden = quiet or not sys.stderr.isatty()
    with Progress(*columns, console=_errors, disable=hidden, transient=True) as progress:
        task = progress.add_task(title, total=total)

        def advance(steps: int = 1, title: str | None = None) -> None:
            progress.update(task, advance=steps, description=title)

        yield advance


def _escape(text: str) -> str:
    return text.replace("[", r"\[")
