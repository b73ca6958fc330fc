"""Power cuts at random moments: what was handed over is on the disk, and the session goes on."""

from __future__ import annotations

import shutil
import signal
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from torture.case import Outcome, Result, Rig
from torture.disk import Disk, LoopImage, ShimDisk, can_mount
from torture.rows import never_asked, resume_codes
from torture.session import LENGTH_S, QUICK_S, SLOW_S, Ended, Findings, Victim, run_words

START_S, END_S = 180.0, 180.0
AFTER_END_S = 0.3
"""Each fifth cut comes so long after the session has ended: then everything must be there."""


def torture(rig: Rig) -> Result:
    """Cut off the power of sessions."""
    folder = rig.place("power_cut")
    loop = can_mount(folder)

    def case(number: int, seed: int) -> Outcome:
        make = LoopImage if loop else ShimDisk
        return _case(folder / str(number), make, seed, after_end=number % 5 == 4)

    count, limit_s = rig.count(15, 2), rig.count(420, 80)
    outcomes = list(rig.all("power_cut", count, case, limit_s=limit_s))
    disk = (
        "an ext4 image, copied while the session stood still, its journal replayed"
        if loop
        else "no image can be mounted here: a shim that forgets what was not synced"
    )
    how = (
        f"{disk}. Rows count that were handed over more than {QUICK_S:g} s before the cut "
        f"({SLOW_S:g} s for frames, gaze and timing); then `--resume` to the end and `report`. "
        f"Each fifth cut comes {AFTER_END_S:g} s after the session ended."
    )
    return Result("power_cut", outcomes, how, count)


def _case(folder: Path, make: Callable[[Path], Disk], seed: int, *, after_end: bool) -> Outcome:
    folder.mkdir(parents=True)
    disk = make(folder)
    moment_s = float(np.random.default_rng(seed).uniform(0.5, LENGTH_S))
    try:
        victim = Victim(run_words(disk.study), folder / "first.txt", options=disk.options)
        victim.wait_for(lambda: bool(victim.rows()), START_S)
        if after_end:
            victim.wait_for(lambda: False, END_S)
            moment_s = AFTER_END_S
        time.sleep(moment_s)
        state = "after the end" if after_end else f"in {victim.state()}"
        name = f"cut at {moment_s:.2f} s, {state}"
        return _judge(folder, disk, victim, partial(Findings.outcome, name=name, seed=seed))
    finally:
        disk.close()
        shutil.rmtree(folder / "disk", ignore_errors=True)


def _judge(folder: Path, disk: Disk, victim: Victim, finish: Callable[..., Outcome]) -> Outcome:
    found = Findings()
    over = victim.process.poll() is not None
    cut_ns = victim.send(signal.SIGSTOP)
    disk.cut()
    ended = victim.end(0.0 if not over else END_S)
    if over:
        found.end("the session", ended, {0})
    rows = victim.must_be_there(cut_ns, slow_s=QUICK_S if over else SLOW_S)
    study = disk.remains()
    found.rows("after the cut", rows, study)
    if not over:
        codes = resume_codes(study) if rows else {0, 2}  # as good as before the first row
        again = Victim(run_words(study, "--resume"), folder / "second.txt", slow=False)
        found.end("--resume", again.end(END_S), codes)
        found.rows("after --resume", rows + again.must_be_there(None), study)
    found.never_asked = never_asked(study)
    found.end("report", report(study, folder), {0})
    return finish(found, folder=folder)


def report(study: Path, folder: Path) -> Ended:
    """Make a report of what is left."""
    words = ["report", str(study), "--out", str(folder / "report"), "--quiet"]
    return Victim(words, folder / "report.txt", slow=False).end(END_S)
