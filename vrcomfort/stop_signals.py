"""The signals that stop a program, and what they wait for: that which is written together."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
"""Ctrl-C, a shutdown, a closed terminal; Windows has no SIGHUP."""


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold back the first signal that would stop the program until the block has ended.

    A second one is heard at once, so that nobody is kept waiting by a disk that hangs. In another
    thread than the main one, which hears no signals, the block simply runs.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    found = {number: signal.getsignal(number) for number in SIGNALS}
    handlers = {number: handler for number, handler in found.items() if callable(handler)}
    held: list[tuple[int, FrameType | None]] = []

    def release() -> None:
        for number, handler in handlers.items():
            signal.signal(number, handler)

    def hold(number: int, frame: FrameType | None) -> None:
        if not held:
            held.append((number, frame))
            return
        held.clear()
        release()
        handlers[number](number, frame)

    for number in handlers:
        signal.signal(number, hold)
    try:
        yield
    finally:
        release()
        for number, frame in held:
            handlers[number](number, frame)
