"""Commands; the only place where the parts are wired together."""

from __future__ import annotations

import os
import signal
from types import FrameType

__all__ = ["main"]

EXIT_INTERRUPTED = 130


def main() -> None:
    """Run the command line; Ctrl-C while it is still being imported ends it without a word."""
    heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heard:  # and not ignored, as in the background
        signal.signal(signal.SIGINT, _leave)
    from vrcomfort.cli import app

    if heard:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    app.main()


def _leave(_: int, __: FrameType | None) -> None:
    """End at once: an exception in the middle of an import may be swallowed, or told as another."""
    os._exit(EXIT_INTERRUPTED)
