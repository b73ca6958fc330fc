"""Writes rows in a thread of its own, so that a slow disk never holds up a frame."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from threading import Condition, Thread
from typing import Protocol

from vrcomfort.records.rows import Row

CAPACITY = 4096
"""Rows that may wait: 45 s of frames at 90 Hz, about 15 MB."""


class RowSink(Protocol):
    """Where rows go."""

    def write(self, rows: Sequence[Row]) -> None:
        """Take rows that came together, or none: see `due_in_s`."""

    def due_in_s(self) -> float | None:
        """Return in how many seconds `write` is to be called even without rows; None: need not."""


class BackgroundWriter:
    """Hands rows to a sink in the order in which they came, those that wait together.

    Parameters
    ----------
    sink
        Runs in the thread. What it raises is raised again by the next `check`, `finish` or
        `close`; the rows after it are still written.
    capacity
        Rows that may wait before `offer` refuses.
    """

    def __init__(self, sink: RowSink, *, capacity: int = CAPACITY) -> None:
        self._sink = sink
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
        """Write what waits, and end the thread; only what the sink raised is left to tell."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        self._thread.join()
        self.check()

    def _add(self, row: Row) -> None:
        self._rows.append(row)
        self._changed.notify_all()

    def _run(self) -> None:
        while (rows := self._next()) is not None:
            fault = self._try(rows)
            with self._changed:
                self._fault = self._fault or fault
                for _ in rows:
                    self._rows.popleft()  # only now: an empty queue says that all is in the files
                self._changed.notify_all()

    def _try(self, rows: Sequence[Row]) -> Exception | None:
        try:
            self._sink.write(rows)
        except Exception as error:  # it belongs to whoever wrote the row
            return error
        return None

    def _next(self) -> Sequence[Row] | None:
        """Wait for rows, or until the sink is due (then there are none); None at the end."""
        due_in_s = self._sink.due_in_s()
        with self._changed:
            self._changed.wait_for(lambda: self._rows or self._closing, due_in_s)
            return tuple(self._rows) if self._rows or not self._closing else None
