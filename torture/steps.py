"""Stops a session at a chosen step: a line of what records or runs it, in a child of this process.

A child is forked, so that it begins within milliseconds and hears real signals. Its disk needs no
time: syncs are only counted, for the power cut.
"""

from __future__ import annotations

import errno
import json
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

import vrcomfort
from vrcomfort.cli import stopping
from vrcomfort.errors import InputError
from vrcomfort.records import disk
from vrcomfort.stop_signals import SIGNALS

_PACKAGE = Path(vrcomfort.__file__).parent
WATCHED = tuple(str(_PACKAGE / name) for name in ("records", "session", "stop_signals.py"))
SYNCED = "synced.json"
PAGE = 512
"""Bytes that a file of the small disk takes at once."""
FELL, REFUSED, STOPPED = 9, 2, 130
"""Exit codes of a child: of an exception, of a sentence, of a signal that it heard."""
NOT_HEARD = {"SIGKILL", "power cut"}
"""They may come while the thread writes that writes rows."""
HUNG = -signal.SIGALRM
LIMIT_S = 60


class Fate(NamedTuple):
    """What happens to a session, and at which step.

    Parameters
    ----------
    name
        ``SIGINT``, ``SIGTERM``, ``SIGHUP``, ``SIGINT twice``, ``SIGKILL``, ``power cut`` or ``full
        disk``; ``none`` where it comes to its end.
    step
        0 is the first; for the full disk the bytes that it takes.
    """

    name: str
    step: int = 0
    again_s: float = 0.0
    """After which the second signal comes."""


def run(work: Callable[[], object], fate: Fate, beside: Path) -> tuple[int, int]:
    """Do the work in a child that meets its fate; return its exit code and its steps.

    Parameters
    ----------
    beside
        A folder for what the child leaves behind: ``synced.json`` and, of a fall, ``fell.txt``.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        code = FELL
        try:
            code = _live(work, fate, beside, writing)
        except BaseException:
            (beside / "fell.txt").write_text(traceback.format_exc())
        finally:
            os._exit(code)
    os.close(writing)
    with os.fdopen(reading) as told:
        steps = told.read()
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), int(steps or 0)


def _live(work: Callable[[], object], fate: Fate, beside: Path, writing: int) -> int:
    signal.alarm(LIMIT_S)
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    synced = _Synced()
    if fate.name == "full disk":
        _SmallDisk(fate.step).install()
    steps = _Steps(fate, synced, beside)
    code = 0
    with stopping.heard():
        if fate.name in NOT_HEARD:  # while a signal waits for the main thread, Python 3.11 stands
            threading.settrace(steps.trace)  # still in a function of another that is traced
        sys.settrace(steps.trace)
        try:
            work()
        except KeyboardInterrupt:
            code = STOPPED
        except InputError as error:
            (beside / "said.txt").write_text(str(error))
            code = REFUSED
        finally:
            sys.settrace(None)
            threading.settrace(None)
        with suppress(KeyboardInterrupt):  # the work was over before the second signal came
            steps.await_signals()
    with os.fdopen(writing, "w") as telling:  # past the small disk
        telling.write(str(steps.count))
    return code


class _Steps:
    """Counts lines, in whatever thread, and lets things happen at one."""

    def __init__(self, fate: Fate, synced: _Synced, beside: Path) -> None:
        self.count = 0
        self._fate, self._synced, self._beside = fate, synced, beside
        self._at = -1 if fate.name in {"none", "full disk"} else fate.step
        self._second: threading.Timer | None = None

    def await_signals(self) -> None:
        """Return when no further signal comes."""
        if self._second is not None:
            self._second.join()

    def trace(self, frame: FrameType, event: str, _: Any) -> Any:
        if event == "line":
            self.count += 1
            if self.count == self._at:
                self._happen()
        elif not frame.f_code.co_filename.startswith(WATCHED):
            return None
        return self.trace

    def _happen(self) -> None:
        name, me = self._fate.name, os.getpid()
        if name == "power cut":
            self._synced.write(self._beside / SYNCED)
        if name in {"power cut", "SIGKILL"}:
            os.kill(me, signal.SIGKILL)
        if name == "SIGINT twice":  # Python stops to count where a signal is heard
            self._second = threading.Timer(self._fate.again_s, os.kill, (me, signal.SIGINT))
            self._second.start()
        os.kill(me, getattr(signal, name.split()[0]))


class _Synced:
    """How much of each file was synced: what a power cut cannot take."""

    def __init__(self) -> None:
        self._bytes: dict[int, int] = {}
        changed: Any = os
        changed.fsync = changed.fdatasync = self._sync

    def _sync(self, file: Any) -> None:
        found = os.fstat(file if isinstance(file, int) else file.fileno())
        self._bytes[found.st_ino] = found.st_size

    def write(self, file: Path) -> None:
        file.write_text(json.dumps(self._bytes))


class _SmallDisk:
    """A disk that takes so many bytes, a page at a time: what fits into a file's last page fits."""

    def __init__(self, size_bytes: int) -> None:
        self._pages = size_bytes // PAGE
        self._write, self._open = os.write, disk.open_new

    def install(self) -> None:
        """Let all files be on it."""
        changed: Any = os
        changed.write = self.write
        changed = disk
        changed.open_new = self.open_new

    def write(self, descriptor: int, content: bytes) -> int:
        """Write what there is room for."""
        found = os.fstat(descriptor)
        room = -found.st_size % PAGE + self._pages * PAGE
        if not room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = self._write(descriptor, bytes(content[:room]))
        pages = -(-(found.st_size + written) // PAGE) - -(-found.st_size // PAGE)
        self._pages -= pages
        return written

    def open_new(self, file: Path, access: disk.Access, flags: int) -> int:
        """Make no new file where there is not a page."""
        if flags & os.O_EXCL and self._pages < 1:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self._open(file, access, flags)
