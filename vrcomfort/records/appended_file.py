"""A file that lines are appended to, and how much of it is on the disk."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from vrcomfort.records.disk import Access, open_new, refused, sync_data, sync_folder


class ExternalChange(NamedTuple):
    """A change that another program has made to an open file.

    Parameters
    ----------
    sentence
        What, and what became of the file.
    lost
        Rows are gone that cannot be had back.
    """

    sentence: str
    lost: bool = False


class AppendedFile:
    """One open file; text that the disk has refused is written before later text.

    Parameters
    ----------
    fresh
        Begin with an empty file.
    header
        The line with which an empty file begins.

    Attributes
    ----------
    unsynced_since_s
        When the oldest content that may not be on the disk came (`time.monotonic`); else None.

    Raises
    ------
    InputError
        If it is a symbolic link.
    OSError
        If the disk refuses to open it.
    """

    def __init__(self, file: Path, access: Access, *, fresh: bool, header: str) -> None:
        self._file, self._access, self._header = file, access, header
        self._waiting = bytearray()
        end = os.O_TRUNC if fresh else 0
        self._descriptor = open_new(file, access, os.O_RDWR | os.O_APPEND | end)
        self._size = os.fstat(self._descriptor).st_size
        self.unsynced_since_s: float | None = None
        if not self._size:
            self.append(header)

    def fileno(self) -> int:
        """Return the file's descriptor."""
        return self._descriptor

    @property
    def waits(self) -> bool:
        """Whether content waits that the file does not have."""
        return bool(self._waiting)

    def append(self, text: str) -> None:
        """Take text; `flush` writes it."""
        self._waiting += text.encode(errors="replace")  # `csv_line` has left nothing to replace
        if self.unsynced_since_s is None:
            self.unsynced_since_s = time.monotonic()

    def flush(self) -> None:
        """Write the waiting text: other programs can read it, and it outlives this one.

        Raises
        ------
        InputError
            If the disk refuses; what it did not take is written next time.
        """
        try:
            while self._waiting:
                written = os.write(self._descriptor, self._waiting)
                self._size += written
                del self._waiting[:written]
        except OSError as error:
            raise refused(self._file, error) from error

    def sync(self) -> None:
        """Write the waiting text and sync it to the disk: not even a power cut loses it.

        Raises
        ------
        InputError
            If the disk refuses.
        """
        self.unsynced_since_s = time.monotonic()  # where it refuses, it is asked again later
        self.flush()
        try:
            sync_data(self._descriptor)
        except OSError as error:
            raise refused(self._file, error) from error
        self.unsynced_since_s = None

    def guard(self) -> ExternalChange | None:
        """Check that the file has the written text, under its name; restore it where possible.

        Raises
        ------
        InputError
            If the disk refuses to put it back.
        """
        ours = os.fstat(self._descriptor)
        if not stat.S_ISREG(ours.st_mode):
            return None
        before, self._size = self._size, ours.st_size
        try:
            if ours.st_size < before:
                return self._begin_a_line(before - ours.st_size)
            there = self._there()
            if there is not None and _is_same(ours, there):
                return None
            return self._put_back(replaced=there is not None)
        except OSError as error:
            raise refused(self._file, error) from error

    def _there(self) -> os.stat_result | None:
        try:
            return self._file.lstat()
        except FileNotFoundError:
            return None

    def _content(self) -> Iterator[bytes]:
        os.lseek(self._descriptor, 0, os.SEEK_SET)
        while content := os.read(self._descriptor, _CHUNK):
            yield content

    def _begin_a_line(self, cut_bytes: int) -> ExternalChange:
        """Leave whole lines in a file that was cut, so that the next row can be read."""
        whole = at = 0
        for content in self._content():
            whole = at + content.rfind(b"\n") + 1 if b"\n" in content else whole
            at += len(content)
        os.ftruncate(self._descriptor, whole)
        self._size = whole
        if not whole:
            self._waiting[:0] = self._header.encode()
        cut = f"another program has cut off the last {cut_bytes} bytes of this file"
        return ExternalChange(
            f"{self._file}: {cut} while it was recorded; these rows are lost", lost=True
        )

    def _put_back(self, *, replaced: bool) -> ExternalChange:
        """Write a new file with the content of the open one."""
        done = "removed"
        if replaced:
            aside = _free_name(self._file)
            self._file.rename(aside)
            done = f"replaced (by what is now {aside.name})"
        draft = self._file.with_name(f".{self._file.name}.new")
        draft.unlink(missing_ok=True)
        descriptor = open_new(draft, self._access, os.O_RDWR | os.O_APPEND | os.O_EXCL)
        try:
            for content in self._content():
                rest = memoryview(content)
                while rest:
                    rest = rest[os.write(descriptor, rest) :]
            os.fsync(descriptor)
            draft.rename(self._file)
            sync_folder(self._file.parent)
        except OSError:
            os.close(descriptor)
            raise
        os.close(self._descriptor)
        self._descriptor = descriptor
        message = f"{self._file}: another program has {done} this file while it was recorded"
        return ExternalChange(f"{message}; all of its rows were written again")

    def close(self) -> None:
        """Close the file without writing."""
        os.close(self._descriptor)


# A copy of a long recording is made in pieces: it would not fit into memory beside the frames.
_CHUNK = 1 << 20


def _is_same(ours: os.stat_result, there: os.stat_result) -> bool:
    """Return whether two are one file; some network folders number a file anew."""
    if (ours.st_dev, ours.st_ino) == (there.st_dev, there.st_ino):
        return True
    linked = ours.st_nlink > 0
    return linked and (ours.st_size, ours.st_mtime_ns) == (there.st_size, there.st_mtime_ns)


def _free_name(file: Path) -> Path:
    """Return an unused name for the file that stands in another's place."""
    names = (file.with_name(f"{file.name}.replaced{number}") for number in range(1, 10**6))
    return next(each for each in names if not each.exists())
