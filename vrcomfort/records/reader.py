"""Reads the folder of a study, and of a session: the one way from files to rows and data frames.

A study is a folder in which vrcomfort recorded sessions, an import, or any folder with tables of
their names in it:

>>> study = Study("my_study")                               # doctest: +SKIP
>>> study.ratings.groupby("condition")["response"].mean()   # doctest: +SKIP
>>> study.frames.filter("trial = 2").aggregate("participant, avg(head_y_m)", "participant").df()
...                                                         # doctest: +SKIP
>>> [session.manifest["status"] for session in study.sessions]  # doctest: +SKIP

Tables come in three forms. As pandas data frames (`Study.trials`), typed by the schema, for
analyses. As values row by row (`Session.rows`), for code that walks through a session. As text
(`Session.table`, `Study.tables`), for code that copies cells or reads folders of other origin.
Recordings of frames and gaze are DuckDB relations: nothing of them is read before it is asked for.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vrcomfort.csv_table import CsvTable, number_or_none, whole_or_none
from vrcomfort.errors import InputError
from vrcomfort.records.choice import SessionName
from vrcomfort.records.exposure_rows import RatingRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.manifest import read_manifest
from vrcomfort.records.names import natural
from vrcomfort.records.recorder import session_folder
from vrcomfort.records.rows import CellType, Column, Row, declared
from vrcomfort.records.schema import SCHEMA_VERSION
from vrcomfort.records.session_rows import EventRow, ParticipantRow, QuestionnaireRow
from vrcomfort.records.study import ERASED, read_description, read_participants, recorded_sessions
from vrcomfort.records.tables import (
    RecordedRow,
    cell_value,
    read_header,
    read_rows,
    read_table,
    text_rows,
)

if TYPE_CHECKING:
    import duckdb
    import pandas as pd

    from vrcomfort.records.recording import Recording

_SESSION = re.compile(r"ses-([1-9][0-9]{0,8})")


SCORE_KEYS = (
    "participant", "session", "period", "block", "trial", "condition", "timepoint", "part",
)  # fmt: skip
"""Columns of answers that tell one questionnaire from another."""


@dataclass(frozen=True)
class Session:
    """One recorded session: its folder, such as ``STUDY/sub-P01/ses-1``."""

    folder: Path

    @property
    def participant(self) -> str:
        """Return the participant's name."""
        return self.folder.parent.name.removeprefix("sub-")

    @property
    def number(self) -> int:
        """Return which of the participant's sessions it is, from 1."""
        return int(self.folder.name.removeprefix("ses-"))

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """Return the content of ``manifest.json``.

        Raises
        ------
        InputError
            If it is not there, damaged, or that of another session.
        """
        return read_manifest(self.folder)

    @property
    def schema_version(self) -> int:
        """Return the version of the schema that the session was recorded in."""
        version: int = self.manifest.get("schema_version", 1)
        return version

    def has(self, row_type: type[Row]) -> bool:
        """Return whether the session has a table: some come with their first row."""
        return (self.folder / row_type.FILE).exists()

    def rows(self, row_type: type[Row], *, repaired: bool = False) -> Iterator[RecordedRow]:
        """Yield the rows of a table as values; none where the session does not have it.

        Parameters
        ----------
        repaired
            The session goes on: its files are whole, and have the columns of this version. Else
            the last row may be half-written, and is left out then.

        Raises
        ------
        InputError
            If the manifest or the table is damaged, with its place.
        """
        if self.has(row_type):
            version = SCHEMA_VERSION if repaired else self.schema_version
            yield from read_rows(self.folder, row_type, version=version, cut=not repaired)

    def table(self, row_type: type[Row]) -> CsvTable:
        """Return a table as text; an empty one where the session does not have it.

        Raises
        ------
        InputError
            If the table is damaged, with its place.
        """
        file = self.folder / row_type.FILE
        return read_table(file) if file.exists() else CsvTable(file, (), (), ())

    def header(self, row_type: type[Row]) -> tuple[str, ...]:
        """Return the columns of a table as its file has them; none without one."""
        return read_header(self.folder / row_type.FILE) if self.has(row_type) else ()

    def text_rows(self, row_type: type[Row]) -> Iterator[dict[str, str]]:
        """Yield the rows of a table of any length as text; none where the session has it not.

        Raises
        ------
        InputError
            If the table is damaged, with its place.
        """
        if self.has(row_type):
            yield from text_rows(self.folder / row_type.FILE)

    def data_frame(self, row_type: type[Row]) -> pd.DataFrame:
        """Return a table as a data frame; see `Study.data_frame`."""
        return _data_frame([self.table(row_type)], row_type)

    def recording(self, row_type: type[FrameRow | GazeRow] = FrameRow) -> Recording:
        """Return the frames, or the gaze, of the session, to be read out of core.

        Raises
        ------
        InputError
            If the session has no such recording.
        """
        from vrcomfort.records.recording import Recording

        return Recording.find(self.folder / row_type.FILE)

    @property
    def frames(self) -> duckdb.DuckDBPyRelation:
        """Return the frames as a relation; see `Study.frames`."""
        return _relation([self], FrameRow)

    @property
    def gaze(self) -> duckdb.DuckDBPyRelation:
        """Return the gaze as a relation; see `Study.frames`."""
        return _relation([self], GazeRow)


class Study:
    """A study's folder, or one file of questionnaires.

    Data frames have the columns of the schema (docs/data_dictionary.md), blank where a file is
    without one, and then those that the files have besides. Whole numbers are ``Int64``, others
    ``float64``, and a blank cell is missing. They have all rows: exposures that were begun again
    are in `trials` once for each `attempt`, and of practice and interrupted sessions nothing is
    left out.

    Parameters
    ----------
    folder
        Its tables are read at any depth.
    without
        Sessions that are passed over.

    Raises
    ------
    InputError
        If there is no such file or folder. Reading raises one for what is damaged, with its place.
    """

    def __init__(self, folder: str | Path, *, without: Collection[SessionName] = ()) -> None:
        self.folder = Path(folder)
        self._without = frozenset(without)
        if not self.folder.exists():
            raise InputError("there is no such file or folder", file=self.folder)

    def __repr__(self) -> str:
        """Return how it was made."""
        return f"Study({str(self.folder)!r})"

    @cached_property
    def description(self) -> dict[str, Any]:
        """Return the content of ``dataset_description.json`` of a recorded study."""
        return read_description(self.folder)

    @property
    def enrolled(self) -> list[ParticipantRow]:
        """Return the rows of a recorded study's participants, in the order of enrolment.

        Those whose data were erased are not among them.
        """
        return [row for row in read_participants(self.folder) if row.status != ERASED]

    @property
    def sessions(self) -> tuple[Session, ...]:
        """Return the recorded sessions, by participant and number."""
        if not self.folder.is_dir():
            return ()
        names = (each.name.removeprefix("sub-") for each in self.folder.glob("sub-*"))
        return tuple(
            session for name in sorted(names, key=natural) for session in self.sessions_of(name)
        )

    def sessions_of(self, participant: str) -> list[Session]:
        """Return a participant's recorded sessions, by number."""
        numbers = recorded_sessions(self.folder, participant)
        return [
            self.session(participant, number)
            for number in numbers
            if (participant, number) not in self._without
        ]

    def session(self, participant: str, number: int) -> Session:
        """Return a session, recorded or not."""
        return Session(session_folder(self.folder, participant, number))

    @cached_property
    def participants(self) -> pd.DataFrame:
        """Return a row for each participant, with group and covariates."""
        return self.data_frame(ParticipantRow)

    @cached_property
    def trials(self) -> pd.DataFrame:
        """Return a row for each attempt at an exposure."""
        return self.data_frame(TrialRow)

    @cached_property
    def answers(self) -> pd.DataFrame:
        """Return a row for each answer to a question of a questionnaire."""
        return self.data_frame(QuestionnaireRow)

    @cached_property
    def ratings(self) -> pd.DataFrame:
        """Return a row for each rating during an exposure."""
        return self.data_frame(RatingRow)

    @cached_property
    def events(self) -> pd.DataFrame:
        """Return a row for each event, with its participant and session."""
        return self.data_frame(EventRow)

    def scores(self, instrument: str | Path) -> pd.DataFrame:
        """Return the scores of a questionnaire, a row for each time it was asked.

        Parameters
        ----------
        instrument
            Name of a shipped questionnaire (``"ssq"``) or of one that the study keeps, or its file.
            Answers of a table that names no questionnaire are taken as its answers.

        Returns
        -------
        pandas.DataFrame
            The columns of `answers` up to `timepoint`, `part` where the study has parts, then for
            each scale its raw number (``nausea_raw``, an integer) and its points (``nausea``);
            missing where too few items are answered. Without rows where it was never asked.

        Raises
        ------
        InputError
            If there is no such questionnaire, or an answer is none of its answers, with its place.
        """
        import pandas as pd

        from vrcomfort.questionnaire import find_instrument, instruments_in, read_long, score_sheets

        files = self.files(QuestionnaireRow)
        folders = dict.fromkeys([self.folder, *(file.parent for file in files)])
        asked = find_instrument(instrument, known=instruments_in(folders))
        tables = list(self.tables(QuestionnaireRow))
        for sentence in (each for table in tables for each in table.warnings):
            warnings.warn(sentence, stacklevel=2)
        sheets = [sheet for table in tables for sheet in read_long(table, asked, SCORE_KEYS)]
        parts = any(sheet.keys.get("part") for sheet in sheets)
        keys = [name for name in SCORE_KEYS if parts or name != "part"]
        rows = score_sheets(asked, sheets)
        kinds = {each.name: each.type for each in declared(QuestionnaireRow)}
        frame = {}
        for name in (
            [*keys, *(name for name in rows[0] if name not in SCORE_KEYS)] if rows else keys
        ):
            values = [row.get(name) for row in rows]
            if name not in keys:
                frame[name] = _series(values, int if name.endswith("_raw") else float)
            elif kinds[name] is str:
                frame[name] = _series([value or None for value in values], str)
            else:
                frame[name] = _series(*_guessed([str(value or "") for value in values]))
        return pd.DataFrame(frame)

    @property
    def frames(self) -> duckdb.DuckDBPyRelation:
        """Return the frames of all sessions as a relation, with their participant and session.

        It is read when it is asked: ``study.frames.filter("trial = 2").df()``. A Parquet file of
        `vrcomfort pack` is read in the place of its CSV.

        Raises
        ------
        InputError
            If no session has any, or a file's header is not that of frames.
        """
        return _relation(self.sessions, FrameRow)

    @property
    def gaze(self) -> duckdb.DuckDBPyRelation:
        """Return the gaze of all sessions as a relation, as `frames`."""
        return _relation(self.sessions, GazeRow)

    def data_frame(self, row_type: type[Row]) -> pd.DataFrame:
        """Return all rows of a table, such as `TaskRow`, as a data frame.

        A half-written last row is left out, with a Python warning. Rows of tables that do not name
        participant and session (events, clocks) get them from the names of their folders.

        Raises
        ------
        InputError
            If a cell of a recorded session is not what its column holds, with its place. Other
            tables' columns stay text where a cell is no number.
        """
        return _data_frame(self.tables(row_type), row_type)

    def tables(self, row_type: type[Row]) -> Iterator[CsvTable]:
        """Yield the tables of a name as text.

        Raises
        ------
        InputError
            If one is damaged, with its place.
        """
        return map(read_table, self.files(row_type))

    def files(self, row_type: type[Row]) -> list[Path]:
        """Return the files of a table at any depth, in the order of their names."""
        if self.folder.is_file():
            return [self.folder] if row_type is QuestionnaireRow else []
        return self.at_any_depth(row_type.FILE)

    def at_any_depth(self, name: str) -> list[Path]:
        """Return the files of a name, but for those of sessions that are passed over."""
        left_out = {each.folder(self.folder) for each in self._without}
        found = (each for each in self.folder.rglob(name) if each.parent not in left_out)
        return sorted(found, key=lambda path: natural(path.as_posix()))


def _relation(
    sessions: Iterable[Session], row_type: type[FrameRow | GazeRow]
) -> duckdb.DuckDBPyRelation:
    from vrcomfort.records.recording import relation

    return relation(
        [
            (each.recording(row_type), {"participant": each.participant, "session": each.number})
            for each in sessions
            if each.has(row_type)
        ]
    )


def _data_frame(tables: Iterable[CsvTable], row_type: type[Row]) -> pd.DataFrame:
    import pandas as pd

    read = list(tables)
    for sentence in (each for table in read for each in table.warnings):
        warnings.warn(sentence, stacklevel=4)
    there = dict.fromkeys(name for table in read for name in table.header)
    columns = {each.name: each for each in declared(row_type)}
    columns |= {each.name: each for each in row_type.FURTHER if each.name in there}
    frame = {
        name: _series([value for table in read for value in _values(table, column)], column.type)
        for name, column in columns.items()
    }
    if "participant" not in columns:
        whose = [_whose(table.file.parent) for table in read for _ in table.rows]
        names, numbers = [each[0] for each in whose], [each[1] for each in whose]
        frame = {"participant": _series(names, str), "session": _series(numbers, int), **frame}
    for name in (each for each in there if each and each not in frame):
        frame[name] = _series(*_guessed([cell for table in read for cell in _cells(table, name)]))
    return pd.DataFrame(frame)


def _whose(folder: Path) -> tuple[str | None, int | None]:
    """Return participant and session of a session's folder; None of another."""
    number = _SESSION.fullmatch(folder.name)
    if number is None or not folder.parent.name.startswith("sub-"):
        return None, None
    return folder.parent.name.removeprefix("sub-"), int(number[1])


def _cells(table: CsvTable, name: str) -> list[str]:
    """Return the cells of a column; blank ones where the table is without it."""
    if name not in table.header:
        return [""] * len(table.rows)
    place = table.header.index(name)
    return [row[place] for row in table.rows]


def _values(table: CsvTable, column: Column) -> list[Any]:
    """Return the values of a declared column; None where a cell is blank."""
    cells = _cells(table, column.name)
    values: list[Any] = []
    for line, cell in zip(table.lines, cells, strict=True):
        try:
            values.append(cell_value(cell, column) if cell.strip() else None)
        except ValueError as error:
            # A table of other origin may call its sessions "pre" and "post": text is kept there.
            if not table.file.with_name("manifest.json").exists():
                return [each or None for each in cells]
            raise table.fault(f"{error}; mend it first", line, column.name) from None
    return values


def _guessed(cells: list[str]) -> tuple[list[Any], CellType]:
    """Return the values of a column that is not declared, such as a covariate, and their type."""
    for kind, read in ((int, whole_or_none), (float, number_or_none)):
        values = [read(cell) for cell in cells]
        if all(
            value is not None or not cell.strip() for value, cell in zip(values, cells, strict=True)
        ):
            return values, kind
    return [cell or None for cell in cells], str


def _series(values: list[Any], kind: CellType) -> pd.Series[Any]:
    """Return values as a column of a data frame; text where one of them is text."""
    import pandas as pd

    if kind is str or any(isinstance(value, str) for value in values):
        return pd.Series([None if each is None else str(each) for each in values], dtype="str")
    return pd.Series(values, dtype="Int64" if kind is int else "float64")
