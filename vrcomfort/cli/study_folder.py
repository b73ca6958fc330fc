"""`status`, `verify`, `pack`, `anonymise`, `export`: a study's folder, checked and shared."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from vrcomfort.cli.options import (
    AcceptFlaggedOption,
    Json,
    MemoryOption,
    Quiet,
    StudyArgument,
    WithoutOption,
    output_option,
)
from vrcomfort.cli.terminal import answer, conclude, console, progress_bar, warn
from vrcomfort.plurals import counted

if TYPE_CHECKING:
    from vrcomfort.exchange.status import SessionState, StudyState
    from vrcomfort.exchange.verifying import Verified


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(status)
    app.command()(verify)
    app.command()(pack)
    app.command()(anonymise)
    app.command()(export)


def status(
    study: StudyArgument,
    as_json: Json = False,
) -> None:
    """Show a study's participants, next steps and disk usage.

    - `vrcomfort status my_study`
    - `vrcomfort status my_study --json`
    """
    from vrcomfort.exchange.status import status_of

    state = status_of(study)
    if as_json:
        answer(asdict(state))
        return
    _show_status(state)


def _show_status(state: StudyState) -> None:
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
    for sentence in state.differences:
        warn(sentence)


def _session(session: SessionState) -> str:
    of = "" if session.planned is None else f" of {session.planned}"
    flags = f", {session.flagged} flagged" if session.flagged else ""
    many = session.exposures if session.planned is None else session.planned
    exposures = f"{session.exposures}{of} {'exposure' if many == 1 else 'exposures'}"
    return f"{session.number}: {session.status}, {exposures}{flags}"


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


EXIT_FAULTS = 1  # not 2: the command was typed well, and the study has faults


def verify(
    study: StudyArgument,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Check the integrity of a study folder: files, rows, ids, times, checksums.

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
    numbers = ", ".join(counted(count, what) for what, count in found.counts.items())
    verdict = "nothing is wrong"
    if found.faults:
        things = "1 thing is" if len(found.faults) == 1 else f"{len(found.faults)} things are"
        verdict = f"{things} wrong"
    console(quiet and not found.faults).print(f"{found.study}: {verdict}. Counted: {numbers}")


def pack(
    study: Annotated[
        Path, typer.Argument(metavar="STUDY", help="A study folder, or one inside it.")
    ],
    memory: MemoryOption = "512MB",
    jobs: Annotated[
        int, typer.Option(help="Number of processes; each may use --memory.", min=1)
    ] = 1,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write Parquet files beside frames.csv, gaze.csv and long ratings.csv: faster reports.

    Reports then read these, which is faster. The CSV files stay the record: a Parquet file whose
    CSV has changed is not read until `pack` is run again. A damaged recording is not packed.

    - `vrcomfort pack my_study`
    """
    from vrcomfort.recordings import pack_study, recordings_in
    from vrcomfort.records.recording import Memory
    from vrcomfort.workers import workers

    limit = Memory.of_text(memory)
    total, done = len(recordings_in(study)), []
    bar = progress_bar("packed", total, quiet=quiet or as_json, unit="recordings")
    with bar as advance, workers(jobs, None) as work:
        for each in pack_study(study, limit, work):
            done.append(each)
            advance()
    for each in done:
        if each.half_written:
            warn(f"{each.csv}: the last row is half-written and was left out")
    new = [each for each in done if each.new]
    before, after = _megabytes(e.csv for e in new), _megabytes(e.parquet for e in new)
    told = f"Packed: {len(new)} of {len(done)} recordings, {before:.1f} MB into {after:.1f} MB"
    facts = {"recordings": len(done), "packed": [str(each.parquet) for each in new]}
    sentence = f"{told}; {len(done) - len(new)} were packed before"
    conclude(sentence, facts, quiet=quiet, as_json=as_json)


def _megabytes(files: Iterable[Path]) -> float:
    return sum(file.stat().st_size for file in files) / 1e6


class DateChoice(StrEnum):
    """Treatments of dates."""

    SHIFT = "shift"
    REMOVE = "remove"


def anonymise(
    study: StudyArgument,
    out: Annotated[Path, output_option("--out", help="A new folder for the anonymous copy.")],
    dates: Annotated[
        DateChoice,
        typer.Option(help="shift: keep times between sessions; remove: drop them as well."),
    ] = DateChoice.SHIFT,
    keep_motion: Annotated[
        bool,
        typer.Option("--keep-motion", help="Keep head and hand motion, which identifies people."),
    ] = False,
    keep_gaze: Annotated[
        bool, typer.Option("--keep-gaze", help="Keep gaze, which identifies people.")
    ] = False,
    key: Annotated[
        Path | None,
        output_option("--key", help="File for the key of old and new ids, outside both folders."),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Seed of the new ids, stored nowhere; it can reverse them."),
    ] = None,
    without: WithoutOption = None,
    accept_flagged: AcceptFlaggedOption = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Copy a study with new ids and dates, without notes, head motion and gaze.

    The study itself is not changed. What was done stands in the copy's anonymised.json.

    - `vrcomfort anonymise my_study --out shared`
    - `vrcomfort anonymise my_study --out shared --key ../keys/my_study.csv`
    - `vrcomfort anonymise my_study --out shared --keep-motion --dates remove`
    """
    from vrcomfort.exchange.anonymising import RECORD, AnonymisingOptions
    from vrcomfort.exchange.anonymising import anonymise as copy
    from vrcomfort.records.choice import Choice

    choice = Choice.of_texts(without, accept_flagged=accept_flagged)
    options = AnonymisingOptions(seed, dates.value, keep_motion, keep_gaze, key)
    record = copy(study, out, options, choice)
    still = record["still_there"]
    for what in still["people_are_recognised_by"]:
        warn(f"{what} is kept: people can be recognised by it")
    smallest = still["smallest_group_with_the_same_covariates"]
    if smallest is not None:
        names = ", ".join(still["covariates"])
        warn(f"covariates are kept ({names}): the smallest group alike in them is of {smallest}")
    for name in record["events_not_known"]:
        warn(f"details of events `{name}` are left out: this version does not know them")
    sentence = f"{out}: what was done stands in {out / RECORD}"
    conclude(sentence, {"study": str(out), **record}, quiet=quiet, as_json=as_json)


class Format(StrEnum):
    """Formats of an exported study."""

    BIDS = "bids"
    PSYCH_DS = "psych-ds"


def export(
    study: StudyArgument,
    format_: Annotated[
        Format,
        typer.Option("--format", help="bids: BIDS 1.11.1; psych-ds: Psych-DS 1.5.1, tables alone."),
    ],
    out: Annotated[Path, output_option("--out", help="A new folder for the dataset.")],
    without: WithoutOption = None,
    accept_flagged: AcceptFlaggedOption = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Export a study as BIDS (motion, gaze, events, answers) or Psych-DS (tables).

    Head motion and gaze identify people, and dates are the study's: anonymise it first, where the
    dataset is to be shared.

    - `vrcomfort export my_study --format bids --out my_study_bids`
    - `vrcomfort export my_study --format psych-ds --out my_study_psych_ds`
    """
    from vrcomfort.exchange.bids import export_bids
    from vrcomfort.exchange.psych_ds import export_psych_ds
    from vrcomfort.records.choice import Choice

    write = export_bids if format_ is Format.BIDS else export_psych_ds
    choice = Choice.of_texts(without, accept_flagged=accept_flagged)
    left_out = list(write(study, out, choice))
    for sentence in left_out:
        warn(f"left out: {sentence}")
    facts = {"dataset": str(out), "format": format_.value, "left_out": left_out}
    sentence = f"{out}: a dataset in {format_.value}; its README.md says what is where"
    conclude(sentence, facts, quiet=quiet, as_json=as_json)
