"""Commands; the only place where the parts are wired together."""

from __future__ import annotations

import io
import sys
from contextlib import suppress

from vrcomfort.cli import stopping

__all__ = ["main"]


def main() -> None:
    """Run the command line; Ctrl-C while it is still being imported ends it without a word."""
    _escape_foreign_text()
    with stopping.heard():
        with stopping.at_once():
            from vrcomfort.cli import app
        app.main()


def _escape_foreign_text() -> None:
    r"""Read and print text that is not in the terminal's encoding as ``\xfc`` or ``\ufffd``."""
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            with suppress(io.UnsupportedOperation):  # it has been read from before
                stream.reconfigure(errors="backslashreplace")
