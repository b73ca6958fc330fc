"""Which file the rows of a recording are read from: the CSV, or a Parquet file that is of it."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import duckdb
import numpy as np
from numpy.typing import NDArray

from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.recordings.columns import Kind, kinds
from vrcomfort.recordings.damage import check_header, find_damage
from vrcomfort.recordings.memory import Memory, column, quoted

FORMAT = "1"
"""Of the packed files; others are packed anew."""
_BLOCK = 2**20
_TOO_SMALL = "does not fit into the memory allowed; give more with --memory"


@dataclass(frozen=True)
class Fingerprint:
    """By what a Parquet file knows its CSV."""

    size: int
    mtime_ns: int
    sha256: str

    @classmethod
    def of(cls, csv: Path) -> Fingerprint:
        """Return that of a file as it is now.

        Raises
        ------
        InputError
            If it changes meanwhile.
        """
        before = csv.stat()
        with csv.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
        after = csv.stat()
        if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
            message = "is being written to; wait until its session has ended"
            raise InputError(message, file=csv)
        return cls(after.st_size, after.st_mtime_ns, digest)

    @property
    def facts(self) -> dict[str, str]:
        """Return what stands in the Parquet file."""
        return {
            "format": FORMAT,
            "csv_size": str(self.size),
            "csv_mtime_ns": str(self.mtime_ns),
            "csv_sha256": self.sha256,
        }


@dataclass(frozen=True)
class Source:
    """Where the rows of a recording come from.

    Parameters
    ----------
    csv
        The record.
    parquet
        The file to read in its place, where there is one that is of it.
    note
        Why a Parquet file that is there is not read; blank otherwise.
    """

    csv: Path
    parquet: Path | None = None
    note: str = ""


def parquet_of(csv: Path) -> Path:
    """Return the path of the packed file of a recording."""
    return csv.with_suffix(".parquet")


def find_source(csv: Path) -> Source:
    """Return what to read of a recording: its Parquet file, unless the CSV has changed since.

    The CSV is hashed only where its size is the same and its time is not, as in a copied study.

    Raises
    ------
    InputError
        If the CSV is not there: a Parquet file alone is no record.
    """
    packed = parquet_of(csv)
    if not csv.is_file():
        raise InputError("this recording is missing; a Parquet file alone is no record", file=csv)
    if not packed.is_file():
        return Source(csv)
    said = packed_facts(packed)
    if said is None:
        return Source(csv, note=f"{packed}: not read, because it is damaged; {_again(csv)}")
    there = csv.stat()
    if said.get("format") != FORMAT:
        return Source(csv, note=f"{packed}: not read, because it is of another form; {_again(csv)}")
    if said.get("csv_size") != str(there.st_size) or (
        said.get("csv_mtime_ns") != str(there.st_mtime_ns)
        and said.get("csv_sha256") != Fingerprint.of(csv).sha256
    ):
        what = f"not read, because {csv.name} has changed since it was packed"
        return Source(csv, note=f"{packed}: {what}; {_again(csv)}")
    return Source(csv, packed)


def _again(csv: Path) -> str:
    return f"{csv.name} is read; run `vrcomfort pack` again"


def packed_facts(packed: Path) -> dict[str, str] | None:
    """Return what a Parquet file says of its CSV; None if it is damaged, {} if it says nothing."""
    connection = duckdb.connect()
    try:
        where = quoted(packed)
        connection.execute(f"SELECT count(*) FROM parquet_metadata({where})")  # noqa: S608
        rows = connection.execute(
            f"SELECT decode(key), decode(value) FROM parquet_kv_metadata({where})"  # noqa: S608
        ).fetchall()
    except duckdb.Error:
        return None
    finally:
        connection.close()
    return {str(key): str(value) for key, value in rows}


@contextmanager
def rows_of(source: Source) -> Iterator[tuple[str, dict[str, Kind]]]:
    """Give the table of a recording in SQL, and column → kind.

    Raises
    ------
    InputError
        If the header is not that of a recording.
    """
    header = csv_header(source.csv)
    if source.parquet is not None:
        yield f"read_parquet({quoted(source.parquet)})", kinds(header)
        return
    with _whole_rows(source.csv, len(header)) as file:
        yield csv_table(file, header), kinds(header)


def csv_header(csv: Path) -> tuple[str, ...]:
    """Return the header of a recording.

    Raises
    ------
    InputError
        If a column that makes it a recording is missing.
    """
    table = next(CsvTable.parts(csv, appended=True, most_rows=1))
    check_header(table)
    return table.header


def csv_table(file: Path, header: tuple[str, ...]) -> str:
    """Return the rows of a CSV file in SQL; whole numbers are read as text, as others round."""
    of = kinds(header)
    typed = ", ".join(
        f"{quoted(name)}: '{'VARCHAR' if of[name] == 'BIGINT' else of[name]}'" for name in header
    )
    options = "header = true, auto_detect = false, delim = ',', quote = '\"', escape = '\"'"
    table = f"read_csv({quoted(file)}, {options}, nullstr = '', columns = {{{typed}}})"
    cells = ", ".join(_whole(name) if of[name] == "BIGINT" else column(name) for name in header)
    return f"(SELECT {cells} FROM {table})"  # noqa: S608 - of names that are quoted


def _whole(name: str) -> str:
    cell = column(name)
    no = f"CASE WHEN {cell} IS NOT NULL THEN CAST(error('not a whole number') AS BIGINT) END"
    yes = f"regexp_full_match({cell}, ' *[+-]?[0-9]+ *')"
    return f"CASE WHEN {yes} THEN CAST({cell} AS BIGINT) ELSE {no} END AS {cell}"


@contextmanager
def _whole_rows(csv: Path, width: int) -> Iterator[Path]:
    """Give a file of the whole rows: the CSV itself, or a copy without a half-written last one."""
    end = _end_of_whole_rows(csv, width)
    if end == csv.stat().st_size:
        yield csv
        return
    with TemporaryDirectory(prefix="vrcomfort-") as folder:
        copy = Path(folder) / csv.name
        shutil.copyfile(csv, copy)
        os.truncate(copy, end)
        yield copy


def half_written(csv: Path) -> bool:
    """Return whether the last row was cut off, as where a program is ended while it writes."""
    return _end_of_whole_rows(csv, len(csv_header(csv))) != csv.stat().st_size


def _end_of_whole_rows(csv: Path, width: int) -> int:
    """Return where the last row that is as long as the header, and has its line end, ends."""
    size = csv.stat().st_size
    with csv.open("rb") as stream:
        stream.seek(max(size - _BLOCK, 0))
        tail = stream.read()
    start = size - len(tail)
    end = tail.rfind(b"\n") + 1
    last = tail[tail.rfind(b"\n", 0, max(end - 1, 0)) + 1 : end]
    whole = last.count(b",") + 1 >= width or not last.strip()
    return start + (end if whole else end - len(last))


@contextmanager
def told_with_its_place(source: Source) -> Iterator[None]:
    """Turn what the database says of a recording into one sentence with file, line and column.

    Raises
    ------
    InputError
        In place of any error of the database.
    """
    try:
        yield
    except duckdb.OutOfMemoryException as error:
        raise InputError(_TOO_SMALL, file=source.csv) from error
    except duckdb.Error as error:
        if source.parquet is not None:
            message = "cannot be read; remove it, and run `vrcomfort pack` again"
            raise InputError(message, file=source.parquet) from error
        raise damage_of(source.csv, str(error)) from error


def damage_of(csv: Path, otherwise: str) -> InputError:
    """Return what is wrong with a recording that could not be read."""
    first = otherwise.splitlines()[0] if otherwise else "nothing is said"
    return find_damage(csv) or InputError(f"this recording cannot be read: {first}", file=csv)


def read_columns(
    source: Source, names: tuple[str, ...], memory: Memory
) -> dict[str, NDArray[np.float64]]:
    """Return columns of numbers, whole, shape (rows,); NaN where a cell is blank.

    A column that the recording does not have is NaN throughout. Nanoseconds lose nothing below
    2⁵³, which is 104 days.

    Raises
    ------
    InputError
        If the recording is damaged, with its place.
    """
    with (
        told_with_its_place(source),
        memory.database() as database,
        rows_of(source) as (table, columns),
    ):
        cells = ", ".join(
            f"CAST({column(name) if name in columns else 'NULL'} AS DOUBLE) AS {column(name)}"
            for name in names
        )
        found = database.execute(f"SELECT {cells} FROM {table}").fetchnumpy()  # noqa: S608
    return {
        name: np.asarray(np.ma.filled(np.ma.asarray(found[name], np.float64), np.nan))
        for name in names
    }
