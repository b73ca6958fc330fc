"""What the commands share: options with their help, printing, progress bars."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

from vrcomfort.errors import InputError, spare

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print only what was asked for.")]
Json = Annotated[bool, typer.Option("--json", help="Answer as JSON, for programs.")]
Seed = Annotated[int, typer.Option(help="Every random choice derives from it.", min=0)]
StudySeed = Annotated[
    int | None,
    typer.Option(
        help="Every random choice derives from it. A study keeps its first one (else 0).", min=0
    ),
]
Size = Annotated[str, typer.Option(metavar="WxH", help="Pixels of one eye's image.")]
ProtocolArgument = Annotated[
    str, typer.Argument(metavar="PROTOCOL", help="A TOML file, or a shipped one such as smoke.")
]


def output_path(text: str | Path) -> Path:
    """Return where results go; an empty text, such as that of an unset variable, is no place.

    Raises
    ------
    typer.BadParameter
        Which the command line tells with the option's name.
    """
    if not str(text).strip():
        raise typer.BadParameter("it is empty; write where the results go, . for this folder")
    return Path(text)


def output_option(*names: str, help: str) -> Any:  # noqa: A002 - as typer calls it
    """Return the option of a command for a path that it writes to (:func:`output_path`)."""
    return typer.Option(*names, parser=output_path, metavar="PATH", help=help)


StudyFolder = Annotated[
    Path, output_option("--out", help="The study folder; made if it is not there.")
]
TraceOption = Annotated[
    Path | None, typer.Option(help="Head trace (CSV); without it, the walk shipped with the scene.")
]
ExposureOption = Annotated[
    float | None,
    typer.Option(
        help="Shorten every exposure to this, at most the protocol's exposure_s; recorded.",
        min=0.001,
    ),
]
RefreshRate = Annotated[
    float | None, typer.Option(help="Display rate; without it, the trace's own.", min=0.1)
]

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


def parse_size(text: str) -> tuple[int, int]:
    """Read ``WIDTHxHEIGHT`` in pixels.

    Raises
    ------
    InputError
        If it is not two positive whole numbers, or larger than any headset's eye.
    """
    width, _, height = (side.lstrip("0") for side in text.lower().partition("x"))
    given = text if len(text) <= 40 else f"{text[:40]}…"
    if not (width.isdecimal() and height.isdecimal()):
        raise InputError(f"--size {given!r} is not a size; write WIDTHxHEIGHT, for example 640x800")
    if max(len(width), len(height)) > 4 or max(int(width), int(height)) > 8192:
        raise InputError(
            f"--size {given!r} has a side of more than 8192 pixels; choose a smaller one"
        )
    return int(width), int(height)


def output_folder(path: Path) -> Path:
    """Make the folder for results that can be made again; its old files are replaced.

    Raises
    ------
    InputError
        If `path` is a file, takes no files, or holds recordings, which are never overwritten.
    """
    if path.exists() and not path.is_dir():
        raise InputError("is a file; --out needs a folder", file=path)
    _refuse_recordings(path)
    path.mkdir(parents=True, exist_ok=True)
    if not os.access(path, os.W_OK):  # now, and not after minutes of work
        raise InputError("cannot be written to; choose another --out", file=path)
    return path


def output_file(path: Path, source: Path) -> Path:
    """Return `path` for what is made of `source` and can be made again; an old one is replaced.

    Raises
    ------
    InputError
        If it would lie among recordings, or is the source itself.
    """
    _refuse_recordings(path.resolve().parent)  # where a link leads
    spare([source], [path])
    return path


def _refuse_recordings(folder: Path) -> None:
    if any((folder / name).exists() for name in ("participants.csv", "manifest.json")):
        message = "is a study folder, or a session of one; choose another --out for the results"
        raise InputError(message, file=folder)


def _escape(text: str) -> str:
    return text.replace("[", r"\[")
