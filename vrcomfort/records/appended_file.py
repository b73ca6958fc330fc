"""A file that lines are appended to, and how much of it is on the disk."""

from __future__ import annotations

import os
import time
from pathlib import Path

from vrcomfort.records.disk import Access, open_new, refused, sync_data


class AppendedFile:
    """One open file; what the disk has refused comes before what is appended later.

    Parameters
    ----------
    fresh
        Begin with an empty file.

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

    def __init__(self, file: Path, access: Access, *, fresh: bool) -> None:
        self._file = file
        self._waiting = bytearray()
        end = os.O_TRUNC if fresh else os.O_APPEND
        self._descriptor = open_new(file, access, os.O_WRONLY | end)
        self.unsynced_since_s: float | None = None

    def fileno(self) -> int:
        """Return the file's descriptor."""
        return self._descriptor

    def append(self, text: str) -> None:
        """Take text; `flush` writes it."""
        self._waiting += text.encode(errors="replace")  # `csv_line` has left nothing to replace
        if self.unsynced_since_s is None:
            self.unsynced_since_s = time.monotonic()

    def flush(self) -> None:
        """Write what waits: another program can read it, and the end of this one loses nothing.

        Raises
        ------
        InputError
            If the disk refuses; what it did not take is written next time.
        """
        try:
            while self._waiting:
                del self._waiting[: os.write(self._descriptor, self._waiting)]
        except OSError as error:
            raise refused(self._file, error) from error

    def sync(self) -> None:
        """Write what waits, and wait until it is on the disk: not even a power cut loses it.

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

    def close(self) -> None:
        """Close the file without writing."""
        os.close(self._descriptor)
