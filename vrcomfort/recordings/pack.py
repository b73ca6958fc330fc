"""Packs the recordings of a study: Parquet beside each CSV, whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import duckdb

from vrcomfort.errors import InputError
from vrcomfort.files import open_file
from vrcomfort.records.checksums import CHECKSUMS, update_checksums
from vrcomfort.records.disk import (
    OWNER,
    access_like,
    only_program,
    refuse_links,
    refused,
    sync_folder,
)
from vrcomfort.records.exposure_rows import RatingRow
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.recording import (
    FORMS,
    LONG_BYTES,
    Fingerprint,
    Memory,
    Recording,
    column,
    csv_header,
    damage_of,
    half_written,
    is_altered,
    kinds,
    packed_facts,
    parquet_of,
    quoted,
)

ROWS_IN_A_GROUP = 30_720
"""Of the Parquet file: a group of all 70 columns takes 17 MB while it is written."""


@dataclass(frozen=True)
class Packed:
    """The result of packing one recording.

    Parameters
    ----------
    new
        False where a Parquet file of this CSV was there already.
    half_written
        Whether the last row was cut off; it is in no Parquet file.
    """

    csv: Path
    parquet: Path
    new: bool
    half_written: bool


def pack_study(
    study: Path,
    memory: Memory,
    work: Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[Any]] = map,
) -> Iterator[Packed]:
    """Pack the recordings of a folder; yield each when it is on the disk.

    They are every ``frames.csv`` and ``gaze.csv``, and each ``ratings.csv`` of at least
    `LONG_BYTES`.

    Parameters
    ----------
    work
        Calls a function for every recording: `map`, or that of `vrcomfort.workers`.

    Raises
    ------
    InputError
        If there is none; or at the first that is damaged, with its place, or is being written.
        What was packed before stays; the damaged recording has no Parquet file, or its old one.
    """
    for done in work(partial(pack, study, memory), recordings_in(study)):
        folder = done.csv.parent
        if done.new and (folder / CHECKSUMS).exists():
            update_checksums(folder, [done.parquet.name], access_like(folder / CHECKSUMS))
        yield done


def recordings_in(study: Path) -> list[Path]:
    """Return every ``frames.csv``, ``gaze.csv`` and long ``ratings.csv`` of a folder.

    Raises
    ------
    InputError
        If there is none, or no such folder.
    """
    if not study.is_dir():
        raise InputError("there is no such folder", file=study)
    least = {FrameRow.FILE: 0, GazeRow.FILE: 0, RatingRow.FILE: LONG_BYTES}
    found = sorted(
        file
        for name, size in least.items()
        for file in study.rglob(name)
        if file.stat().st_size >= size
    )
    if not found:
        long = f"or {RatingRow.FILE} of more than {LONG_BYTES / 1e6:.0f} MB"
        message = f"there is no {FrameRow.FILE}, {GazeRow.FILE} {long} in this folder"
        raise InputError(message, file=study)
    return found


def pack(study: Path, memory: Memory, csv: Path) -> Packed:
    """Write the Parquet file of one recording; the old one is there until the new one is whole.

    Raises
    ------
    InputError
        If the recording is damaged or is being written, or the disk refuses.
    """
    packed = parquet_of(csv)
    refuse_links(study, packed)
    with _nobody_writes(csv):
        fingerprint = Fingerprint.of(csv)
        cut = half_written(csv)
        same = packed.is_file() and packed_facts(packed) == fingerprint.facts
        if same and not is_altered(packed):
            return Packed(csv, packed, new=False, half_written=cut)
        draft = packed.with_name(f".{packed.name}.new")
        try:
            draft.unlink(missing_ok=True)  # that of a program that was killed
            _write(csv, draft, fingerprint, memory)
            if Fingerprint.of(csv) != fingerprint:
                raise InputError("has changed while it was packed; try again", file=csv)
            _put(draft, packed, csv)
        except OSError as error:
            raise refused(packed, error) from error
        finally:
            draft.unlink(missing_ok=True)
    return Packed(csv, packed, new=True, half_written=cut)


@contextmanager
def _nobody_writes(csv: Path) -> Iterator[None]:
    """Hold the lock of the recording's participant, where there is one."""
    lock = csv.parent.parent / "lock"
    who = csv.parent.parent.name.removeprefix("sub-")
    held = only_program(lock, OWNER, doing=f"{who} is being run")
    with held if lock.is_file() else nullcontext():
        yield


def _write(csv: Path, draft: Path, fingerprint: Fingerprint, memory: Memory) -> None:
    """Write all rows, and check that numbers are finite and times rise.

    Raises
    ------
    InputError
        With the place of the first cell that cannot be.
    """
    facts = ", ".join(f"{name}: {quoted(value)}" for name, value in fingerprint.facts.items())
    options = f"FORMAT parquet, COMPRESSION zstd, ROW_GROUP_SIZE {ROWS_IN_A_GROUP}"
    recording = Recording(csv)
    with memory.database() as database, recording.told_with_its_place():
        with recording.table() as (table, _):
            try:
                database.execute(
                    f"COPY (SELECT * FROM {table}) TO {quoted(draft)} "  # noqa: S608
                    f"({options}, USE_TMP_FILE false, KV_METADATA {{{facts}}})"
                )
            except duckdb.IOException as error:
                first = str(error).splitlines()[0]
                raise InputError(f"cannot be written: {first}", file=parquet_of(csv)) from error
        if not _is_sound(database, draft, csv.name, csv_header(csv)):
            raise damage_of(csv, "a number is missing or not finite, or time goes back")


def _is_sound(
    database: duckdb.DuckDBPyConnection, packed: Path, file: str, header: tuple[str, ...]
) -> bool:
    """Return whether no cell is missing, all numbers are finite, and time goes on."""
    form = FORMS[file]
    numbers = [column(name) for name, kind in kinds(header, file).items() if kind == "DOUBLE"]
    sound = [f"coalesce(isfinite({name}), true)" for name in numbers]
    sound += [f"{column(name)} IS NOT NULL" for name in header if name in form.filled]
    if form.rising:
        sound.append(f"{form.rising} > lag({form.rising}, 1, {form.rising} - 1) OVER ()")
    row = database.execute(
        f"SELECT count(*) FILTER (NOT coalesce(sound, false)) FROM "  # noqa: S608
        f"(SELECT {' AND '.join(sound)} AS sound FROM read_parquet({quoted(packed)}))"
    ).fetchone()
    return row is not None and row[0] == 0


def _put(draft: Path, packed: Path, csv: Path) -> None:
    """Make the draft the packed file, for the same readers as the CSV."""
    draft.chmod(stat.S_IMODE(csv.stat().st_mode))
    with open_file(draft) as stream:
        os.fsync(stream.fileno())
    draft.replace(packed)
    sync_folder(packed.parent)
