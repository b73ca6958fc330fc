"""Locks that only one program holds at a time, and that end with it, however it ends.

The operating system holds the lock; what the file says is for people. So a file that a dead
program left behind locks nobody out.
"""

from __future__ import annotations

import errno
import json
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from vrcomfort.errors import InputError
from vrcomfort.json_text import parse_json
from vrcomfort.records.disk import Access, open_new

if sys.platform == "win32":
    import msvcrt

    _FAR = 1 << 30  # a locked byte cannot be read, so it lies behind the text

    def _lock(stream: IO[str], *, wait: bool) -> None:
        os.lseek(stream.fileno(), _FAR, os.SEEK_SET)
        msvcrt.locking(stream.fileno(), msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
        os.lseek(stream.fileno(), 0, os.SEEK_SET)
else:
    import fcntl

    def _lock(stream: IO[str], *, wait: bool) -> None:
        fcntl.flock(stream, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))


_HELD = {errno.EAGAIN, errno.EACCES, errno.EDEADLK}
"""What a lock says that another program holds."""


@contextmanager
def only_program(file: Path, access: Access, *, doing: str) -> Iterator[None]:
    """Hold the lock of a file, or refuse where another program holds it.

    Parameters
    ----------
    doing
        What the message says is being done: "P01 is being run".

    Raises
    ------
    InputError
        If another program holds the lock; names its process. Or if it cannot be locked: some
        network folders cannot.
    """
    with _open(file, access) as stream:
        _take(stream, file, wait=False, doing=doing)
        _sign(stream)
        try:
            yield
        finally:
            _wipe(stream)


@contextmanager
def in_turn(file: Path, access: Access) -> Iterator[None]:
    """Hold the lock of a file, after waiting for whoever holds it.

    Raises
    ------
    InputError
        If it cannot be locked.
    """
    with _open(file, access) as stream:
        _take(stream, file, wait=True, doing=f"{file.name} is being held")
        yield


def _take(stream: IO[str], file: Path, *, wait: bool, doing: str) -> None:
    try:
        _lock(stream, wait=wait)
    except OSError as error:
        if error.errno in _HELD:
            raise InputError(f"{doing} by {_holder(file)}; wait until it ends") from error
        message = f"cannot lock: {error.strerror}; put the study on a disk of this machine"
        raise InputError(message, file=file) from error


def _open(file: Path, access: Access) -> IO[str]:
    try:
        return os.fdopen(open_new(file, access, os.O_RDWR), "r+", encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot make this file: {error.strerror}", file=file) from error


def _sign(stream: IO[str]) -> None:
    _wipe(stream)
    stream.write(json.dumps({"pid": os.getpid(), "host": socket.gethostname()}) + "\n")
    stream.flush()


def _wipe(stream: IO[str]) -> None:
    """Empty the file. It stays: a file that is removed could be locked by two at once."""
    stream.seek(0)
    stream.truncate()
    stream.flush()


def _holder(file: Path) -> str:
    try:
        said = parse_json(file.read_text(encoding="utf-8"), file)
        return f"process {said['pid']} on {said['host']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another program"
