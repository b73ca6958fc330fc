"""Recordings of any length (frames, gaze, long ratings), read out of core with DuckDB.

The CSV is the record. A Parquet file beside it (`vrcomfort pack`) holds the same rows and is read
in its place as long as it is of that CSV. This module imports DuckDB: import it where a recording
is read, not where a session starts.
"""

from __future__ import annotations

import atexit
import math
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple, Self

import duckdb
import numpy as np
from numpy.typing import NDArray

from vrcomfort.csv_table import NOTHING, CsvTable, plain_digits
from vrcomfort.errors import InputError
from vrcomfort.escaping import escape_unprintable, is_utf8
from vrcomfort.files import open_file, sha256_of
from vrcomfort.records.checksums import CHECKSUMS, read_checksums
from vrcomfort.records.exposure_rows import RatingRow
from vrcomfort.records.frame_rows import FrameRow, GazeRow, gaze_columns
from vrcomfort.records.rows import Row, declared

_UNITS = {"MB": 10**6, "GB": 10**9, "MIB": 2**20, "GIB": 2**30}
_SIZE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(MB|GB|MIB|GIB)\s*", re.IGNORECASE)
_FOR_PYTHON_BYTES = 128 * 10**6
"""What the interpreter and its packages take, and what the database does not count of its own."""
# Twice what Python takes: the database has the other half.
_LEAST_BYTES = 256 * 10**6


@dataclass(frozen=True)
class Memory:
    """The most memory that a process which reads recordings takes, in bytes."""

    limit_bytes: int = 512 * 10**6

    @classmethod
    def of_text(cls, text: str) -> Memory:
        """Read a size such as ``512MB``.

        Raises
        ------
        InputError
            If it is none, or too little for any recording.
        """
        found = _SIZE.fullmatch(text)
        if found is None:
            raise InputError(f"--memory {text!r} is not a size; write for example 512MB or 2GB")
        size = int(float(found[1]) * _UNITS[found[2].upper()])
        if size < _LEAST_BYTES:
            raise InputError(
                f"--memory {text} is too little to read recordings; give 256MB or more"
            )
        return cls(size)

    @contextmanager
    def database(self) -> Iterator[duckdb.DuckDBPyConnection]:
        """Give a database in memory that keeps to the limit, and spills to the disk."""
        with tempfile.TemporaryDirectory(prefix="vrcomfort-") as folder:
            connection = self.connection(folder)
            try:
                yield connection
            finally:
                connection.close()

    def connection(self, folder: str) -> duckdb.DuckDBPyConnection:
        """Return a database in memory that keeps to the limit, and puts more into a folder.

        It works on one thread: its sums come out one way, and processes share the cores.
        """
        settings: dict[str, str | bool | int | float | list[str]] = {
            "memory_limit": f"{(self.limit_bytes - _FOR_PYTHON_BYTES) // 10**6}MB",
            "threads": 1,
            "temp_directory": folder,
            "preserve_insertion_order": True,
            "autoinstall_known_extensions": False,
            "autoload_known_extensions": False,
        }
        if not is_utf8(folder):
            message = "the folder for temporary files has a name that is not UTF-8; set TMPDIR"
            raise InputError(message, file=escape_unprintable(folder))
        connection = duckdb.connect(config=settings)
        connection.execute("SET enable_progress_bar = false")
        return connection


def quoted(text: str | Path) -> str:
    """Return a text as SQL writes it; a path that is not UTF-8 is replaced by a link to it.

    Raises
    ------
    InputError
        If no such link can be made; the database takes no other bytes.
    """
    if isinstance(text, Path) and not is_utf8(str(text)):
        text = _by_a_link(text)
    return "'" + str(text).replace("'", "''") + "'"


def _by_a_link(path: Path) -> Path:
    """Return a path to the same file, without folder names that are not UTF-8."""
    odd = next(each for each in (path, *path.parents) if not is_utf8(each.name))
    return _link_to(odd.absolute()) / path.relative_to(odd)


@cache
def _link_to(folder: Path) -> Path:
    """Return a link to a folder, which is there until the program ends."""
    place = Path(_until_exit().enter_context(tempfile.TemporaryDirectory(prefix="vrcomfort-")))
    link = place / "link"
    try:
        link.symlink_to(folder)
    except OSError as error:  # Windows, where that is a privilege
        message = "its name has characters that the database does not take; rename it"
        raise InputError(message, file=escape_unprintable(str(folder))) from error
    return link


def column(name: str) -> str:
    """Return the name of a column as SQL writes it."""
    return '"' + name.replace('"', '""') + '"'


Kind = Literal["BIGINT", "DOUBLE", "VARCHAR"]

_KINDS: Mapping[type, Kind] = {int: "BIGINT", float: "DOUBLE", str: "VARCHAR"}
TIME = "xr_time_ns"


@dataclass(frozen=True)
class RecordingForm:
    """The columns of the recordings of one name.

    Parameters
    ----------
    kinds
        Returns column → DuckDB type of the declared columns.
    needed
        Columns without which a file is no recording.
    filled
        Those of them that are blank in no row.
    rising
        The column of times that rise from row to row; blank where rows come in any order.
    words
        Whether NA, NaN and n/a stand for blank cells of numbers, as other programs write them.
    """

    kinds: Callable[[], Mapping[str, Kind]]
    needed: tuple[str, ...]
    filled: frozenset[str]
    rising: str = ""
    words: bool = False


def _kinds_of_frames() -> dict[str, Kind]:
    """Return those of frames and gaze: a file of either may have the other's columns."""
    return {each.name: _KINDS[each.type] for each in (*declared(FrameRow), *declared(GazeRow))}


def _kinds_of_ratings() -> dict[str, Kind]:
    """Return numbers alone: sessions, trials and codes may be words in tables of other origin."""
    return {"onset_s": "DOUBLE", "latency_s": "DOUBLE", "response": "DOUBLE"}


def _of_frames(row_type: type[Row], *needed: str) -> RecordingForm:
    known = {each.name: each for each in declared(row_type)}
    filled = (known[name] for name in needed)
    return RecordingForm(
        _kinds_of_frames,
        needed,
        frozenset(each.name for each in filled if not each.blank and not each.needs),
        rising=TIME,
    )


FORMS: Mapping[str, RecordingForm] = {
    FrameRow.FILE: _of_frames(
        FrameRow, "session_s", "xr_time_ns", "period_ns", "trial", "dropped", "discontinuity",
        "head_x_m", "head_y_m", "head_z_m", "head_qx", "head_qy", "head_qz", "head_qw",
    ),
    GazeRow.FILE: _of_frames(GazeRow, "session_s", "xr_time_ns", "valid", *gaze_columns()),
    RatingRow.FILE: RecordingForm(
        _kinds_of_ratings,
        ("participant", "onset_s", "response", "missed"),
        frozenset(["onset_s"]),
        words=True,
    ),
}  # fmt: skip
"""Name of the file → its form."""


def kinds(header: Iterable[str], file: str = FrameRow.FILE) -> dict[str, Kind]:
    """Return column → DuckDB type; columns that are not declared are text."""
    known = FORMS[file].kinds()
    return {name: known.get(name, "VARCHAR") for name in header}


LONG_BYTES = 2**20
"""Size from which on ratings are packed and read out of core; shorter ones are read as text."""
FORMAT = "1"
"""Of the packed files; others are packed anew."""
# No row is longer; the end of the last whole one is looked for in so many bytes.
_BLOCK = 2**20
_TOO_SMALL = "does not fit into the memory allowed; give more with --memory"


@dataclass(frozen=True)
class Fingerprint:
    """The identity of a CSV file, stored in its Parquet file."""

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
        digest = sha256_of(csv)
        after = csv.stat()
        if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
            message = "is being written to; wait until its session has ended"
            raise InputError(message, file=csv)
        return cls(after.st_size, after.st_mtime_ns, digest)

    @property
    def facts(self) -> dict[str, str]:
        """Return the identity as metadata of the Parquet file."""
        return {
            "format": FORMAT,
            "csv_size": str(self.size),
            "csv_mtime_ns": str(self.mtime_ns),
            "csv_sha256": self.sha256,
        }


class Categories(NamedTuple):
    """A column of words, as numbers: names are few, and rows are many.

    Parameters
    ----------
    codes
        (rows,) the place in `names` of each row's word; −1 where the cell is blank.
    names
        The words, in alphabetical order.
    """

    codes: NDArray[np.int32]
    names: tuple[str, ...]


@dataclass(frozen=True)
class Recording:
    """The frames, or the gaze, of one session; a file of millions of rows that is not loaded.

    Parameters
    ----------
    csv
        The record.
    parquet
        The file that is read in its place, where there is one that is of it.
    note
        Why a Parquet file that is there is not read; blank otherwise.
    """

    csv: Path
    parquet: Path | None = None
    note: str = ""

    @classmethod
    def find(cls, csv: Path) -> Self:
        """Return a recording: its Parquet file is read, unless the CSV has changed since.

        The CSV is hashed only where its size is the same and its time is not, as in a copied study;
        the Parquet file where its folder has a checksum of it.

        Raises
        ------
        InputError
            If the CSV is not there: a Parquet file alone is no record.
        """
        packed = parquet_of(csv)
        if not csv.is_file():
            message = "this recording is missing; a Parquet file alone is no record"
            raise InputError(message, file=csv)
        if not packed.is_file():
            return cls(csv)
        said = packed_facts(packed)
        if said is None:
            return cls(csv, note=_not_read(csv, "it is damaged"))
        there = csv.stat()
        if said.get("format") != FORMAT:
            return cls(csv, note=_not_read(csv, "it is of another form"))
        if said.get("csv_size") != str(there.st_size) or (
            said.get("csv_mtime_ns") != str(there.st_mtime_ns)
            and said.get("csv_sha256") != Fingerprint.of(csv).sha256
        ):
            return cls(csv, note=_not_read(csv, f"{csv.name} has changed since it was packed"))
        if is_altered(packed):
            return cls(csv, note=_not_read(csv, f"it is not as it was packed ({CHECKSUMS})"))
        return cls(csv, packed)

    @contextmanager
    def table(self) -> Iterator[tuple[str, dict[str, Kind]]]:
        """Give the rows in SQL, and column → kind.

        Raises
        ------
        InputError
            If the header is not that of a recording.
        """
        if self.parquet is not None:
            header = packed_header(self.parquet)
            yield f"read_parquet({quoted(self.parquet)})", kinds(header, self.csv.name)
            return
        header = csv_header(self.csv)
        with _whole_rows(self.csv, len(header)) as file:
            yield csv_table(file, header), kinds(header, self.csv.name)

    @contextmanager
    def told_with_its_place(self) -> Iterator[None]:
        """Turn an error of the database into one sentence with file, line and column.

        Raises
        ------
        InputError
            In place of any error of the database.
        """
        try:
            yield
        except duckdb.OutOfMemoryException as error:
            raise InputError(_TOO_SMALL, file=self.csv) from error
        except duckdb.Error as error:
            if self.parquet is not None:
                message = "cannot be read; remove it, and run `vrcomfort pack` again"
                raise InputError(message, file=self.parquet) from error
            raise damage_of(self.csv, str(error)) from error

    def columns(self, names: Sequence[str], memory: Memory) -> dict[str, NDArray[np.float64]]:
        """Return columns of numbers, whole, shape (rows,); NaN where a cell is blank.

        A column that the recording does not have is NaN throughout. Nanoseconds lose nothing below
        2⁵³, which is 104 days.

        Raises
        ------
        InputError
            If the recording is damaged, with its place.
        """
        with (
            self.told_with_its_place(),
            memory.database() as database,
            self.table() as (table, columns),
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

    def categories(self, name: str, memory: Memory) -> Categories | None:
        """Return a column of words, whole; None where the recording does not have it, or blanks.

        Raises
        ------
        InputError
            If the recording is damaged, with its place.
        """
        cell = column(name)
        with self.told_with_its_place(), self.table() as (table, columns):
            if name not in columns:
                return None
            with memory.database() as database:
                each = f"SELECT DISTINCT {cell} FROM {table} WHERE {cell} <> '' ORDER BY 1"  # noqa: S608
                words = [str(word) for (word,) in database.execute(each).fetchall()]
                if not words:
                    return None
                place = f"coalesce(list_position(?, {cell}), 0) - 1"
                query = f"SELECT CAST({place} AS INTEGER) AS place FROM {table}"  # noqa: S608
                found = database.execute(query, [words]).fetchnumpy()
        return Categories(np.asarray(found["place"], np.int32), tuple(words))


def is_altered(packed: Path) -> bool:
    """Return whether the checksums of its folder have a Parquet file as another one."""
    try:
        known = read_checksums(packed.parent).get(packed.name)
    except InputError:  # there is none; or it is damaged, which `vrcomfort verify` tells
        return False
    return known is not None and not known.fits(sha256_of(packed))


def _not_read(csv: Path, why: str) -> str:
    packed = parquet_of(csv)
    again = f"{csv.name} is read; run `vrcomfort pack` again"
    return f"{packed}: not read, because {why}; {again}"


def relation(
    recordings: Sequence[tuple[Recording, Mapping[str, str | int]]],
) -> duckdb.DuckDBPyRelation:
    """Return the rows of several recordings as one relation, which is read when it is asked.

    Parameters
    ----------
    recordings
        Each with the columns that tell its rows apart, such as participant and session: they come
        first. A column that a recording does not have is NULL in its rows.

    Raises
    ------
    InputError
        If there are none, or a header is not that of a recording.
    """
    if not recordings:
        raise InputError("there is no recording of this kind in this folder")
    kept = _until_exit()
    folder = kept.enter_context(tempfile.TemporaryDirectory(prefix="vrcomfort-"))
    tables = []
    for recording, facts in recordings:
        table, _ = kept.enter_context(recording.table())
        told = [
            f"{quoted(value) if isinstance(value, str) else value} AS {column(name)}"
            for name, value in facts.items()
        ]
        tables.append(f"SELECT {', '.join([*told, '*'])} FROM {table}")  # noqa: S608
    return Memory().connection(folder).sql(" UNION ALL BY NAME ".join(tables))


@cache
def _until_exit() -> ExitStack:
    """Return a stack of resources that close when the program ends.

    A relation, or one that was made of it, is read at any time until then: copies of recordings
    without a half-written last row have to be there.
    """
    kept = ExitStack()
    atexit.register(kept.close)
    return kept


def parquet_of(csv: Path) -> Path:
    """Return the path of the packed file of a recording."""
    return csv.with_suffix(".parquet")


def packed_facts(packed: Path) -> dict[str, str] | None:
    """Return a Parquet file's facts of its CSV; None if it is damaged, {} if it has none."""
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


def packed_header(packed: Path) -> tuple[str, ...]:
    """Return the columns of a Parquet file."""
    with duckdb.connect() as connection:
        rows = connection.execute(
            f"SELECT name FROM parquet_schema({quoted(packed)}) WHERE type IS NOT NULL"  # noqa: S608
        ).fetchall()
    return tuple(str(name) for (name,) in rows)


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
    of = kinds(header, file.name)
    native = "VARCHAR" if FORMS[file.name].words else "DOUBLE"
    read_as = {"BIGINT": "VARCHAR", "DOUBLE": native, "VARCHAR": "VARCHAR"}
    typed = ", ".join(f"{quoted(name)}: '{read_as[of[name]]}'" for name in header)
    options = "header = true, auto_detect = false, delim = ',', quote = '\"', escape = '\"'"
    table = f"read_csv({quoted(file)}, {options}, nullstr = '', columns = {{{typed}}})"
    cast = {"BIGINT": _whole, "DOUBLE": column if native == "DOUBLE" else _real, "VARCHAR": column}
    cells = ", ".join(cast[of[name]](name) for name in header)
    return f"(SELECT {cells} FROM {table})"  # noqa: S608 - of names that are quoted


def _whole(name: str) -> str:
    cell = column(name)
    no = f"CASE WHEN {cell} IS NOT NULL THEN CAST(error('not a whole number') AS BIGINT) END"
    yes = f"regexp_full_match({cell}, ' *[+-]?[0-9]+ *')"
    return f"CASE WHEN {yes} THEN CAST({cell} AS BIGINT) ELSE {no} END AS {cell}"


def _real(name: str) -> str:
    """Return SQL for a number as text, by the rule of `vrcomfort.csv_table.number_in`."""
    cell = column(name)
    blank = ", ".join(quoted(word) for word in sorted({"", *NOTHING}))
    no = f"CASE WHEN lower(trim({cell})) NOT IN ({blank}) THEN "
    no += "CAST(error('not a number') AS DOUBLE) END"
    digits = r" *[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)? *"
    yes = f"regexp_full_match({cell}, '{digits}')"
    return f"CASE WHEN {yes} THEN CAST({cell} AS DOUBLE) ELSE {no} END AS {cell}"


@contextmanager
def _whole_rows(csv: Path, width: int) -> Iterator[Path]:
    """Give a file of the whole rows: the CSV itself, or a copy without a half-written last one."""
    end = _end_of_whole_rows(csv, width)
    if end == csv.stat().st_size:
        yield csv
        return
    with tempfile.TemporaryDirectory(prefix="vrcomfort-") as folder:
        copy = Path(folder) / csv.name
        shutil.copyfile(csv, copy)
        os.truncate(copy, end)
        yield copy


def half_written(csv: Path) -> bool:
    """Return whether the last row was cut off, as where a program is ended while it writes."""
    return is_cut_off(csv, len(csv_header(csv)))


def is_cut_off(csv: Path, width: int) -> bool:
    """Return whether the last row of a recording of `width` columns was cut off."""
    return _end_of_whole_rows(csv, width) != csv.stat().st_size


def _end_of_whole_rows(csv: Path, width: int) -> int:
    """Return where the last row that is as long as the header, and has its line end, ends."""
    size = csv.stat().st_size
    with open_file(csv) as stream:
        stream.seek(max(size - _BLOCK, 0))
        tail = stream.read()
    start = size - len(tail)
    end = tail.rfind(b"\n") + 1
    last = tail[tail.rfind(b"\n", 0, max(end - 1, 0)) + 1 : end]
    whole = last.count(b",") + 1 >= width or not last.strip()
    return start + (end if whole else end - len(last))


# A part of a table: long enough to be read fast, short enough for a small machine.
_ROWS_AT_ONCE = 4096
# Of int64, DuckDB's BIGINT.
_LARGEST = 2**63


def damage_of(csv: Path, otherwise: str) -> InputError:
    """Return the error, with its place, of a recording that could not be read."""
    first = otherwise.splitlines()[0] if otherwise else "nothing is said"
    return find_damage(csv) or InputError(f"this recording cannot be read: {first}", file=csv)


def check_header(table: CsvTable) -> None:
    """Raise `InputError` if a table lacks a column that every recording has."""
    if not table.header:
        raise InputError("the file is empty; a recording starts with a header row", file=table.file)
    table.require(FORMS[table.file.name].needed)


def find_damage(file: Path) -> InputError | None:
    """Read a recording cell by cell and return its first fault; None without one.

    A last row that is half-written is not wrong: the program that wrote it was ended.
    """
    before_ns: int | None = None
    try:
        for table in CsvTable.parts(file, appended=True, most_rows=_ROWS_AT_ONCE):
            check_header(table)
            if fault := _in_cells(table) or _in_time(table, before_ns):
                return fault
            if table.rows and FORMS[file.name].rising:
                before_ns = int(table.rows[-1][table.header.index(TIME)])
    except InputError as error:
        return error
    return None


def _in_cells(table: CsvTable) -> InputError | None:
    form = FORMS[table.file.name]
    checks = [
        (place, name, _CHECKS[kind])
        for place, (name, kind) in enumerate(kinds(table.header, table.file.name).items())
        if kind in _CHECKS
    ]
    for line, row in zip(table.lines, table.rows, strict=True):
        for place, name, check in checks:
            cell = row[place].strip()
            blank = not cell or (form.words and cell.casefold() in NOTHING)
            if blank and name in form.filled:
                return table.fault("this cell is blank; mend it first", line, name)
            if not blank and (what := check(row[place])):
                shown = repr(row[place] if len(row[place]) <= 40 else f"{row[place][:40]}…")
                return table.fault(f"{shown} is not {what}; mend it first", line, name)
    return None


def _in_time(table: CsvTable, before_ns: int | None) -> InputError | None:
    if not FORMS[table.file.name].rising:
        return None
    place = table.header.index(TIME)
    for line, row in zip(table.lines, table.rows, strict=True):
        now_ns = int(row[place])
        if before_ns is not None and now_ns <= before_ns:
            return table.fault("time does not go on from the row before; mend it first", line, TIME)
        before_ns = now_ns
    return None


def _not_whole(cell: str) -> str:
    try:
        return "" if abs(int(plain_digits(cell))) < _LARGEST else "a number of 64 bits"
    except ValueError:
        return "a whole number"


def _not_real(cell: str) -> str:
    try:
        return "" if math.isfinite(float(plain_digits(cell))) else "a finite number"
    except ValueError:
        return "a number"


_CHECKS: dict[Kind, Callable[[str], str]] = {"BIGINT": _not_whole, "DOUBLE": _not_real}
