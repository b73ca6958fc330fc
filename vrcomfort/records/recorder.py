"""Writes a session's rows as they happen; written rows outlive any end of the program."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Condition, Thread
from types import TracebackType
from typing import Self

from vrcomfort.errors import InputError
from vrcomfort.records.appended_file import ExternalChange
from vrcomfort.records.disk import OWNER, Access, make_folders, refused
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.frame_rows import FrameRow
from vrcomfort.records.row_files import Durability, RowFiles
from vrcomfort.records.rows import Row, csv_line
from vrcomfort.records.schema import SESSION_ROWS
from vrcomfort.records.session_rows import EventRow
from vrcomfort.stop_signals import uninterrupted_call

CAPACITY = 4096
"""Rows that may wait: 45 s of frames at 90 Hz, about 15 MB."""
TOGETHER_S = 0.1
"""For so long rows of frames wait for those that follow."""


class BackgroundWriter:
    """Writes rows in a thread of its own, so that a slow disk never holds up a frame.

    They are written in the order in which they came, those that wait together. Rows of frames wait
    for others, `TOGETHER_S` at most: waking the thread is dear, in its time and the frame's.

    Parameters
    ----------
    files
        Written to in the thread. An error is raised again by the next `check`, `finish` or
        `close`; the rows after it are still written.
    capacity
        Rows that may wait before `offer` refuses.
    """

    def __init__(self, files: RowFiles, *, capacity: int = CAPACITY) -> None:
        self._files = files
        self._capacity = capacity
        self._rows: deque[Row] = deque()
        self._news: SimpleQueue[bool] = SimpleQueue()
        """Wakes the thread, True: at once. No lock of Python's holds up a frame."""
        self._written = Condition()
        self._fault: Exception | None = None
        self._closing = False
        self._thread = Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def offer(self, row: Row) -> bool:
        """Take a row, or return False where too many wait; never waits."""
        waiting = len(self._rows)
        if waiting >= self._capacity:
            return False
        self._rows.append(row)
        if waiting in (0, self._capacity // 2):
            self._news.put(waiting > 0)
        return True

    def put(self, *rows: Row) -> None:
        """Take rows, however many wait; never waits."""
        self._rows.extend(rows)
        self._news.put(True)

    def check(self) -> None:
        """Raise the error of `write`, if there was one."""
        if self._fault is None:  # hot: a lock takes longer
            return
        with self._written:
            fault, self._fault = self._fault, None
        if fault is not None:
            raise fault

    def finish(self) -> None:
        """Wait until every row has been written."""
        self._news.put(True)
        with self._written:
            self._written.wait_for(lambda: not self._rows)
        self.check()

    def close(self) -> None:
        """Write the waiting rows, end the thread, and raise the error of the files, if any."""
        self._closing = True
        self._news.put(True)
        self._thread.join()
        self.check()

    def _run(self) -> None:
        while (rows := self._next()) is not None:
            fault = self._try(rows)
            with self._written:
                self._fault = self._fault or fault
                for _ in range(len(rows)):
                    self._rows.popleft()  # only now: an empty queue says that all is in the files
                rows.clear()  # the next ones may be long in coming
                self._written.notify_all()

    def _try(self, rows: Sequence[Row]) -> Exception | None:
        try:
            self._files.write(rows)
        except Exception as error:  # it belongs to whoever wrote the row
            return error
        return None

    def _next(self) -> list[Row] | None:
        """Wait for rows, or until the files are due (then there are none); None at the end."""
        due_in_s, at_once = self._files.due_in_s(), False
        together_s = TOGETHER_S if due_in_s is None else min(due_in_s, TOGETHER_S)
        with suppress(Empty):
            while not (self._rows or self._closing):  # rows of the last news may be written
                at_once = self._news.get(timeout=due_in_s)
        with suppress(Empty):
            while self._rows and not at_once:
                at_once = self._news.get(timeout=together_s)
        if self._closing and not self._rows:
            return None
        # By index: rows may be added meanwhile, which an iteration over a deque does not survive.
        return [self._rows[at] for at in range(len(self._rows))]


def session_folder(study: Path, participant: str, session: int) -> Path:
    """Return the folder of one participant's session."""
    return study / f"sub-{participant}" / f"ses-{session}"


def is_begun(folder: Path) -> bool:
    """Return whether a session's folder holds more than the headers that it begins with."""
    if not folder.is_dir():
        return False
    headers = {each.FILE: len(csv_line(each.columns()).encode()) for each in SESSION_ROWS}
    files = [file for file in folder.iterdir() if not file.name.startswith(".")]
    return any(file.lstat().st_size > headers.get(file.name, 0) for file in files)


@dataclass
class _Gap:
    """Frames that came faster than they could be written."""

    start_s: float
    end_s: float
    rows: int = 0


class Recorder:
    """The open CSV files of one session; a context manager.

    A thread writes and syncs. `write` returns when its rows are on the disk (not even a power cut
    loses them); but it never waits for a row of a frame, nor does `write_soon` for any row: rows
    of frames and of timing are on the disk `SYNC_EVERY_S` later. Where the disk is so slow that
    `capacity` rows wait, rows of frames (and only these) are left out, counted, and told in
    ``events.csv``. No signal cuts a call short: it could leave the thread's lock behind.

    Parameters
    ----------
    resumed
        Append to the files of an interrupted session (see `repair_session`), and mark the rows.
    durability
        "session_end" syncs at the end alone, for sessions that can be simulated again: until
        then rows survive the end of the program, and not of the machine. Nobody waits for a row
        but for that of a trial.
    access
        Who may read the files.

    Attributes
    ----------
    frames_not_recorded
        Frames that were left out.
    external_changes
        What other programs have done to the files, as far as `take_external_changes` has told.

    Raises
    ------
    InputError
        If the session has been recorded before, a file or folder is a symbolic link, or the disk
        refuses a file or a row; a row that nobody waited for is told by the next call.
    """

    def __init__(
        self,
        study: Path,
        participant: str,
        session: int,
        *,
        resumed: bool = False,
        durability: Durability = "each_row",
        access: Access = OWNER,
        capacity: int = CAPACITY,
    ) -> None:
        self.folder = session_folder(study, participant, session)
        self.access = access
        self.frames_not_recorded = 0
        self.external_changes: list[ExternalChange] = []
        self.durability = durability
        self._gap: _Gap | None = None
        self._closed = False
        if not resumed and is_begun(self.folder):
            raise overwriting(self.folder, participant, session)
        try:
            make_folders(study, self.folder, access)
            self._files = RowFiles(self.folder, access, resumed=resumed, durability=durability)
        except OSError as error:
            raise refused(self.folder, error) from error
        self._background = BackgroundWriter(self._files, capacity=capacity)

    def write(self, *rows: Row) -> None:
        """Append rows; rows of one call may belong to different files.

        All but rows of frames are in their files at return, and on the disk but for timing.

        Raises
        ------
        InputError
            If the disk is full or refuses; rows written before are kept.
        """
        self.write_soon(*rows)
        if self.durability == "each_row":
            waited_for = not all(isinstance(row, FrameRow) for row in rows)
        else:
            waited_for = any(isinstance(row, TrialRow) for row in rows)
        if waited_for:
            self.flush()

    @uninterrupted_call
    def replace(self, old: Row, new: Row) -> None:
        """Put a row in the place of one that was written before; it is on the disk at return.

        Whatever happens meanwhile, the file has one of the two.

        Raises
        ------
        InputError
            If the disk is full or refuses; the old row stays.
        """
        self.flush()
        self._files.replace(old, new)

    @uninterrupted_call
    def write_soon(self, *rows: Row) -> None:
        """Append rows without waiting, between two frames."""
        others = []
        for row in rows:
            if isinstance(row, FrameRow):
                self._offer(row)
            else:
                others.append(row)
        if others:
            self._background.put(*others)
        self._background.check()  # not before: no row may be lost to the fault of another

    def take_external_changes(self) -> list[ExternalChange]:
        """Return the changes of other programs to the files since the last call."""
        found = [
            self._files.external_changes.popleft() for _ in range(len(self._files.external_changes))
        ]
        self.external_changes.extend(found)
        return found

    @uninterrupted_call
    def flush(self) -> None:
        """Wait until everything is in its file.

        Raises
        ------
        InputError
            If the disk refused a row since the last call.
        """
        self._tell_gap()
        self._background.finish()

    @uninterrupted_call
    def sync(self) -> None:
        """Wait until everything is on the disk.

        Raises
        ------
        InputError
            If the disk refused a row since the last call.
        """
        self.flush()
        self._files.sync()

    def _offer(self, row: FrameRow) -> None:
        if self._background.offer(row):
            self._tell_gap()
            return
        self._gap = self._gap or _Gap(row.session_s, row.session_s)
        self._gap.end_s = row.session_s
        self._gap.rows += 1
        self.frames_not_recorded += 1
        for ball in row.balls:  # they stand for the frames that follow, too
            self._background.put(ball)

    def _tell_gap(self) -> None:
        gap, self._gap = self._gap, None
        if gap is not None:
            detail = f"{gap.rows} frames: the disk is too slow; they are shown, but have no row"
            length_s = round(gap.end_s - gap.start_s, 9)
            self._background.put(EventRow(gap.start_s, length_s, "frames_not_recorded", detail))

    @uninterrupted_call
    def close(self) -> None:
        """Write the waiting rows, sync and close all files.

        Raises
        ------
        InputError
            If the disk refused a row since the last call.
        """
        if self._closed:
            return
        self._closed = True
        try:
            self._tell_gap()
            self._background.close()
        finally:
            self._files.close()

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


def overwriting(folder: Path, participant: str, session: int) -> InputError:
    """Return the error for a session that is there already."""
    message = f"session {session} of {participant} has been recorded and is never overwritten"
    remedy = "choose another participant, session or study folder"
    return InputError(f"{message}; {remedy}", file=folder)
