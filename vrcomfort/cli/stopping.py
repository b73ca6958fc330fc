"""Signals that end a command: Ctrl-C, a shutdown (SIGTERM), a closed terminal (SIGHUP)."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from vrcomfort.stop_signals import SIGNALS, TOGETHER_S, none_dropped

_last: tuple[int, float] = signal.SIGINT, -TOGETHER_S
"""The signal that came last, and when."""


@contextmanager
def heard() -> Iterator[None]:
    """Raise `KeyboardInterrupt` in the main thread for each of `SIGNALS`.

    What was ignored from the start, as with nohup or in the background, stays ignored.
    """
    meant = [number for number in SIGNALS if _is_default(number)]
    before = {number: signal.signal(number, _interrupt) for number in meant}
    try:
        with none_dropped(lambda: _last[0]):
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def at_once() -> Iterator[None]:
    """End without a word while modules are imported.

    An exception in the middle of an import may be swallowed, or told as another.
    """
    meant = [number for number in SIGNALS if signal.getsignal(number) is _interrupt]
    for number in meant:
        signal.signal(number, _leave)
    yield
    for number in meant:
        signal.signal(number, _interrupt)


def exit_code() -> int:
    """Return the exit code of a program that a signal has ended: 130 after Ctrl-C."""
    return 128 + _last[0]


def terminal_closed() -> bool:
    """Return whether the terminal was closed (SIGHUP; on Windows SIGBREAK)."""
    closed = (getattr(signal, name, None) for name in ("SIGHUP", "SIGBREAK"))
    return _last[0] in closed


def _is_default(number: int) -> bool:
    return signal.getsignal(number) in {signal.SIG_DFL, signal.default_int_handler}


def _interrupt(number: int, _: FrameType | None) -> None:
    global _last  # noqa: PLW0603 - a process is told of signals, and nothing smaller
    since_s = time.monotonic() - _last[1]
    if number != signal.SIGINT and since_s < TOGETHER_S:
        return
    _last = number, time.monotonic()
    raise KeyboardInterrupt


def _leave(number: int, _: FrameType | None) -> None:
    os._exit(128 + number)
