"""The CSV files of one session: rows are appended, and synced as soon as they need be."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from threading import RLock
from typing import Literal, TypeAlias

from vrcomfort.files import read_bytes
from vrcomfort.records.appended_file import AppendedFile, ExternalChange
from vrcomfort.records.disk import Access, refused, replace_text, sync_folder
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.interruptions import (
    RELIES_ON,
    SYNC_EVERY_S,
    SYNCED_AT_ONCE,
    WRITTEN_IN_ORDER,
)
from vrcomfort.records.rows import Row, csv_line
from vrcomfort.records.schema import SESSION_ROWS

Durability: TypeAlias = Literal["each_row", "session_end"]


class RowFiles:
    """The open files of a session's folder; safe to use from two threads.

    Parameters
    ----------
    resumed
        Append to the files that are there, and mark the rows.
    durability
        "each_row": rows of `SYNCED_AT_ONCE` are on the disk when `write` returns, all others
        within `SYNC_EVERY_S`, and those of a trial before the trial's row.
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
        self.external_changes: deque[ExternalChange] = deque()
        """What other programs have done to the files, and has not been told."""
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
        header = csv_line(row_type.columns())
        opened = AppendedFile(file, self._access, fresh=fresh, header=header)
        self._files[row_type.FILE] = opened
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
                self._told.discard(row.FILE)
                self._try(row.FILE, partial(self._append, row))
            self._flush_all()
            if self._each_row:
                self._sync_due({row.FILE for row in rows if isinstance(row, SYNCED_AT_ONCE)})
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
            self._guard_and_sync()

    def replace(self, old: Row, new: Row) -> None:
        """Put a row in the place of one that was written before; it is on the disk at return.

        Raises
        ------
        InputError
            If the disk is full or refuses; the old row stays.
        """
        file = self._folder / old.FILE
        with self._lock:
            opened = self._opened(type(old))
            self._guard(opened)
            opened.flush()
            text = _read(file)
            before, found, after = text.rpartition(self._line(old))
            if not found:  # another program has cut it off
                before, after = text, ""
            self._files.pop(old.FILE).close()  # Windows replaces no open file
            try:
                replace_text(file, before + self._line(new) + after, self._access)
            finally:
                self._opened(type(old))

    def close(self) -> None:
        """Sync and close all files.

        Raises
        ------
        InputError
            If the disk refuses, and this has not been told.
        """
        with self._lock:
            try:
                self._guard_and_sync()
            finally:
                self._close_descriptors()

    def _append(self, row: Row) -> None:
        for each in _with_others(row):
            self._opened(type(each)).append(self._line(each))

    def _opened(self, row_type: type[Row]) -> AppendedFile:
        """Return a file; one that not every session has is opened now."""
        name = row_type.FILE
        try:
            if name not in self._files:
                self._open(row_type)
                sync_folder(self._folder)
        except OSError as error:
            raise refused(self._folder / name, error) from error
        return self._files[name]

    def _line(self, row: Row) -> str:
        cells = row.cells()
        if self._resumed:
            cells[row.columns().index("resumed")] = 1
        return csv_line(cells)

    def _flush_all(self) -> None:
        for name, file in self._in_order():
            if not (self._each_row and name == TrialRow.FILE):  # which waits until all is synced
                self._look_at(name, file)
                self._try(name, file.flush)

    def _sync_due(self, at_once: set[str]) -> None:
        due_s = time.monotonic() - SYNC_EVERY_S
        due = at_once | {
            name
            for name, file in self._files.items()
            if file.unsynced_since_s is not None and file.unsynced_since_s <= due_s
        }
        self._sync_all(due.union(*(RELIES_ON.get(name, ()) for name in due)))

    def _sync_all(self, names: Collection[str] = WRITTEN_IN_ORDER) -> None:
        for name, file in self._in_order():
            if name in names and file.unsynced_since_s is not None:
                self._look_at(name, file)
                self._try(name, file.sync)

    def _guard_and_sync(self) -> None:
        for name, file in self._files.items():
            self._try(name, partial(self._guard, file))  # also where no row has come since
        self._sync_all()
        self._raise_fault()

    def _look_at(self, name: str, file: AppendedFile) -> None:
        if file.waits:  # before its rows are written to where nobody finds them
            self._try(name, partial(self._guard, file))

    def _guard(self, file: AppendedFile) -> None:
        if found := file.guard():
            self.external_changes.append(found)

    def _in_order(self) -> Iterator[tuple[str, AppendedFile]]:
        """Yield the open files, but for those that rely on one that the disk has refused."""
        refused_files: set[str] = set()
        for name in WRITTEN_IN_ORDER:
            file = self._files.get(name)
            if file is None:
                continue
            if refused_files.isdisjoint(RELIES_ON.get(name, ())):
                yield name, file
            if file.waits:
                refused_files.add(name)

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
    others = (row.gaze, row.image, *row.balls, *row.joints, *row.parts)
    return [row, *(each for each in others if each is not None)]


def _read(file: Path) -> str:
    return read_bytes(file).decode()
