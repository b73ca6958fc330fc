"""The server's process, seen from the session: nothing here ever makes a frame wait.

The session's thread only appends to and takes from bounded queues. Two threads of this class write
them into the server's pipe and read from it. Where the server ends, whatever ended it, the session
goes on, and another server takes its place: with the same port and key, so that open pages come
back by themselves.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Self

from vrcomfort.console import wire
from vrcomfort.console.access import ConsoleAccess
from vrcomfort.errors import InputError
from vrcomfort.operator_interface import Command

QUEUE = 8
"""So many messages wait for the server; older ones are dropped. Each holds the whole state."""
# More than operators type between two frames; the oldest of a flood are dropped.
COMMANDS = 100
SEND_EVERY_S = 0.05
STARTS = 5
"""So many servers are started within `STARTS_WITHIN_S`; where all of them end, something is wrong
with them, and no other is started."""
STARTS_WITHIN_S = 30.0
START_S = 60.0
"""So long a first server may take to be there."""
END_S = 5.0
"""So long a server may take to be given what waits, and again to show it to all pages and end."""


class ServerProcess:
    """A context manager that keeps a server running.

    Parameters
    ----------
    say
        Tells the terminal a sentence.
    address
        Told each address that lets the next operator in.

    Attributes
    ----------
    pages, pictures
        How many pages are open, and how many of them want pictures.
    """

    def __init__(self, say: Callable[[str], None], address: Callable[[str], None]) -> None:
        self._say, self._tell_address = say, address
        self._access = ConsoleAccess(port=0)
        self._outbox: deque[bytes | Callable[[], bytes]] = deque(maxlen=QUEUE)
        self._last_state: bytes | None = None
        self._commands: deque[Command] = deque(maxlen=COMMANDS)
        self._begun: deque[float] = deque(maxlen=STARTS)
        self._process: subprocess.Popen[bytes] | None = None
        self._there = threading.Event()
        self._writing: threading.Thread | None = None
        self._ending = False
        self._lock = threading.Lock()
        self.pages = self.pictures = 0

    @property
    def pid(self) -> int | None:
        """Return the number of the server's process."""
        return None if self._process is None else self._process.pid

    @property
    def port(self) -> int:
        """Return where it listens; 0 before it does."""
        return self._access.port

    def show(self, state: Mapping[str, Any]) -> None:
        """Have a state shown; returns at once. The state must not change any more."""
        self._outbox.append(lambda: self._packed_state(state))

    def show_picture(self, make: Callable[[], bytes]) -> None:
        """Have a picture shown, made by `make` in another thread (see `server.jpeg`)."""
        self._outbox.append(lambda: wire.framed(wire.PICTURE, make()))

    def next_command(self) -> Command | None:
        """Return the next command, or None at once."""
        return self._commands.popleft() if self._commands else None

    def __enter__(self) -> Self:
        self._start()
        if not self._there.wait(START_S):
            self.close()
            raise InputError(f"the console's server did not start within {START_S:g} s")
        if self._process is None:
            raise InputError("the console's server cannot be started; run without --console")
        self._writing = threading.Thread(target=self._write, name="console writer", daemon=True)
        self._writing.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Send the waiting messages, and end the server; kill one that hangs."""
        self._ending = True
        if self._writing is not None:
            self._writing.join(END_S)
        process = self._process
        if process is None:
            return
        if self._writing is not None and self._writing.is_alive():
            process.kill()
        self._end_input(process)
        try:
            process.wait(END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _end_input(self, process: subprocess.Popen[bytes]) -> None:
        """Have a server end, as it does where its standard input ends."""
        if not self._lock.acquire(timeout=END_S):  # whoever has it writes to one that stands still
            process.kill()
            self._lock.acquire()
        with suppress(OSError):
            if process.stdin is not None:
                process.stdin.close()
        self._lock.release()

    def _start(self) -> None:
        self._begun.append(time.monotonic())
        process = subprocess.Popen(
            [sys.executable, "-m", "vrcomfort.console.server"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=os.name == "posix",  # Ctrl-C is for the session
        )
        access = self._access
        settings = {"port": access.port, "key": access.key, "token": access.token}
        with self._lock:  # nothing else may be its first message, and no state be lost between two
            self._process = process
            self._put(wire.packed({**settings, "operators": access.operators}))
            if self._last_state is not None:
                self._put(self._last_state)
        threading.Thread(
            target=self._read, args=(process,), name="console reader", daemon=True
        ).start()

    def _send(self, message: bytes) -> None:
        with self._lock:
            self._put(message)

    def _put(self, message: bytes) -> None:
        process = self._process
        if process is None or process.stdin is None:
            return
        with suppress(OSError, ValueError):  # gone, or just closed: `_read` sees it
            process.stdin.write(message)
            process.stdin.flush()

    def _packed_state(self, state: Mapping[str, Any]) -> bytes:
        self._last_state = wire.packed(state)
        return self._last_state

    def _drain(self) -> None:
        while self._outbox:
            message = self._outbox.popleft()
            self._send(message if isinstance(message, bytes) else message())

    def _write(self) -> None:
        while not self._ending:
            self._drain()
            time.sleep(SEND_EVERY_S)
        self._drain()

    def _read(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdout is not None  # noqa: S101 - tells mypy what `_start` knows
        while (message := wire.read_message(process.stdout)) is not None:
            self._take(wire.unpacked(message[1]))
        code = process.wait()
        with self._lock:
            for pipe in (process.stdin, process.stdout):
                with suppress(OSError):
                    if pipe is not None:
                        pipe.close()
        self.pages = self.pictures = 0
        if not self._ending:
            self._start_again(code)

    def _take(self, content: dict[str, Any]) -> None:
        kind = content.pop("kind")
        if kind == "command":
            self._commands.append(Command(**content))
        elif kind == "watching":
            self.pages, self.pictures = content["pages"], content["pictures"]
        elif kind == "access":
            access = self._access
            new = access.token != content["token"] or not access.port
            access.port, access.token = content["port"], content["token"]
            access.operators = content["operators"]
            self._there.set()
            if new:
                self._tell_address(access.address)

    def _start_again(self, code: int) -> None:
        how = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
        often = len(self._begun) == STARTS
        if not self._there.is_set() or (
            often and time.monotonic() - self._begun[0] < STARTS_WITHIN_S
        ):
            self._process = None
            self._there.set()
            words = "the session goes on without it; Ctrl-C ends the session"
            self._say(f"the console's server ended again and again ({how}); {words}")
            return
        words = "the session goes on, and another server takes its place"
        self._say(f"the console's server ended ({how}); {words}: open pages come back")
        self._start()
        if self._ending and self._process is not None:  # by now: `close` saw the one before
            self._end_input(self._process)
