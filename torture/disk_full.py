"""Disks of many sizes that fill up: one sentence, and everything up to there can be read."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import numpy as np

from torture.case import OTHER, Outcome, Result, Rig
from torture.disk import mount_memory, unmount
from torture.rows import Rows, missing, never_asked, session_folder
from torture.session import Findings, Victim, run_words
from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError

END_S = 180.0
SMALLEST_BYTES, LARGEST_BYTES = 4096, 150_000
"""The largest is about what a whole session takes."""


def torture(rig: Rig) -> Result:
    """Fill disks up."""
    folder = rig.place("disk_full")
    memory = _can_mount_memory(folder)
    count = rig.count(20, 3)
    sizes = np.geomspace(SMALLEST_BYTES, LARGEST_BYTES, count).astype(int).tolist()

    def case(number: int, seed: int) -> Outcome:
        return _case(folder / str(number), sizes[number], seed, memory=memory)

    outcomes = list(rig.all("disk_full", count, case, limit_s=rig.count(300, 60)))
    disk = "disks (tmpfs)" if memory else "limits of a file's size (no disk can be mounted here)"
    how = (
        f"{len(outcomes)} {disk} from {SMALLEST_BYTES} to {LARGEST_BYTES} bytes. Rows count that "
        "the recorder took before the first that it refused; then the folder is moved to a disk "
        "with room, and `--resume` runs to the end."
    )
    return Result("disk_full", outcomes, how, count)


def _case(folder: Path, size_bytes: int, seed: int, *, memory: bool) -> Outcome:
    folder.mkdir(parents=True)
    disk, found = folder / "disk", Findings()
    if memory:
        mount_memory(disk, size_bytes)
    else:
        disk.mkdir()
    try:
        victim = Victim(run_words(disk / "study"), folder / "first.txt", slow=False)
        if not memory:
            limits = (size_bytes, size_bytes)
            resource.prlimit(victim.process.pid, resource.RLIMIT_FSIZE, limits)
        ended = victim.end(END_S)
        found.end("on the full disk", ended, {0, 2})
        shutil.copytree(disk, folder / "room")
    finally:
        if memory:
            unmount(disk)
    study = folder / "room" / "study"
    _read_all(study, found)
    if ended.code:
        _judge(study, victim, folder, found)
    else:  # there was room for everything
        found.rows("on the disk", victim.must_be_there(None), study)
        found.never_asked = never_asked(study)
    return found.outcome(name=f"{size_bytes} bytes", seed=seed, folder=folder)


def _judge(study: Path, victim: Victim, folder: Path, found: Findings) -> None:
    lost = missing(victim.must_be_there(None), study)
    rows = _before(victim, lost)
    found.rows("on the full disk", rows, study)
    begun = (session_folder(study) / "manifest.json").exists()
    words = run_words(study, *(["--resume"] if begun else []))
    again = Victim(words, folder / "second.txt", slow=False)
    found.end("--resume on a disk with room", again.end(END_S), {0} if begun else {0, 2})
    found.rows("after --resume", rows, study)


def _before(victim: Victim, lost: Rows) -> Rows:
    """Return the rows that come before the last of their file that is there: none may be a gap."""
    rows: Rows = Counter()
    for file in {told.file for told in victim.rows()}:
        keys = [(told.file, told.cells) for told in victim.rows(file)]
        there = [number for number, key in enumerate(keys) if key not in lost]
        rows.update(keys[: there[-1] + 1] if there else [])
    return rows


def _read_all(study: Path, found: Findings) -> None:
    """Read every table as the product reads them."""
    for file in sorted(study.rglob("*.csv")) if study.exists() else []:
        try:
            CsvTable.read(file, appended=True)
        except InputError as error:
            found.fault = found.fault or OTHER
            found.details.append(f"cannot be read: {error}")


def _can_mount_memory(folder: Path) -> bool:
    if os.geteuid():
        return False
    try:
        mount_memory(folder / "probe", 1 << 16)
    except (OSError, subprocess.CalledProcessError):
        return False
    unmount(folder / "probe")
    return True
