"""A rehearsal of a session, in a Monado runtime of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING

from vrcomfort.cli.playback import open_trace
from vrcomfort.errors import InputError
from vrcomfort.settings import read_text

if TYPE_CHECKING:
    from vrcomfort.headset.watchdog import Watchdog
    from vrcomfort.session.rehearsal import Rehearsal


@contextmanager
def rehearse(
    trace: Path | None, answers: Path | None, watchdog: Watchdog | None = None
) -> Iterator[Rehearsal | None]:
    """Start a Monado runtime of our own where there is a trace; it is the active one meanwhile.

    Parameters
    ----------
    trace
        What its head follows: one sample per frame.
    answers
        What its controllers answer: whole numbers, in the order of the questions.
    watchdog
        Ends the runtime, too, where it must end the program.

    Raises
    ------
    InputError
        If a file cannot be used, or there is no Monado.
    """
    if trace is None:
        if answers is not None:
            raise InputError("--monado-answers needs --monado-trace, the trace of the head")
        yield None
        return
    from vrcomfort.headset.monado import Monado
    from vrcomfort.session.rehearsal import Rehearsal

    head_trace = open_trace(trace)
    script = _read_answers(answers) if answers else []
    with Monado() as monado, monado.feed() as feed:
        if watchdog is not None:
            watchdog.last_acts += [monado.kill, monado.stop]
        heads = map(head_trace.head.pose, cycle(range(len(head_trace))))
        yield Rehearsal(feed, heads, iter(script))


def _read_answers(path: Path) -> list[int]:
    numbers = []
    for line, words in enumerate(read_text(path, "script of answers").split("\n"), start=1):
        for word in words.partition("#")[0].split():
            if not word.isdecimal():
                raise InputError(f"an answer is a whole number, not {word!r}", file=path, line=line)
            numbers.append(int(word))
    return numbers
