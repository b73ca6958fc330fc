"""How much memory reading may take, and the database that keeps to it."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import duckdb

from vrcomfort.errors import InputError
from vrcomfort.escaping import escape_unprintable

_UNITS = {"MB": 10**6, "GB": 10**9, "MIB": 2**20, "GIB": 2**30}
_SIZE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(MB|GB|MIB|GIB)\s*", re.IGNORECASE)
_FOR_PYTHON_BYTES = 128 * 10**6
"""What the interpreter and its packages take, and what the database does not count of its own."""
_LEAST_BYTES = 256 * 10**6


@dataclass(frozen=True)
class Memory:
    """The most memory that a process which reads recordings takes, in bytes."""

    limit_bytes: int = 512 * 10**6

    @classmethod
    def of_text(cls, text: str) -> Memory:
        """Read a size such as ``512MB``.

        Raises
        ------
        InputError
            If it is none, or too little for any recording.
        """
        found = _SIZE.fullmatch(text)
        if found is None:
            raise InputError(f"--memory {text!r} is not a size; write for example 512MB or 2GB")
        size = int(float(found[1]) * _UNITS[found[2].upper()])
        if size < _LEAST_BYTES:
            raise InputError(
                f"--memory {text} is too little to read recordings; give 256MB or more"
            )
        return cls(size)

    @contextmanager
    def database(self) -> Iterator[duckdb.DuckDBPyConnection]:
        """Give a database in memory that keeps to the limit, and puts on the disk what is more.

        It works on one thread: its sums come out one way, and processes share the cores.
        """
        limit_mb = (self.limit_bytes - _FOR_PYTHON_BYTES) // 10**6
        with tempfile.TemporaryDirectory(prefix="vrcomfort-") as folder:
            settings: dict[str, str | bool | int | float | list[str]] = {
                "memory_limit": f"{limit_mb}MB",
                "threads": 1,
                "temp_directory": folder,
                "preserve_insertion_order": True,
                "autoinstall_known_extensions": False,
                "autoload_known_extensions": False,
            }
            connection = duckdb.connect(config=settings)
            try:
                connection.execute("SET enable_progress_bar = false")
                yield connection
            finally:
                connection.close()


def quoted(text: str | Path) -> str:
    """Return a text as SQL writes it.

    Raises
    ------
    InputError
        If it has bytes that are no UTF-8, as names of files can; the database takes none.
    """
    if escape_unprintable(str(text)) != str(text):
        message = "its name has characters that the database does not take; rename it, or a folder"
        raise InputError(f"{message} above it", file=escape_unprintable(str(text)))
    return "'" + str(text).replace("'", "''") + "'"


def column(name: str) -> str:
    """Return the name of a column as SQL writes it."""
    return '"' + name.replace('"', '""') + '"'
