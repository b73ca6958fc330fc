"""Ratings of a study by exposure, in 16 bytes a row: long files are read out of core.

A file of less than `LONG_BYTES` is read as text; a longer one as recordings of frames are, from
its Parquet file where `vrcomfort pack` has made one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import duckdb
import numpy as np
from numpy.typing import NDArray

from vrcomfort.csv_table import CsvTable, number_in, shortened
from vrcomfort.errors import InputError
from vrcomfort.records.recording import LONG_BYTES, Memory, Recording, column, is_cut_off

Floats = NDArray[np.float64]
Key = tuple[str, ...]

KEYS_OF_RATINGS = ("participant", "session", "trial", "condition", "instrument")
"""Columns that tell one course of ratings from another."""
FEWEST_INTERVALS, MOST_INTERVALS = 10, 1000
"""Of all exposures, and of one, from which the usual interval is taken."""
REGULAR, CLOSE = 0.8, 0.2
"""Share of the intervals between ratings that have the usual length, within a fifth of it, where
ratings are asked for at fixed times."""
GAP = 2.5
"""Usual intervals from which on nothing between two ratings is a gap."""
_ROWS_AT_ONCE = 65_536
_NUMBERS = ("onset_s", "response")


@dataclass(frozen=True, eq=False)
class RatingSeries:
    """The ratings of one exposure with one instrument, in the order of their rows.

    Parameters
    ----------
    participant, session, trial, condition, instrument
        As the file has them; blank where it is silent.
    onset_s
        When each was asked, on the session's clock, shape (n,).
    response
        The answers, shape (n,); NaN where a rating was missed.
    """

    participant: str
    session: str
    trial: str
    condition: str
    instrument: str
    onset_s: Floats
    response: Floats

    @classmethod
    def of(cls, key: Sequence[str], onset_s: Floats, response: Floats) -> Self:
        """Return the series of a key, in the order of `KEYS_OF_RATINGS`."""
        participant, session, trial, condition, instrument = key
        return cls(participant, session, trial, condition, instrument, onset_s, response)

    @property
    def missed(self) -> int:
        """Return the number of ratings without an answer."""
        return int(np.isnan(self.response).sum())

    @property
    def intervals_s(self) -> Floats:
        """Return the time from each rating to the next, in the order of time, shape (n − 1,)."""
        steps = np.diff(self.onset_s)
        return steps if (steps >= 0).all() else np.diff(np.sort(self.onset_s))


def usual_interval_s(series: Iterable[RatingSeries]) -> float | None:
    """Return the interval at which ratings come; None where they are few or not regular."""
    some = (_evenly(each.intervals_s) for each in series)
    steps = np.concatenate([np.empty(0), *(each[each > 0] for each in some)])
    if steps.size < FEWEST_INTERVALS:
        return None
    usual = float(np.median(steps))
    regular = np.abs(steps - usual) <= CLOSE * usual
    return usual if float(regular.mean()) >= REGULAR else None


def _evenly(intervals_s: Floats) -> Floats:
    """Return at most `MOST_INTERVALS` of the intervals, evenly taken."""
    return intervals_s[:: max(-(-intervals_s.size // MOST_INTERVALS), 1)]


@dataclass(frozen=True)
class ReadRatings:
    """The ratings of some files, with a sentence for each thing that was not read."""

    series: tuple[RatingSeries, ...]
    notes: tuple[str, ...] = ()


def read_ratings(files: Iterable[Path], memory: Memory | None = None) -> ReadRatings:
    """Read ``ratings.csv`` files.

    Raises
    ------
    InputError
        If a file is damaged or a number is none, with its place.
    """
    series: list[RatingSeries] = []
    notes: list[str] = []
    for file in files:
        read = _long(file, memory or Memory()) if file.stat().st_size >= LONG_BYTES else None
        read = read or _as_text(file)
        series += read.series
        notes += read.notes
    return ReadRatings(joined(series), tuple(notes))


def joined(series: Iterable[RatingSeries]) -> tuple[RatingSeries, ...]:
    """Join series of one exposure and instrument, which stand in several files."""
    found: dict[Key, list[RatingSeries]] = {}
    for each in series:
        found.setdefault(tuple(getattr(each, name) for name in KEYS_OF_RATINGS), []).append(each)
    return tuple(
        same[0]
        if len(same) == 1
        else replace(
            same[0],
            onset_s=np.concatenate([each.onset_s for each in same]),
            response=np.concatenate([each.response for each in same]),
        )
        for same in found.values()
    )


def series_of(rows: Iterable[tuple[Key, float, float]]) -> Iterator[RatingSeries]:
    """Yield the series of rows of key (in the order of `KEYS_OF_RATINGS`), onset and response."""
    found: dict[Key, tuple[list[float], list[float]]] = {}
    for key, onset_s, response in rows:
        onsets, responses = found.setdefault(key, ([], []))
        onsets.append(onset_s)
        responses.append(response)
    for key, (onsets, responses) in found.items():
        yield RatingSeries.of(key, np.array(onsets), np.array(responses))


def _as_text(file: Path) -> ReadRatings:
    series: list[RatingSeries] = []
    for table in CsvTable.parts(file, appended=True, most_rows=_ROWS_AT_ONCE):
        missing = [name for name in ("missed", "onset_s") if name not in table.header]
        if table.header and missing:
            return ReadRatings((), (f"{file}: not used, because it has no column {missing[0]}",))
        series += series_of(_cells(table))
        notes = table.warnings
    return ReadRatings(joined(series), notes)


def _cells(table: CsvTable) -> Iterator[tuple[Key, float, float]]:
    places = {name: table.header.index(name) for name in table.header if name}
    keys = [places.get(name) for name in KEYS_OF_RATINGS]
    onset, response, missed = (places.get(name) for name in (*_NUMBERS, "missed"))
    for line, row in zip(table.lines, table.rows, strict=True):
        key = tuple("" if place is None else row[place] for place in keys)
        onset_s = _number(table, line, row, onset, "onset_s")
        if onset_s is None:
            who = f"this rating of {key[0]}" if key[0] else "this rating"
            raise table.fault(f"{who} has no onset_s; give seconds", line, "onset_s")
        answered = missed is not None and row[missed] in {"", "0"}
        value = _number(table, line, row, response, "response") if answered else None
        yield key, onset_s, np.nan if value is None else value


def _number(
    table: CsvTable, line: int, row: tuple[str, ...], place: int | None, name: str
) -> float | None:
    if place is None:
        return None
    try:
        return number_in(row[place], words=True)
    except ValueError:
        message = f"{shortened(row[place])} is not a number; give a finite one, or leave it blank"
        raise table.fault(message, line, name) from None


def _long(file: Path, memory: Memory) -> ReadRatings | None:
    """Read a long file with the database; None where that takes it for damaged.

    Text is then read line by line: it has the fault's place, or is of a form that the database does
    not know, such as lines that end with carriage returns.
    """
    try:
        recording = Recording.find(file)
        with memory.database() as database, recording.table() as (table, columns):
            if "missed" not in columns:
                return None
            series = _grouped(database, _cleaned(table, columns))
    except (duckdb.Error, InputError):
        return None
    cut = "the last row is half-written and was left out"
    notes = [recording.note] if recording.note else []
    notes += [f"{file}: {cut}"] if is_cut_off(file, len(columns)) else []
    return ReadRatings(series, tuple(notes))


def _cleaned(table: str, columns: Iterable[str]) -> str:
    """Return SQL of the key columns, onset and value, as `_cells` gives them."""
    there = set(columns)
    keys = [
        f"coalesce({column(name)}, '') AS {column(name)}" if name in there else f"'' AS {name}"
        for name in KEYS_OF_RATINGS
    ]
    onset = "CASE WHEN isfinite(onset_s) THEN onset_s ELSE CAST(error('no onset') AS DOUBLE) END"
    finite = "CASE WHEN isfinite(response) THEN response ELSE CAST(error('') AS DOUBLE) END"
    answered = "coalesce(missed, '') IN ('', '0') AND response IS NOT NULL"
    value = f"CASE WHEN {answered} THEN {finite} ELSE CAST('nan' AS DOUBLE) END"
    return f"SELECT {', '.join(keys)}, {onset} AS onset, {value} AS value FROM {table}"  # noqa: S608


def _grouped(database: duckdb.DuckDBPyConnection, rows: str) -> tuple[RatingSeries, ...]:
    """Return the series of rows in SQL: slices of two columns, sorted by key where need be.

    Exposures mostly stand one after the other. Then neither the words of a key nor its number are
    fetched for each row.
    """
    names = ", ".join(KEYS_OF_RATINGS)
    numbered = f"SELECT {names}, row_number() OVER () AS place FROM ({rows})"  # noqa: S608
    counted = (
        f"SELECT {names}, count(*) AS n, min(place) AS first, max(place) AS last "  # noqa: S608
        f"FROM ({numbered}) GROUP BY ALL ORDER BY first"
    )
    number = "CAST(row_number() OVER () AS INTEGER) AS number"
    database.execute(f"CREATE TEMP TABLE courses AS SELECT {number}, * FROM ({counted})")  # noqa: S608
    query = f"SELECT {names}, n, last - first + 1 = n FROM courses ORDER BY number"  # noqa: S608
    found = database.execute(query).fetchall()
    if all(row[-1] for row in found):
        read = database.execute(f"SELECT onset, value FROM ({rows})").fetchnumpy()  # noqa: S608
        onset_s, value = np.asarray(read["onset"]), np.asarray(read["value"])
    else:
        query = f"SELECT onset, value, number FROM ({rows}) JOIN courses USING ({names})"  # noqa: S608
        read = database.execute(query).fetchnumpy()
        order = np.argsort(read["number"], kind="stable")
        onset_s, value = np.asarray(read["onset"])[order], np.asarray(read["value"])[order]
    ends = np.cumsum([0, *(row[-2] for row in found)])
    return tuple(
        RatingSeries.of(row[: len(KEYS_OF_RATINGS)], onset_s[begin:end], value[begin:end])
        for row, begin, end in zip(found, ends[:-1], ends[1:], strict=True)
    )
