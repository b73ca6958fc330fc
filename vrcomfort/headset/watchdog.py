"""Sees when a call into a headset's runtime does not return, and ends the program on request.

A runtime that hangs keeps the main thread inside of C. Python's signal handlers run in the main
thread between two of its instructions, so nobody hears Ctrl-C then. The watchdog is a thread of
its own: it is told of signals by a socket (`signal.set_wakeup_fd`), which works all the same.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Self

from vrcomfort.stop_signals import TOGETHER_S

NOTICE_S = 5.0
"""Time after which a call counts as hung: runtimes answer within a few refreshes."""

PATIENCE_S = 600.0
"""Time after which the program ends without the runtime and without Ctrl-C."""

EXIT_RUNTIME_LOST = 3

POLL_S = 0.1
DECIDES_S = 30.0
"""The watchdog looks every 0.1 s; on a machine that is halted, within this."""

STOPPING = {
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    if hasattr(signal, name)
}  # fmt: skip

Call = tuple[str, float]
"""The name of a function of the runtime, and when it was called (monotonic, seconds)."""


class RuntimeCalls:
    """Which function of the runtime the program waits for; another thread may look.

    Attributes
    ----------
    under_way
        The call, or None. Each call is an object of its own.
    hung
        The call that the watchdog has told of.
    held
        While True nobody comes back from a call: another thread closes the records.
    looks
        How often the watchdog has listened for signals and looked at the call.
    stalls
        Calls that hung and then returned, in words, for whoever keeps the record.
    spent_s
        By function, the seconds within it since somebody took them.
    """

    def __init__(self) -> None:
        self.under_way: Call | None = None
        self.hung: Call | None = None
        self.held = False
        self.looks = 0
        self.stalls: deque[str] = deque()
        self.spent_s: dict[str, float] = {}

    def begin(self, name: str) -> None:
        """Take note that `name` is called."""
        self.under_way = name, time.monotonic()

    def end(self) -> None:
        """Take note that it has returned."""
        call = self.under_way
        if call is not None and call is self.hung:
            self._wait(looks=2)  # the first may have listened before the signal
        self.under_way = None
        if call is not None:
            name, began_s = call
            self.spent_s[name] = self.spent_s.get(name, 0.0) + time.monotonic() - began_s
        if self.held:
            self._wait()

    def take_spent_ms(self, names: Iterable[str]) -> float:
        """Return the milliseconds within some functions since the last time, and forget them."""
        return 1e3 * sum(self.spent_s.pop(name, 0.0) for name in names)

    def _wait(self, looks: int = 0) -> None:
        """Let the watchdog decide first: a signal that has brought the call back ends it."""
        interrupted = False
        enough, latest_s = self.looks + looks, time.monotonic() + DECIDES_S
        while self.held or (self.looks < enough and time.monotonic() < latest_s):
            try:
                time.sleep(POLL_S / 2)
            except KeyboardInterrupt:  # the watchdog has heard it, too
                interrupted = True
        if interrupted:
            self.under_way = None
            raise KeyboardInterrupt


RUNTIME_CALLS = RuntimeCalls()
"""Of this process: it has one runtime, and one thread that calls it."""


class Watchdog:
    """Watches the calls into a runtime; a context manager, to be entered in the main thread.

    Where a call hangs, it says so. Ctrl-C is then answered here: the records are closed, and the
    program ends without another word to the runtime. It also ends where the records are closed
    already, for then nothing is worth waiting for.

    Parameters
    ----------
    say
        Tells the operator a sentence.
    calls
        What is watched.
    notice_s
        After so long a call hangs.
    patience_s
        After so long the program ends by itself.
    go_on
        Told once the records are closed: the words that take the session up again.
    leave
        Ends the program with an exit code: 130 after Ctrl-C, 128 and its number after another
        signal, else 3.

    Attributes
    ----------
    last_acts
        Called before the program is ended so: what would else be left behind.
    """

    def __init__(
        self,
        say: Callable[[str], None],
        *,
        calls: RuntimeCalls = RUNTIME_CALLS,
        notice_s: float = NOTICE_S,
        patience_s: float = PATIENCE_S,
        go_on: str = "",
        leave: Callable[[int], None] = os._exit,
    ) -> None:
        self._say, self._calls, self._leave = say, calls, leave
        self._notice_s, self._patience_s = notice_s, patience_s
        self._go_on = go_on
        self.last_acts: list[Callable[[], object]] = []
        self._close: Callable[[], None] | None = None
        self._asked = 0
        self._closed = self._done = False
        self._ear, self._mouth = socket.socketpair()
        self._thread = threading.Thread(target=self._watch, name="watchdog", daemon=True)

    def __enter__(self) -> Self:
        for end in (self._ear, self._mouth):
            end.setblocking(False)
        self._before = -1
        if threading.current_thread() is threading.main_thread():
            fd = self._mouth.fileno()
            self._before = signal.set_wakeup_fd(fd, warn_on_full_buffer=False)
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self._done = True
        if threading.current_thread() is threading.main_thread():
            signal.set_wakeup_fd(self._before)
        self._thread.join()
        self._ear.close()
        self._mouth.close()

    @contextmanager
    def guard(self, close: Callable[[], None]) -> Iterator[None]:
        """Have records closed by `close` if the program must be ended inside of this context.

        `close` runs in another thread, while the main one hangs in the runtime.
        """
        self._close, self._closed = close, False
        try:
            yield
        finally:
            self._close, self._closed = None, True

    def _watch(self) -> None:
        while not self._done:
            self._asked = self._hear() or self._asked
            self._look()
            self._calls.looks += 1

    def _hear(self) -> int:
        """Wait a little; return the signal that has asked the program to stop meanwhile, else 0."""
        heard, _, _ = select.select([self._ear], [], [], POLL_S)
        numbers = self._ear.recv(64) if heard else b""
        return next((number for number in numbers if number in STOPPING), 0)

    def _look(self) -> None:
        calls = self._calls
        call, hung = calls.under_way, calls.hung
        if hung is not None and call is not hung:
            self._came_back(hung)
        if call is None:
            return
        waited_s = time.monotonic() - call[1]
        if waited_s < self._notice_s:
            return
        ending = bool(self._asked) or self._closed or waited_s >= self._patience_s
        if calls.hung is not call:
            calls.hung = call
            self._tell(self._sentence(call, ending=ending))
        if ending:
            self._give_up(call)

    def _sentence(self, call: Call, *, ending: bool) -> str:
        hangs = f"the OpenXR runtime has not answered {call[0]} for {self._notice_s:g} s"
        if ending:
            return f"{hangs}; the program ends without it"
        return (
            f"{hangs}; the session goes on if it does; Ctrl-C ends the session and closes its "
            "records (start the runtime again before you --resume)"
        )

    def _came_back(self, call: Call) -> None:
        self._calls.hung = None
        words = f"{call[0]} returned after {time.monotonic() - call[1]:.1f} s"
        self._calls.stalls.append(words)
        self._tell(f"the OpenXR runtime answers again: {words}")

    def _give_up(self, call: Call) -> None:
        self._calls.held = True
        if self._calls.under_way is not call:  # it came back at the last moment
            self._calls.held = False
            return
        closing = threading.Thread(target=self._close_all, daemon=True)
        closing.start()
        began_s = time.monotonic()
        while closing.is_alive():
            again = self._hear()  # once more: do not wait for the disk, too
            together = time.monotonic() - began_s < TOGETHER_S
            if again and not (together and again != signal.SIGINT):
                break
        with suppress(OSError, ValueError):
            sys.stdout.flush()
            sys.stderr.flush()
        self._leave(128 + self._asked if self._asked else EXIT_RUNTIME_LOST)

    def _tell(self, sentence: str) -> None:
        with suppress(Exception, SystemExit):  # nobody may be there: a closed terminal or pipe
            self._say(sentence)

    def _close_all(self) -> None:
        if self._close is not None:
            try:
                self._close()
                self._tell("stopped; all that was recorded is kept")
                if self._go_on:
                    self._tell(self._go_on)
            except Exception as error:  # a full disk, say: there is nobody else to tell it
                self._tell(f"the records could not be closed: {error}")
        for act in self.last_acts:
            with suppress(Exception):
                act()
