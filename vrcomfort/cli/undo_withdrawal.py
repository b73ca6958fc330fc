"""`undo-withdrawal`: takes back a withdrawal that was a slip of the hand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Quiet
from vrcomfort.cli.terminal import console


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("undo-withdrawal")(undo_withdrawal)


def undo_withdrawal(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="The study folder.")],
    participant: Annotated[str, typer.Argument(metavar="PARTICIPANT", help="Such as P01.")],
    reason: Annotated[str, typer.Option(help="Why; it is kept with the date.")],
    quiet: Quiet = False,
) -> None:
    """Let a participant go on who was withdrawn by mistake.

    They are enrolled again, and the session that ended so can be resumed. Rows and events stay as
    they are; the reason stands in participants.csv and in the session's manifest.

    - `vrcomfort undo-withdrawal my_study P01 --reason "pressed q instead of 1"`
    """
    from vrcomfort.records import undo_withdrawal as undo

    ended = undo(study, participant, reason)
    then = "the next session can be run"
    if ended is not None:
        then = f"session {ended} can be continued: vrcomfort run ... --resume"
    console(quiet).print(f"{participant} is enrolled again; {then}")
