"""Signals at random moments of a session: what was recorded stays, and `--resume` completes it."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import numpy as np

from torture.case import Outcome, Result, Rig
from torture.rows import never_asked, resume_codes
from torture.session import LENGTH_S, Findings, Victim, run_words

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)
START_S, END_S = 180.0, 180.0
HEARD = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
"""Exit codes by which a program says that it heard a signal."""


def torture(rig: Rig) -> Result:
    """Interrupt sessions, one signal after the other."""
    folder = rig.place("signals")

    def case(number: int, seed: int) -> Outcome:
        return _case(folder / str(number), SIGNALS[number % len(SIGNALS)], seed)

    count, limit_s = rig.count(32, 4), rig.count(420, 80)
    outcomes = list(rig.all("signals", count, case, limit_s=limit_s))
    words = ", ".join(number.name for number in SIGNALS)
    how = (
        f"{words} in turn, at random moments of a session of {LENGTH_S:g} s; then `--resume` to "
        "the end. Rows count that were handed over more than 0.2 s before a kill, and all where "
        "the session closed its files itself."
    )
    return Result("signals", outcomes, how, count)


def _case(folder: Path, number: signal.Signals, seed: int) -> Outcome:
    folder.mkdir(parents=True)
    study, found = folder / "study", Findings()
    moment_s = float(np.random.default_rng(seed).uniform(0.0, LENGTH_S))
    victim = Victim(run_words(study), folder / "first.txt")
    victim.wait_for(lambda: bool(victim.rows()), START_S)
    time.sleep(moment_s)
    state, cut_ns = victim.state(), victim.send(number)
    ended = victim.end(END_S)
    killed = ended.code is not None and ended.code < 0
    found.end("interrupted", ended, {0, -number, HEARD.get(number, 0)})
    rows = victim.must_be_there(cut_ns if killed else None)
    found.rows("after the signal", rows, study)
    if ended.code != 0:
        codes = resume_codes(study)
        again = Victim(run_words(study, "--resume"), folder / "second.txt", slow=False)
        found.end("--resume", again.end(END_S), codes)
        found.rows("after --resume", rows + again.must_be_there(None), study)
    found.never_asked = never_asked(study)
    return found.outcome(
        name=f"{number.name} in {state}, at {moment_s:.2f} s", seed=seed, folder=folder
    )
