"""Writes a session's rows as they happen. Whatever ends the program, what was written stays."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from vrcomfort.errors import InputError
from vrcomfort.records.background import CAPACITY, BackgroundWriter
from vrcomfort.records.frame_rows import FrameRow, GazeRow
from vrcomfort.records.rows import (
    EventRow,
    QuestionnaireRow,
    RatingRow,
    Row,
    TimingRow,
    TrialRow,
    cell_text,
)

SESSION_ROWS: tuple[type[Row], ...] = (
    TrialRow, TimingRow, QuestionnaireRow, RatingRow, FrameRow, EventRow,
)  # fmt: skip
OPTIONAL_ROWS: tuple[type[Row], ...] = (GazeRow,)
"""Their files appear with their first rows."""

_SYNCED = (QuestionnaireRow, TrialRow)


def session_folder(study: Path, participant: str, session: int) -> Path:
    """Return the folder of one participant's session."""
    return study / f"sub-{participant}" / f"ses-{session}"


def is_begun(folder: Path) -> bool:
    """Return whether a session's folder holds more than the headers that it begins with."""
    if not folder.is_dir():
        return False
    headers = {each.FILE: len(csv_line(each.columns()).encode()) for each in SESSION_ROWS}
    files = [file for file in folder.iterdir() if not file.name.startswith(".")]
    return any(file.stat().st_size > headers.get(file.name, 0) for file in files)


@dataclass
class _Gap:
    """Frames that came faster than they could be written."""

    start_s: float
    end_s: float
    rows: int = 0


class Recorder:
    """The open CSV files of one session; a context manager.

    A thread writes, and flushes every row. `write` returns when its rows are in their files, and
    rows of questionnaires and trials on the disk (fsync); but it never waits for a row of a frame,
    nor does `write_soon` for any row. Where the disk is so slow that `capacity` rows wait, rows of
    frames (and only these) are left out, counted, and told in ``events.csv``.

    Parameters
    ----------
    resumed
        Append to the files of a session that was interrupted (see `take_up`), and mark the rows.

    Attributes
    ----------
    frames_not_recorded
        Frames that were left out.

    Raises
    ------
    InputError
        If the session has been recorded before, or the disk refuses a file or a row; a row that
        nobody waited for is told by the next call.
    """

    def __init__(
        self,
        study: Path,
        participant: str,
        session: int,
        *,
        resumed: bool = False,
        capacity: int = CAPACITY,
    ) -> None:
        self.folder = session_folder(study, participant, session)
        self.frames_not_recorded = 0
        self._resumed = resumed
        self._files: dict[str, io.TextIOWrapper] = {}
        self._gap: _Gap | None = None
        if not resumed and is_begun(self.folder):
            raise overwriting(self.folder, participant, session)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for row_type in SESSION_ROWS:
                self._open(row_type)
        except OSError as error:
            self._close_files()
            raise refused(self.folder, error) from error
        self._background = BackgroundWriter(self._append, capacity=capacity)

    def _open(self, row_type: type[Row]) -> None:
        file = self.folder / row_type.FILE
        old = self._resumed and file.exists()
        stream = file.open("a" if old else "w", encoding="utf-8", newline="")
        self._files[row_type.FILE] = stream
        if not old:
            stream.write(csv_line(row_type.columns()))
            stream.flush()

    def write(self, *rows: Row) -> None:
        """Append rows; rows of one call may belong to different files.

        Rows of questionnaires and trials are on the disk at return.

        Raises
        ------
        InputError
            If the disk is full or refuses; rows written before are kept.
        """
        self.write_soon(*rows)
        if not all(isinstance(row, FrameRow) for row in rows):
            self.flush()
        for name in {row.FILE for row in rows if isinstance(row, _SYNCED)}:
            self._sync(name)

    def replace(self, old: Row, new: Row) -> None:
        """Put a row in the place of one that was written before; it is on the disk at return.

        Whatever happens meanwhile, the file has one of the two.

        Raises
        ------
        InputError
            If the disk is full or refuses; the old row stays.
        """
        self.flush()  # now nobody else writes
        file = self.folder / old.FILE
        self._files[old.FILE].close()
        try:
            before, _, after = _read(file).rpartition(self._line(old))
            replace_text(file, before + self._line(new) + after)
        finally:
            self._files[old.FILE] = file.open("a", encoding="utf-8", newline="")

    def write_soon(self, *rows: Row) -> None:
        """Append rows without waiting: what happens between two frames."""
        for row in rows:
            if isinstance(row, FrameRow):
                self._offer(row)
            else:
                self._background.put(row)
        self._background.check()  # not before: no row may be lost to the fault of another

    def flush(self) -> None:
        """Wait until everything is in its file.

        Raises
        ------
        InputError
            If the disk refused a row since the last call.
        """
        self._tell_gap()
        self._background.finish()

    def _offer(self, row: FrameRow) -> None:
        if self._background.offer(row):
            self._tell_gap()
            return
        self._gap = self._gap or _Gap(row.session_s, row.session_s)
        self._gap.end_s = row.session_s
        self._gap.rows += 1
        self.frames_not_recorded += 1

    def _tell_gap(self) -> None:
        gap, self._gap = self._gap, None
        if gap is not None:
            detail = f"{gap.rows} frames: the disk is too slow; they are shown, but have no row"
            length_s = round(gap.end_s - gap.start_s, 9)
            self._background.put(EventRow(gap.start_s, length_s, "frames_not_recorded", detail))

    def _append(self, row: Row) -> None:
        self._append_row(row)
        if isinstance(row, FrameRow) and row.gaze is not None:
            self._append_row(row.gaze)

    def _append_row(self, row: Row) -> None:
        try:
            if row.FILE not in self._files:  # a file that not every session has
                self._open(type(row))
            stream = self._files[row.FILE]
            stream.write(self._line(row))
            stream.flush()
        except OSError as error:
            raise refused(self.folder / row.FILE, error) from error

    def _line(self, row: Row) -> str:
        cells = list(row.cells())
        if self._resumed:
            cells[row.columns().index("resumed")] = 1
        return csv_line(map(cell_text, cells))

    def _sync(self, name: str) -> None:
        try:
            os.fsync(self._files[name].fileno())
        except OSError as error:
            raise refused(self.folder / name, error) from error

    def close(self) -> None:
        """Write what waits and close all files.

        Raises
        ------
        InputError
            If the disk refused a row since the last call.
        """
        if not self._files:
            return
        try:
            self._tell_gap()
        finally:
            try:
                self._background.close()
            finally:
                self._close_files()

    def _close_files(self) -> None:
        for stream in self._files.values():
            with suppress(OSError):  # rows are flushed one by one: a full disk has been told
                stream.close()
        self._files.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if error is None:
            self.close()
            return
        with suppress(InputError):  # the first error is the one to tell
            self.close()


def _read(file: Path) -> str:
    with file.open(encoding="utf-8", newline="") as stream:  # line ends as they are
        return stream.read()


def csv_line(cells: Iterable[str]) -> str:
    """Return one CSV line with its line end."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()


def replace_text(file: Path, text: str) -> None:
    """Replace a file as a whole: readers see the old text or the new, never half of it.

    Raises
    ------
    InputError
        If the disk is full or refuses; the old file stays.
    """
    draft = file.with_name(f".{file.name}.new")
    try:
        with draft.open("w", encoding="utf-8", newline="") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        draft.replace(file)
    except OSError as error:
        raise refused(file, error) from error


def overwriting(folder: Path, participant: str, session: int) -> InputError:
    """Return the error for a session that is there already."""
    message = f"session {session} of {participant} has been recorded and is never overwritten"
    remedy = "choose another participant, session or study folder"
    return InputError(f"{message}; {remedy}", file=folder)


def refused(file: Path, error: OSError) -> InputError:
    """Return the error for a disk that does not take what is written."""
    reason = error.strerror or type(error).__name__
    return InputError(f"cannot write: {reason}; what was written before is kept", file=file)
