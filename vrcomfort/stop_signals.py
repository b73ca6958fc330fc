"""Signals that stop a program, held back during writes that belong together."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from types import FrameType
from typing import ParamSpec, TypeVar

SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    if hasattr(signal, name)
)
"""Ctrl-C, a shutdown, a closed terminal: on Windows SIGBREAK, which Ctrl-Break sends, too."""

TOGETHER_S = 1.0
"""SIGTERM and SIGHUP that come so close together are those of one shutdown: one wish, and files are
closed meanwhile."""

_AGAIN_S = 0.05
"""After so long a dropped signal is sent again, when Python has left what dropped it."""
_AT_ONCE = 3
"""The signal that is heard wherever it comes: nobody is kept waiting by a disk that hangs."""

Item = TypeVar("Item")
P = ParamSpec("P")


class _Signals:
    """Passes signals on to the handlers that they had, when it is their time."""

    def __init__(self) -> None:
        self.depth = 1
        """Of blocks that no signal interrupts."""
        self._count = 0
        self._number: int = signal.SIGINT
        self._last_s = -TOGETHER_S
        self._waiting: Callable[[], object] | None = None
        found = {number: signal.getsignal(number) for number in SIGNALS}
        self._handlers = {number: each for number, each in found.items() if callable(each)}

    def listen(self) -> None:
        """Hear the signals in place of their handlers."""
        for number in self._handlers:
            signal.signal(number, self._hear)

    def close(self) -> None:
        """Give the signals back to their handlers."""
        self.depth = 1  # or a signal in this loop would leave it in the middle
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self.depth = 0
        self.raise_waiting()

    def __enter__(self) -> None:
        """Begin a block that no signal interrupts."""
        self.depth += 1

    def __exit__(self, *_: object) -> None:
        self.depth -= 1
        if not self.depth:
            self.raise_waiting()

    def forget(self) -> int:
        """Take the next signal for the first; return the last one."""
        self._count = 0
        return self._number

    def raise_waiting(self) -> None:
        """Hear the signal that came in a block."""
        heard, self._waiting = self._waiting, None
        if heard is not None:
            heard()

    def _hear(self, number: int, frame: FrameType | None) -> None:
        now_s = time.monotonic()
        if number != signal.SIGINT and now_s - self._last_s < TOGETHER_S:
            return
        self._number, self._last_s = number, now_s
        self._count += 1
        if self._count == 1 and self.depth:
            self._waiting = lambda: self._handlers[number](number, frame)
        elif self._count == 1 or self._count >= _AT_ONCE:
            self._waiting = None
            self._handlers[number](number, frame)


_signals: _Signals | None = None
"""Of this process, whose main thread alone hears signals."""


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold back the first signal that would stop the program until the block has ended.

    A second one changes nothing: what it wants is under way. A third is heard at once. So it is in
    the outermost block also after the first was heard, by `listening`. In another thread than the
    main one, which hears no signals, the block simply runs.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
    elif _signals is None:
        with _hearing():
            yield
    else:
        with _signals:
            yield


def uninterrupted_call(method: Callable[P, Item]) -> Callable[P, Item]:
    """Return a function that is an `uninterrupted` block: within one, in a fifth of the time."""

    @wraps(method)
    def call(*arguments: P.args, **options: P.kwargs) -> Item:
        if _signals is not None and threading.get_ident() == threading.main_thread().ident:
            with _signals:
                return method(*arguments, **options)
        with uninterrupted():
            return method(*arguments, **options)

    return call


@contextmanager
def _hearing() -> Iterator[None]:
    global _signals  # noqa: PLW0603 - a process is told of signals, and nothing smaller
    ours = _Signals()
    try:
        _signals = ours
        ours.listen()
        with none_dropped(ours.forget):
            yield
    finally:
        _signals = None
        ours.close()


@contextmanager
def none_dropped(last: Callable[[], int]) -> Iterator[None]:
    """Send the last signal again where Python has dropped its `KeyboardInterrupt`.

    It drops what is raised in `__del__` and in callbacks from C, and such an end would never come.
    """

    def hear(dropped: sys.UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            others(dropped)
            return
        _thread.start_new_thread(_send_again, (last(),))  # unlike `Thread`, waits for nothing

    others, sys.unraisablehook = sys.unraisablehook, hear
    try:
        yield
    finally:
        sys.unraisablehook = others


def _send_again(number: int) -> None:
    time.sleep(_AGAIN_S if number == signal.SIGINT else TOGETHER_S)
    if sys.platform == "win32":
        signal.raise_signal(number)
    else:  # also out of a call that waits
        signal.pthread_kill(threading.main_thread().ident or 0, number)


@contextmanager
def listening() -> Iterator[None]:
    """Hear the first signal at once, also in an `uninterrupted` block, or that which it held."""
    held = _signals if threading.current_thread() is threading.main_thread() else None
    if held is None:
        yield
        return
    depth, held.depth = held.depth, 0
    try:
        held.raise_waiting()
        yield
    finally:
        held.depth = depth


def interruptible(items: Iterable[Item]) -> Iterator[Item]:
    """Yield items; signals are heard while one is waited for."""
    iterator = iter(items)
    while True:
        with listening():
            try:
                item = next(iterator)
            except StopIteration:
                return
        yield item
