"""`exclude`, `undo-exclusion`, `undo-withdrawal`, `note`: decisions on a participant."""

from __future__ import annotations

from typing import Annotated

import typer

from vrcomfort.cli.options import Quiet, StudyArgument
from vrcomfort.cli.terminal import console

Participant = Annotated[str, typer.Argument(metavar="PARTICIPANT", help="Such as P01.")]
Reason = Annotated[str, typer.Option(help="Why; it is kept with the date.")]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(exclude)
    app.command("undo-exclusion")(undo_exclusion)
    app.command("undo-withdrawal")(undo_withdrawal)
    app.command()(note)


def exclude(
    study: StudyArgument, participant: Participant, reason: Reason, quiet: Quiet = False
) -> None:
    """Keep a participant out of all analyses.

    What was recorded stays; reports count them among those who were excluded. The reason stands in
    participants.csv.

    - `vrcomfort exclude my_study P01 --reason "fell asleep in the second exposure"`
    """
    from vrcomfort.records.participants import exclude as leave_out

    leave_out(study, participant, reason)
    console(quiet).print(f"{participant} is excluded; vrcomfort undo-exclusion takes it back")


def undo_exclusion(
    study: StudyArgument, participant: Participant, reason: Reason, quiet: Quiet = False
) -> None:
    """Take the exclusion of a participant back.

    - `vrcomfort undo-exclusion my_study P01 --reason "it was P10 who fell asleep"`
    """
    from vrcomfort.records.participants import undo_exclusion as undo

    status = undo(study, participant, reason)
    console(quiet).print(f"{participant} is {status} again")


def note(
    study: StudyArgument,
    participant: Participant,
    text: Annotated[str, typer.Argument(metavar="TEXT", help="What is to be noted.")],
    quiet: Quiet = False,
) -> None:
    """Add a note on a participant to participants.csv, with its date.

    - `vrcomfort note my_study P01 "wears glasses of -3 D"`
    """
    from vrcomfort.records.participants import add_note

    add_note(study, participant, text)
    console(quiet).print(f"noted of {participant}")


def undo_withdrawal(
    study: StudyArgument, participant: Participant, reason: Reason, quiet: Quiet = False
) -> None:
    """Take back the withdrawal of a participant that was a mistake.

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
