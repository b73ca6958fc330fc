"""``preflight.json``: the checks of a study before people come, and whether they still hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from vrcomfort.errors import InputError
from vrcomfort.json_text import json_of
from vrcomfort.records.apparatus import apparatus_of
from vrcomfort.records.disk import Access, make_folders, replace_text
from vrcomfort.records.json_file import PreflightShape, read_shape
from vrcomfort.records.schema import SCHEMA_VERSION

FILE = "preflight.json"


def write_preflight(study: Path, content: Mapping[str, Any], access: Access) -> Path:
    """Write the checks into a study's folder, which is made if it is not there; return the file.

    Raises
    ------
    InputError
        If the folder cannot be made or written.
    """
    try:
        make_folders(study, study, access)
    except OSError as error:
        message = f"cannot make this study folder: {error.strerror}; choose another output folder"
        raise InputError(message, file=study) from error
    text = json_of({"schema_version": SCHEMA_VERSION, **content})
    replace_text(study / FILE, text + "\n", access)
    return study / FILE


def read_preflight(study: Path) -> PreflightShape | None:
    """Return the last checks of a study; None where there were none.

    Raises
    ------
    InputError
        If the file is damaged, with its place.
    """
    file = study / FILE
    return read_shape(file, PreflightShape, "preflight") if file.exists() else None


def why_again(
    done: PreflightShape | None, *, protocol_sha256: str, headset: str, run: Mapping[str, Any]
) -> str:
    """Return why a session asks for other checks than those `done`; empty where they hold.

    Parameters
    ----------
    headset
        Kind of the headset, as the command line has it.
    run
        Facts of the run that is about to begin (`apparatus.facts_now`).
    """
    if done is None:
        return "there was no preflight of this study"
    day, today = (each.astimezone().date() for each in (_moment(done), datetime.now(UTC)))
    if day != today:
        return f"the last preflight was on {day.isoformat()}, and not today"
    if done.protocol.sha256 != protocol_sha256:
        return "the protocol has changed since the last preflight"
    return next(_changes(done, headset, run), "")


def _moment(done: PreflightShape) -> datetime:
    return datetime.fromisoformat(done.at)


def _changes(done: PreflightShape, headset: str, run: Mapping[str, Any]) -> Iterator[str]:
    if done.headset != headset:
        yield f"the last preflight was with --headset {done.headset}"
    for fact, value in apparatus_of(run).items():
        before = done.apparatus.get(fact)
        if before is not None and before != value:
            yield f"the {fact} was {before} in the last preflight, and is {value} now"
    if done.rehearsed:
        yield "the last preflight was a rehearsal, without the headset"
    if done.outcome == "refuse":
        parts = ", ".join(each.part for each in done.findings if each.outcome == "refuse")
        yield f"the last preflight found what stands in the way ({parts})"
