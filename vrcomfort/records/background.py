"""Writes rows in a thread of its own, so that a slow disk never holds up a frame."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Condition, Thread

from vrcomfort.records.rows import Row

CAPACITY = 4096
"""Rows that may wait: 45 s of frames at 90 Hz, about 15 MB."""


class BackgroundWriter:
    """Calls `write` with one row after the other, in the order in which they came.

    Parameters
    ----------
    write
        Runs in the thread. What it raises is raised again by the next `check`, `finish` or
        `close`; the rows after it are still written.
    capacity
        Rows that may wait before `offer` refuses.
    """

    def __init__(self, write: Callable[[Row], None], *, capacity: int = CAPACITY) -> None:
        self._write = write
        self._capacity = capacity
        self._rows: deque[Row] = deque()
        self._changed = Condition()
        self._fault: Exception | None = None
        self._closing = False
        self._thread = Thread(target=self._run, name="recorder", daemon=True)
        self._thread.start()

    def offer(self, row: Row) -> bool:
        """Take a row, or return False where too many wait; never waits."""
        with self._changed:
            if len(self._rows) >= self._capacity:
                return False
            self._add(row)
        return True

    def put(self, row: Row) -> None:
        """Take a row, however many wait; never waits."""
        with self._changed:
            self._add(row)

    def check(self) -> None:
        """Raise what `write` has raised."""
        with self._changed:
            fault, self._fault = self._fault, None
        if fault is not None:
            raise fault

    def finish(self) -> None:
        """Wait until every row has been written."""
        with self._changed:
            self._changed.wait_for(lambda: not self._rows)
        self.check()

    def close(self) -> None:
        """Write what waits, and end the thread; only what `write` raised is left to tell."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._thread.join()
        self.check()

    def _add(self, row: Row) -> None:
        self._rows.append(row)
        self._changed.notify_all()

    def _run(self) -> None:
        while (row := self._next()) is not None:
            fault = self._try(row)
            with self._changed:
                self._fault = self._fault or fault
                self._rows.popleft()  # only now: what waits for an empty queue waits for the file
                self._changed.notify_all()

    def _try(self, row: Row) -> Exception | None:
        try:
            self._write(row)
        except Exception as error:  # it belongs to whoever wrote the row
            return error
        return None

    def _next(self) -> Row | None:
        with self._changed:
            self._changed.wait_for(lambda: self._rows or self._closing)
            return self._rows[0] if self._rows else None
