"""Sessions that are interrupted twice and go on: no row is lost, nothing is called damaged."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections import Counter
from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from torture import steps, victim
from torture.case import OTHER, Result, Rig
from torture.rows import Rows, by_file, missing, whole_rows
from torture.steps import Fate
from torture.worker import named, workers
from vrcomfort.exchange.bids import export_bids
from vrcomfort.exchange.psych_ds import export_psych_ds
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol import Protocol, load_protocol
from vrcomfort.records.interruptions import KEPT, SAFE_AT_ONCE_S
from vrcomfort.respondent import Form, Heard, SimulatedRespondent
from vrcomfort.scene.load import load_scene
from vrcomfort.session import (
    NoPictures,
    SessionSettings,
    StillHeadset,
    VirtualClock,
    open_enrolment,
)
from vrcomfort.session import run as run_session

STUDY = Path(__file__).with_name("resumed.toml")
WHO = "P01"
FATES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGINT twice", "SIGKILL", "power cut", "full disk")
SMALLEST_BYTES = 4096
"""Of the full disk; the largest takes the whole session."""
RATE_HZ = 72.0
TOLD = "told.txt"
SYNCED_LATER = {each.row_type.FILE for each in KEPT if each.safe_after_s > SAFE_AT_ONCE_S}
CASE_S = 120.0


def torture(rig: Rig) -> Result:
    """Interrupt sessions in every way, and verify what they are when they have gone on."""
    folder = rig.place("resumed")
    count, limit_s = rig.count(200, 7), rig.count(900, 60)
    with workers("torture.resumed", folder, name=_fate, gigabytes=0, case_s=CASE_S) as found:
        outcomes = list(rig.all("resumed", count, found.run, limit_s=limit_s))
    how = (
        f"{', '.join(FATES)} in turn, at a random line of the code that records a session without "
        "pictures (tasks, sliders, a dial, gaze, practice, corrected answers); the session that "
        "goes on is interrupted again. Rows count that a file had after an interruption, that the "
        "recorder had taken before a signal, or that the session had waited for (before a power "
        "cut, but for files that are synced later). When it is over, `verify` finds nothing, and "
        "both exports are written."
    )
    return Result("resumed", outcomes, how, count)


def case(folder: Path, number: int, seed: int) -> dict[str, Any]:
    """Judge one case, for a worker."""
    with named(_fate(number)):
        found = judge(folder, seed, _fate(number))
    return {
        "name": found.name,
        "handed": found.handed,
        "lost": found.lost,
        "fault": OTHER if found.faults else "",
        "detail": "; ".join(found.faults[:3]),
    }


def manifest_of(study: Path) -> Path:
    """Return the file of the session's manifest."""
    return study / f"sub-{WHO}" / "ses-1" / "manifest.json"


def _fate(number: int) -> str:
    return FATES[number % len(FATES)]


class Corrects(SimulatedRespondent):
    """Takes every fourth answer back."""

    def ask(self, form: Form, heard: Heard) -> None:
        """Answer, and every fourth item once more."""
        given = iter(range(10**9))

        def twice(item: str, response: int | None, took_s: float) -> None:
            heard(item, response, took_s)
            if next(given) % 4 == 3:
                heard(item, response or 1, took_s)

        super().ask(form, twice)


def work(study: Path, *, resume: bool, told: Path | None = None) -> None:
    """Run the session, or what is left of it.

    Parameters
    ----------
    told
        A file to tell each row in that the recorder takes; in a child of this process alone.
    """
    if told is not None:
        victim.observe(victim.Observer(os.open(told, os.O_CREAT | os.O_WRONLY | os.O_APPEND)), 0.0)
    known = protocol()
    respondent = Corrects(known.simulation, participant=WHO, seed=0)
    with open_enrolment(
        known, WHO, study=study, respondent=respondent.name, resume=resume
    ) as enrolment:
        settings = SessionSettings(
            respondent=respondent,
            headset_for=lambda *_: StillHeadset(RATE_HZ),
            load_scene=room,
            renderer=NoPictures(),
            clock=VirtualClock(),
        )
        outcome = run_session(enrolment, settings)
    if outcome.status == "aborted":
        raise KeyboardInterrupt


@cache
def protocol() -> Protocol:
    """Return the study's protocol, read once for all children."""
    return load_protocol(STUDY)


room = cache(load_scene)


@cache
def length(folder: Path, name: str) -> int:
    """Return how many steps, or bytes, a session takes that meets its fate too late."""
    study = folder / "whole" / "study"
    shutil.rmtree(study.parent, ignore_errors=True)
    study.parent.mkdir(parents=True)
    room(protocol().scene_source("room.gltf"))
    never = Fate(name, sys.maxsize)
    code, count = steps.run(partial(work, study, resume=False), never, study.parent)
    if code:
        raise RuntimeError((study.parent / "fell.txt").read_text())
    size_bytes = sum(each.stat().st_size for each in study.rglob("*.csv"))
    return size_bytes if name == "full disk" else count


class Judged(NamedTuple):
    """What was done to a session, and what is wrong now; see `torture.case.Outcome`."""

    name: str
    faults: list[str]
    handed: int = 0
    lost: int = 0


def judge(folder: Path, seed: int, first: str) -> Judged:
    """Interrupt a session twice, at first by `first`, and let it go on to its end."""
    random = np.random.default_rng(seed)
    fates = [first, str(random.choice(FATES)), "none"]
    case = folder / str(seed)
    study = case / "study"
    shutil.rmtree(case, ignore_errors=True)
    case.mkdir(parents=True)
    names = []
    rows: Rows = Counter()
    for name in fates:
        fate = _meet(folder, name, random)
        before = {each.stat().st_ino: each.stat().st_size for each in study.rglob("*.csv")}
        resume = manifest_of(study).exists()
        (case / TOLD).unlink(missing_ok=True)
        code, _ = steps.run(partial(work, study, resume=resume, told=case / TOLD), fate, case)
        names.append("to the end" if name == "none" else f"{name} at {fate.step}")
        if code == steps.FELL:
            return Judged(", ".join(names), [(case / "fell.txt").read_text()[-600:]])
        if code == steps.HUNG:
            return Judged(", ".join(names), [f"still running after {steps.LIMIT_S} s"])
        if name == "power cut" and code < 0:
            cut(case, before, random)
        if name != "full disk":  # whose refusals are another torture
            rows = _taken(rows, case / TOLD, all_of_them=code >= 0, cut=name == "power cut")
        rows |= whole_rows(study)
        if not code:
            break
    lost = missing(rows, study)
    faults = _not_over(study, case) or called_damaged(study, case)
    if lost:
        faults.append(f"lost {by_file(lost)}")
    if not faults:
        shutil.rmtree(case)
    return Judged(", ".join(names), faults, rows.total(), lost.total())


def _taken(rows: Rows, told: Path, *, all_of_them: bool, cut: bool) -> Rows:
    """Return the rows that must be there after a run.

    Parameters
    ----------
    rows
        Those that had to be there before it.
    told
        What the recorder has taken in the run.
    all_of_them
        The session closed its files; else those that it waited for.
    cut
        The disk lost its power: rows that are synced later are not among them.
    """
    found = Counter(rows)
    for line in told.read_text().splitlines() if told.exists() else ():
        word = json.loads(line)
        key = word["file"], tuple(word["cells"].items())
        if word["kind"] == "gone":
            found[key] -= 1
        elif all_of_them or (word["waited"] and not (cut and word["file"] in SYNCED_LATER)):
            found[key] += 1
    return +found


def _not_over(study: Path, case: Path) -> list[str]:
    """Return what a session said that cannot go on."""
    if json.loads(manifest_of(study).read_text())["status"] == "completed":
        return []
    said = case / "said.txt"
    return [f"is not over; said: {said.read_text() if said.exists() else 'nothing'}"]


def _meet(folder: Path, name: str, random: np.random.Generator) -> Fate:
    if name == "none":
        return Fate(name)
    low, alike = (SMALLEST_BYTES, name) if name == "full disk" else (1, "SIGINT")
    longest = length(folder, "SIGKILL" if name in steps.NOT_HEARD else alike)
    return Fate(name, int(random.integers(low, longest)), random.uniform(0.0, 0.02))


def cut(case: Path, before: Mapping[int, int], random: np.random.Generator) -> None:
    """Take from each table some of what was not synced; a file system may leave zeros instead."""
    synced = json.loads((case / steps.SYNCED).read_text())
    for file in sorted((case / "study").rglob("*.csv")):
        found = file.stat()
        known = synced.get(str(found.st_ino), before.get(found.st_ino, 0))
        safe = min(known, found.st_size)
        kept = int(random.choice([safe, found.st_size, random.integers(safe, found.st_size + 1)]))
        content = file.read_bytes()[:kept]
        zeros = found.st_size - kept if random.random() < 0.3 else 0
        file.write_bytes(content + bytes(zeros))


def called_damaged(study: Path, case: Path) -> list[str]:
    """Return what `verify` and the exports hold against a session that is whole."""
    faults = [str(each) for each in verify_study(study).faults]
    if faults:
        return faults
    export_bids(study, case / "bids")
    export_psych_ds(study, case / "psych_ds")
    return []
