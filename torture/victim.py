"""Runs the command line as it is, and tells an observer of each row that the recorder has taken.

The observer is at the other end of a pipe, so what it was told survives whatever ends this program.
Nothing in the product knows of this: its recorder's methods are wrapped here, in this process only.

    python -m torture.victim --tell 5 run smoke --participant P01 ...
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from torture import shim
from vrcomfort.cli import main as command_line
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.records import FrameRow, Recorder
from vrcomfort.records.rows import Row, cell_text
from vrcomfort.records.session_rows import QuestionnaireRow
from vrcomfort.session import VirtualClock

BEAT_S = 0.02


def main() -> None:
    """Read the observer's options, and run the command that follows them."""
    parser = argparse.ArgumentParser(prog="python -m torture.victim", description=__doc__)
    parser.add_argument("--tell", type=int, help="file descriptor of the pipe to the observer")
    parser.add_argument("--answer-s", type=float, default=0.0, help="real time of an answer")
    parser.add_argument("--pace", action="store_true", help="frames and rests take their time")
    parser.add_argument("--forget", action="store_true", help="lose every fifth rating or event")
    parser.add_argument("--shim", type=Path, nargs=2, metavar=("STUDY", "DISK"))
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args()
    # A shell that runs the observer in the background has these ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    if options.shim:
        shim.install(*options.shim)
    if options.forget:
        forget()
    if options.tell is not None:
        observer = Observer(options.tell)
        observe(observer, options.answer_s)
        observer.beat()
    if options.pace:
        pace()
    sys.argv = ["vrcomfort", *options.command]
    command_line()


class Observer:
    """Writes a line for each row into a pipe: when it was handed over, its file, its cells."""

    def __init__(self, pipe: int) -> None:
        self._pipe = os.fdopen(pipe, "wb", buffering=0, closefd=False)  # past a small disk
        self._lock = threading.Lock()

    def tell(self, kind: str, handed_ns: int, row: Row, *, waited: bool = False) -> None:
        """Tell of one row, and whether the session waited until it was written."""
        texts = map(cell_text, row.cells())
        cells = dict(zip(row.columns(), texts, strict=True))
        cells.pop("resumed", None)  # the recorder's own word
        word = {"kind": kind, "ns": handed_ns, "file": row.FILE, "cells": cells, "waited": waited}
        self._write(json.dumps(word))

    def beat(self) -> None:
        """Tell again and again, from a thread, that the machine lets this program run."""

        def tell() -> None:
            with suppress(OSError):  # nobody is there any more
                while True:
                    self._write(json.dumps({"kind": "beat", "ns": time.monotonic_ns()}))
                    time.sleep(BEAT_S)

        threading.Thread(target=tell, name="beat", daemon=True).start()

    def _write(self, line: str) -> None:
        with self._lock:
            self._pipe.write(line.encode() + b"\n")


def observe(observer: Observer, answer_s: float) -> None:
    """Tell of rows when the recorder has taken them: one that it refused is not handed over.

    A row that is replaced is told of before: from then on either of the two may be there.
    """
    inside = threading.local()

    def taking(
        method: Callable[..., None], *, replaces: bool = False, waits: bool = True
    ) -> Callable[..., None]:
        @functools.wraps(method)
        def take(recorder: Recorder, *rows: Row) -> None:
            if getattr(inside, "now", False):  # one of its methods calls another
                return method(recorder, *rows)
            inside.now, handed_ns = True, time.monotonic_ns()
            if replaces:
                observer.tell("gone", handed_ns, rows[0])
            try:
                method(recorder, *rows)
            finally:
                inside.now = False
            waited = waits and not all(isinstance(row, FrameRow) for row in rows)
            for row in rows[replaces:]:
                _tell(observer, handed_ns, row, waited=waited)
            if any(isinstance(row, QuestionnaireRow) for row in rows):
                time.sleep(answer_s)
            return None

        return take

    wrapped: Any = Recorder
    wrapped.write = taking(Recorder.write)
    wrapped.write_soon = taking(Recorder.write_soon, waits=False)
    wrapped.replace = taking(Recorder.replace, replaces=True)


def _tell(observer: Observer, handed_ns: int, row: Row, *, waited: bool) -> None:
    observer.tell("row", handed_ns, row, waited=waited)
    gaze = getattr(row, "gaze", None)
    if gaze is not None:  # the recorder writes it with the frame
        observer.tell("row", handed_ns, gaze, waited=waited)


def pace() -> None:
    """Let frames and rests of a simulated session take the time that they say."""
    begin: Any = PlaybackHeadset.__init__
    wait = VirtualClock.wait

    def begin_paced(headset: PlaybackHeadset, *arguments: Any, **options: Any) -> None:
        begin(headset, *arguments, **{**options, "real_time": True})

    def wait_really(clock: VirtualClock, duration_s: float) -> None:
        time.sleep(duration_s)
        wait(clock, duration_s)

    changed: Any = PlaybackHeadset
    changed.__init__ = begin_paced
    clock: Any = VirtualClock
    clock.wait = wait_really


def forget() -> None:
    """Be a recorder that loses rows: what a harness must notice."""
    take = Recorder.write_soon
    seen = iter(range(10**9))

    def lose(recorder: Recorder, *rows: Row) -> None:
        kept = [row for row in rows if row.FILE != "events.csv" or next(seen) % 5]
        take(recorder, *kept)

    changed: Any = Recorder
    changed.write_soon = lose


if __name__ == "__main__":
    main()
