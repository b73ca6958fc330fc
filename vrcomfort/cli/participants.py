"""`exclude`, `undo-exclusion`, `undo-withdrawal`, `note`: decisions on a participant."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from vrcomfort.cli.options import Json, Quiet, StudyArgument
from vrcomfort.cli.terminal import conclude, warn
from vrcomfort.errors import InputError
from vrcomfort.plurals import counted

Participant = Annotated[
    str, typer.Argument(metavar="PARTICIPANT", help="Participant id, such as P01.")
]
Reason = Annotated[str, typer.Option(help="Reason, kept with the date.")]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(exclude)
    app.command("undo-exclusion")(undo_exclusion)
    app.command("undo-withdrawal")(undo_withdrawal)
    app.command()(note)
    app.command()(erase)


def exclude(
    study: StudyArgument,
    participant: Participant,
    reason: Reason,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Exclude a participant from all analyses.

    What was recorded stays; reports count them among those who were excluded. The reason stands in
    participants.csv.

    - `vrcomfort exclude my_study P01 --reason "fell asleep in the second exposure"`
    """
    from vrcomfort.records.participants import exclude as leave_out

    leave_out(study, participant, reason)
    sentence = f"{participant} is excluded; vrcomfort undo-exclusion takes it back"
    facts = {"participant": participant, "status": "excluded"}
    conclude(sentence, facts, quiet=quiet, as_json=as_json)


def undo_exclusion(
    study: StudyArgument,
    participant: Participant,
    reason: Reason,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Undo the exclusion of a participant.

    - `vrcomfort undo-exclusion my_study P01 --reason "it was P10 who fell asleep"`
    """
    from vrcomfort.records.participants import undo_exclusion as undo

    status = undo(study, participant, reason)
    facts = {"participant": participant, "status": status}
    conclude(f"{participant} is {status} again", facts, quiet=quiet, as_json=as_json)


def note(
    study: StudyArgument,
    participant: Participant,
    text: Annotated[str, typer.Argument(metavar="TEXT", help="Text of the note.")],
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Add a note on a participant to participants.csv, with its date.

    - `vrcomfort note my_study P01 "wears glasses of -3 D"`
    """
    from vrcomfort.records.participants import add_note

    add_note(study, participant, text)
    facts = {"participant": participant, "note": text}
    conclude(f"noted of {participant}", facts, quiet=quiet, as_json=as_json)


def erase(
    study: StudyArgument,
    participant: Participant,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Ask nothing at the terminal.")] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Delete all data of a participant on request. This cannot be undone.

    A row with a new name, the order and the day of the erasure stays in participants.csv, so that
    the orders of the next participants stay balanced.

    - `vrcomfort erase my_study P07`
    """
    from vrcomfort.records.erasure import erase as delete

    if not yes and not sys.stdin.isatty():
        raise InputError(f"there is no terminal to ask at; --yes erases {participant} unasked")
    if not yes:
        question = f"Delete all data of {participant} in {study}? This cannot be undone"
        typer.confirm(question, default=False, abort=True, err=True)
    done = delete(study, participant)
    for file in done.mentions:
        warn(f"{study / file} still names {participant}; make it again, mend it, or delete it")
    row = f" {done.row} is the row that stays in participants.csv." if done.row else ""
    sentence = f"{participant} is erased, with {counted(done.sessions, 'sessions')}.{row}"
    facts = {
        "participant": participant,
        "sessions": done.sessions,
        "row": done.row,
        "still_named_in": [str(file) for file in done.mentions],
    }
    conclude(sentence, facts, quiet=quiet, as_json=as_json)
    warn(
        "not reached: reports, exports, copies and keys outside of this folder, backups, "
        "recordings of other programs, and what a disk keeps of deleted files"
    )


def undo_withdrawal(
    study: StudyArgument,
    participant: Participant,
    reason: Reason,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Undo a mistaken withdrawal of a participant.

    They are enrolled again, and the session that ended so can be resumed. Rows and events stay as
    they are; the reason stands in participants.csv and in the session's manifest.

    - `vrcomfort undo-withdrawal my_study P01 --reason "pressed q instead of 1"`
    """
    from vrcomfort.records import undo_withdrawal as undo

    ended = undo(study, participant, reason)
    then = "the next session can be run"
    if ended is not None:
        then = f"session {ended} can be continued: vrcomfort run ... --resume"
    facts = {"participant": participant, "status": "enrolled", "session_to_resume": ended}
    sentence = f"{participant} is enrolled again; {then}"
    conclude(sentence, facts, quiet=quiet, as_json=as_json)
