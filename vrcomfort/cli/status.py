"""`status`: who is where in a study, and what is next."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from vrcomfort.cli.options import Json
from vrcomfort.cli.terminal import answer, console

if TYPE_CHECKING:
    from vrcomfort.exchange.status import SessionState, StudyState


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(status)


def status(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="The study folder.")],
    as_json: Json = False,
) -> None:
    """Show who is where in a study, what is next for each and for the study, and the disk.

    - `vrcomfort status my_study`
    - `vrcomfort status my_study --json`
    """
    from vrcomfort.exchange.status import status_of

    state = status_of(study)
    if as_json:
        answer(asdict(state))
        return
    _show(state)


def _show(state: StudyState) -> None:
    table = Table(title=f"{state.name} ({state.protocol})", title_justify="left")
    for column in ("participant", "status", "sequence", "sessions", "next"):
        table.add_column(column)
    for person in state.people:
        group = f" ({person.group})" if person.group else ""
        sessions = "\n".join(map(_session, person.sessions)) or "none yet"
        place = f"{person.sequence}{group}"
        table.add_row(person.participant, person.status, place, sessions, person.next or "nothing")
    console(wrap=True).print(table)
    out = console()
    for person in state.people:
        if person.command:
            out.print(f"{person.participant}, {person.next}: {person.command}")
        for session in person.sessions:
            if session.fault:
                out.print(f"{person.participant}, session {session.number}: {session.fault}")
    out.print(_people(state))
    out.print(f"Next new participant: {_next(state)}")
    out.print(_disk(state))


def _session(session: SessionState) -> str:
    of = "" if session.planned is None else f" of {session.planned}"
    flags = f", {session.flagged} flagged" if session.flagged else ""
    return f"{session.number}: {session.status}, {session.exposures}{of} exposures{flags}"


def _people(state: StudyState) -> str:
    counted = ", ".join(f"{count} {name}" for name, count in state.statuses.items()) or "nobody yet"
    planned = f" of {state.participants_planned} planned" if state.participants_planned else ""
    places = "" if state.places is None else f"; {state.places}{planned} take a place"
    return f"Participants: {counted}{places}"


def _next(state: StudyState) -> str:
    if state.next_sequence is None:
        return state.not_known
    group = f" in group {state.next_group}" if state.next_group else ""
    return f"sequence {state.next_sequence}{group}"


def _disk(state: StudyState) -> str:
    sessions = sum(len(person.sessions) for person in state.people)
    each = f", {_size(state.bytes_used / sessions)} a session" if sessions else ""
    versions = ", ".join(f"{name} ({count})" for name, count in state.versions.items()) or "none"
    schemas = ", ".join(f"{name} ({count})" for name, count in state.schema_versions.items())
    schemas = schemas or "none"
    return (
        f"Disk: {_size(state.bytes_used)}{each}; {_size(state.bytes_free)} free. "
        f"Recorded with vrcomfort {versions}, schema {schemas}; this is {state.vrcomfort}"
    )


def _size(size_bytes: float) -> str:
    for unit in ("bytes", "kB", "MB", "GB"):
        if size_bytes < 1000:
            return f"{size_bytes:.3g} {unit}"
        size_bytes /= 1000
    return f"{size_bytes:.3g} TB"
