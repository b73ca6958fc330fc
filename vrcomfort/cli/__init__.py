"""Commands; the only place where the parts are wired together."""

from __future__ import annotations

import io
import sys
from contextlib import suppress

from vrcomfort.cli import stopping

__all__ = ["main"]


def main() -> None:
    """Run the command line; Ctrl-C while it is still being imported ends it without a word."""
    _take_any_text()
    with stopping.heard():
        with stopping.at_once():
            from vrcomfort.cli import app
        app.main()


def _take_any_text() -> None:
    r"""Let no text that is typed or printed end the program, whatever a terminal's encoding is.

    What it does not have is written ``\xfc`` or ``\ufffd``.
    """
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            with suppress(io.UnsupportedOperation):  # read from before: this is not its program
                stream.reconfigure(errors="backslashreplace")
