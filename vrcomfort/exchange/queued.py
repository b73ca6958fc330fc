"""Hands work to a thread of its own, so that the caller never waits."""

from __future__ import annotations

from collections.abc import Callable
from queue import Empty, Full, Queue
from threading import Event, Thread

CAPACITY = 4096
"""So much may wait: what comes then is left out, and counted."""


class Queued:
    """Does work in the order in which it was given, in another thread; a context manager.

    Parameters
    ----------
    name
        Of the thread.
    capacity
        The most that may wait.
    """

    def __init__(self, name: str, *, capacity: int = CAPACITY) -> None:
        self._work: Queue[Callable[[], None]] = Queue(capacity)
        self._closing = Event()
        self._left_out = 0
        self._thread = Thread(target=self._do, name=name, daemon=True)
        self._thread.start()

    def put(self, work: Callable[[], None]) -> None:
        """Give work, without waiting; where too much waits already, it is left out."""
        try:
            self._work.put_nowait(work)
        except Full:
            self._left_out += 1

    def take_left_out(self) -> int:
        """Return how much was left out, or failed, since the last call."""
        count, self._left_out = self._left_out, 0
        return count

    def close(self, timeout_s: float = 2.0) -> None:
        """Do the waiting work, for a limited time."""
        self._closing.set()
        self._thread.join(timeout_s)

    def _do(self) -> None:
        while True:
            try:
                work = self._work.get(timeout=0.05)
            except Empty:
                if self._closing.is_set():
                    return
                continue
            try:
                work()
            except Exception:
                self._left_out += 1
