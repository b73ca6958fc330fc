"""`exclude`, `undo-exclusion`, `note`: what an experimenter says of a participant."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Quiet
from vrcomfort.cli.terminal import console

Study = Annotated[Path, typer.Argument(metavar="STUDY", help="The study folder.")]
Participant = Annotated[str, typer.Argument(metavar="PARTICIPANT", help="Such as P01.")]
Reason = Annotated[str, typer.Option(help="Why; it is kept with the date.")]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("exclude")(exclude)
    app.command("undo-exclusion")(undo_exclusion)
    app.command("note")(note)


def exclude(study: Study, participant: Participant, reason: Reason, quiet: Quiet = False) -> None:
    """Keep a participant out of all analyses.

    What was recorded stays; reports count them among those who were excluded. The reason stands in
    participants.csv.

    - `vrcomfort exclude my_study P01 --reason "fell asleep in the second exposure"`
    """
    from vrcomfort.records.exclusion import exclude as leave_out

    leave_out(study, participant, reason)
    console(quiet).print(f"{participant} is excluded; vrcomfort undo-exclusion takes it back")


def undo_exclusion(
    study: Study, participant: Participant, reason: Reason, quiet: Quiet = False
) -> None:
    """Take the exclusion of a participant back.

    - `vrcomfort undo-exclusion my_study P01 --reason "it was P10 who fell asleep"`
    """
    from vrcomfort.records.exclusion import undo_exclusion as undo

    status = undo(study, participant, reason)
    console(quiet).print(f"{participant} is {status} again")


def note(
    study: Study,
    participant: Participant,
    text: Annotated[str, typer.Argument(metavar="TEXT", help="What is to be noted.")],
    quiet: Quiet = False,
) -> None:
    """Add a note on a participant to participants.csv, with its date.

    - `vrcomfort note my_study P01 "wears glasses of -3 D"`
    """
    from vrcomfort.records.exclusion import add_note

    add_note(study, participant, text)
    console(quiet).print(f"noted of {participant}")
