"""`verify`: says whether a study folder is whole."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vrcomfort.cli.options import Json, Quiet
from vrcomfort.cli.terminal import answer, console, progress_bar

if TYPE_CHECKING:
    from vrcomfort.exchange.verifying import Verified

EXIT_FAULTS = 1


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(verify)


def verify(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="The study folder.")],
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Check that a study folder is whole: files, rows, ids, times, checksums. Changes nothing.

    Each finding is a line with its place and what to do. Exit code 1 where something is wrong.

    - `vrcomfort verify my_study`
    - `vrcomfort verify my_study --json`
    """
    from vrcomfort.exchange.verifying import verify_study
    from vrcomfort.exchange.verifying.study import session_folders

    total = len(session_folders(study))
    with progress_bar("verified", total, quiet=quiet or as_json, unit="sessions") as advance:
        found = verify_study(study, advance)
    if as_json:
        answer(
            {
                "study": str(study),
                "whole": not found.faults,
                "faults": [asdict(each) for each in found.faults],
                "notes": [asdict(each) for each in found.notes],
                "counts": dict(sorted(found.counts.items())),
            }
        )
    else:
        _show(found, quiet=quiet)
    if found.faults:
        raise typer.Exit(EXIT_FAULTS)


def _show(found: Verified, *, quiet: bool) -> None:
    for fault in found.faults:
        console().print(f"wrong: {fault}")
    for note in found.notes:
        console(quiet).print(f"note: {note}", style="dim")
    counted = ", ".join(f"{count} {what}" for what, count in found.counts.items())
    verdict = "nothing is wrong"
    if found.faults:
        things = "1 thing is" if len(found.faults) == 1 else f"{len(found.faults)} things are"
        verdict = f"{things} wrong"
    console(quiet and not found.faults).print(f"{found.study}: {verdict}. Counted: {counted}")
