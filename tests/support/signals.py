"""Signals in the children of tests, whatever the shell that runs the tests ignores."""

from __future__ import annotations

import signal

SIGNALS = (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM))


def hear_all() -> None:
    """Undo in a child that a shell ignores signals: Ctrl-C in the background, SIGHUP by nohup."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
