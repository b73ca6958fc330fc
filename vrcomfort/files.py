"""Opens files for reading: regular files alone, and whole only up to a size that memory holds.

Every reader of the package goes through here (`tests/test_files.py` looks for others), for a file
may be anything that another program, or a person, has put in its place. A pipe or a device may have
no end or stand still for ever, and so may a link to one.
"""

from __future__ import annotations

import hashlib
import os
import stat
from io import BufferedReader
from pathlib import Path

from vrcomfort.errors import InputError

MOST_BYTES = 2**28
"""Of a file that is read as a whole."""
MOST_TEXT_BYTES = 2**26
"""Of a text that is read as a whole: a stored JSON file, a script, a list."""

_AT_ONCE = getattr(os, "O_NONBLOCK", 0)
"""A pipe that took the file's place a moment ago is opened without waiting; Windows has no such."""


def open_file(file: Path) -> BufferedReader:
    """Open a regular file for reading bytes.

    Raises
    ------
    InputError
        If it is a pipe, a socket or a device, or a link to one.
    OSError
        If it cannot be opened.
    """
    refuse_special(file)
    return open(file, "rb", opener=lambda name, flags: os.open(name, flags | _AT_ONCE))


def refuse_special(file: Path) -> None:
    """Raise `InputError` if a path leads to a pipe, a socket or a device.

    Raises
    ------
    OSError
        If there is nothing, or the system does not say what.
    """
    mode = file.stat().st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):  # of a folder, the system says so
        message = f"this is {_kind(mode)}, and only files are read; put a file in its place"
        raise InputError(message, file=file)


def _kind(mode: int) -> str:
    if stat.S_ISFIFO(mode):
        return "a pipe"
    return "a socket" if stat.S_ISSOCK(mode) else "a device"


def read_bytes(file: Path, *, most: int = MOST_BYTES) -> bytes:
    """Return the content of a file of at most `most` bytes.

    Raises
    ------
    InputError
        If it is larger, or is no regular file.
    OSError
        If it cannot be read.
    """
    with open_file(file) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > most:
            message = f"this file has {size:,} bytes, and at most {most:,} are read of such a file"
            raise InputError(f"{message}; is it the right one?", file=file)
        return stream.read()


def read_text(file: Path, what: str, *, most: int = MOST_TEXT_BYTES) -> str:
    """Return the text of a UTF-8 file, with line feeds at the ends of its lines.

    Raises
    ------
    InputError
        If it cannot be read, or has more than `most` bytes; `what` says what it should have been.
    """
    try:
        content = read_bytes(file, most=most)
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except OSError as error:
        raise InputError(f"cannot read this {what}: {error.strerror}", file=file) from error
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        message = f"this line is not UTF-8; save the {what} as UTF-8"
        raise InputError(message, file=file, line=line) from error


def sha256_of(file: Path) -> str:
    """Return the SHA-256 of a file of any size, in hexadecimal digits.

    Raises
    ------
    InputError
        If it is no regular file.
    OSError
        If it cannot be read.
    """
    with open_file(file) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
