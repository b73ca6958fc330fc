"""The CSV files of one session: rows are appended, and synced as soon as they need be."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from threading import RLock
from typing import Literal, TypeAlias

from vrcomfort.records.appended_file import AppendedFile
from vrcomfort.records.disk import Access, refused, replace_text, sync_folder
from vrcomfort.records.exposure_rows import DialRow, PracticeRow, RatingRow, TaskRow, TrialRow
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.rows import Row, csv_line
from vrcomfort.records.schema import SESSION_ROWS
from vrcomfort.records.session_rows import EventRow, QuestionnaireRow, ScreeningRow, TextRow

SYNC_EVERY_S = 0.5
"""So long may a row of a frame wait: less than the second that is promised, for slow disks."""

Durability: TypeAlias = Literal["each_row", "session_end"]

_SYNCED_AT_ONCE = (
    TrialRow, QuestionnaireRow, RatingRow, TaskRow, DialRow, TextRow, ScreeningRow, PracticeRow,
    EventRow,
)  # fmt: skip


class RowFiles:
    """The open files of a session's folder; safe to use from two threads.

    Parameters
    ----------
    resumed
        Append to the files that are there, and mark the rows.
    durability
        "each_row": rows of trials, answers, ratings and events are on the disk when `write`
        returns, all others within `SYNC_EVERY_S`, and those of a trial before the trial's row.
        "session_end": nothing is synced before `sync` or `close`.

    Raises
    ------
    InputError
        If a file is a symbolic link.
    OSError
        If the disk refuses a file.
    """

    def __init__(
        self, folder: Path, access: Access, *, resumed: bool, durability: Durability
    ) -> None:
        self._folder = folder
        self._access = access
        self._resumed = resumed
        self._each_row = durability == "each_row"
        self._files: dict[str, AppendedFile] = {}
        self._lock = RLock()
        self._fault: Exception | None = None
        self._told: set[str] = set()
        """Files whose refusal has been told, and that no row has come for since."""
        try:
            for row_type in SESSION_ROWS:
                self._open(row_type, fresh=not resumed)
            sync_folder(folder)
        except BaseException:
            self._close_descriptors()
            raise

    def __getitem__(self, name: str) -> AppendedFile:
        """Return an open file."""
        return self._files[name]

    def _open(self, row_type: type[Row], *, fresh: bool = False) -> None:
        file = self._folder / row_type.FILE
        self._files[row_type.FILE] = opened = AppendedFile(file, self._access, fresh=fresh)
        if not file.stat().st_size:
            opened.append(csv_line(row_type.columns()))
            opened.flush()

    def write(self, rows: Sequence[Row]) -> None:
        """Append rows that came together; they share the syncs that they need.

        No rows at all are a reminder to sync what has waited long enough.

        Raises
        ------
        InputError
            If the disk refuses one; the others are written.
        """
        with self._lock:
            for row in rows:
                if self._each_row and isinstance(row, TrialRow):
                    self._sync_all()  # a trial is done once all that belongs to it is safe
                self._told.discard(row.FILE)
                self._try(row.FILE, partial(self._append, row))
            for name, file in self._files.items():
                self._try(name, file.flush)
            if self._each_row:
                self._sync_due({row.FILE for row in rows if isinstance(row, _SYNCED_AT_ONCE)})
            self._raise_fault()

    def due_in_s(self) -> float | None:
        """Return when `write` wants to be called again, though there be no row; None: need not."""
        with self._lock:
            began_s = [file.unsynced_since_s for file in self._files.values()]
            oldest_s = min((each for each in began_s if each is not None), default=None)
        if oldest_s is None or not self._each_row:
            return None
        return max(0.0, oldest_s + SYNC_EVERY_S - time.monotonic())

    def sync(self) -> None:
        """Wait until everything that was written is on the disk.

        Raises
        ------
        InputError
            If the disk refuses.
        """
        with self._lock:
            self._told.clear()  # whoever asks wants to know
            self._sync_all()
            self._raise_fault()

    def replace(self, old: Row, new: Row) -> None:
        """Put a row in the place of one that was written before; it is on the disk at return.

        Raises
        ------
        InputError
            If the disk is full or refuses; the old row stays.
        """
        file = self._folder / old.FILE
        with self._lock:
            if old.FILE in self._files:  # not so just after another correction
                self._files[old.FILE].flush()
            before, _, after = _read(file).rpartition(self._line(old))
            if opened := self._files.pop(old.FILE, None):
                opened.close()  # Windows replaces no open file; the next row opens it again
            replace_text(file, before + self._line(new) + after, self._access)

    def close(self) -> None:
        """Sync and close all files.

        Raises
        ------
        InputError
            If the disk refuses, and this has not been told.
        """
        with self._lock:
            try:
                self._sync_all()
                self._raise_fault()
            finally:
                self._close_descriptors()

    def _append(self, row: Row) -> None:
        for each in _with_others(row):
            try:
                if each.FILE not in self._files:  # a file that not every session has
                    self._open(type(each))
                    sync_folder(self._folder)
            except OSError as error:
                raise refused(self._folder / each.FILE, error) from error
            self._files[each.FILE].append(self._line(each))

    def _line(self, row: Row) -> str:
        cells = row.cells()
        if self._resumed:
            cells[row.columns().index("resumed")] = 1
        return csv_line(cells)

    def _sync_due(self, at_once: set[str]) -> None:
        now_s = time.monotonic()
        for name, file in self._files.items():
            since_s = file.unsynced_since_s
            if since_s is not None and (name in at_once or now_s - since_s >= SYNC_EVERY_S):
                self._try(name, file.sync)

    def _sync_all(self) -> None:
        for name, file in self._files.items():
            if file.unsynced_since_s is not None:
                self._try(name, file.sync)

    def _try(self, name: str, step: Callable[[], None]) -> None:
        """Keep the first fault, and go on: no row may be lost to the fault of another."""
        try:
            step()
        except Exception as error:  # it belongs to whoever wrote the row
            if name not in self._told:
                self._fault = self._fault or error
            self._told.add(name)

    def _raise_fault(self) -> None:
        fault, self._fault = self._fault, None
        if fault is not None:
            raise fault

    def _close_descriptors(self) -> None:
        for file in self._files.values():
            file.close()
        self._files.clear()


def _with_others(row: Row) -> Iterable[Row]:
    """Return a row, with those of other files that a frame brings."""
    if not isinstance(row, FrameRow):
        return (row,)
    return [each for each in (row, row.gaze, row.image, *row.balls) if each is not None]


def _read(file: Path) -> str:
    with file.open(encoding="utf-8", newline="") as stream:  # line ends as they are
        return stream.read()
