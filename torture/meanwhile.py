"""Sessions that are read while they are recorded: `verify`, `status` and `report` find no fault."""

from __future__ import annotations

import os
import shutil
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from torture import commands, resumed
from torture.case import OTHER, TRACEBACK, Result, Rig
from torture.damaged import command
from torture.session import Ended
from torture.worker import named, workers
from vrcomfort.exchange.status import status_of
from vrcomfort.exchange.verifying import verify_study

CASE_S = 180.0
READING_S = 90


def torture(rig: Rig) -> Result:
    """Read studies while a session writes into them."""
    count = rig.count(40, 3)
    limits: dict[str, Any] = {"name": "case {}".format, "gigabytes": 0, "case_s": CASE_S}
    with workers("torture.meanwhile", rig.place("meanwhile"), **limits) as pool:
        outcomes = list(rig.all("meanwhile", count, pool.run, limit_s=rig.count(300, 45)))
    looks = sum(int(each.name.partition(" ")[0]) for each in outcomes if each.name[:1].isdigit())
    how = (
        f"`verify` and `status` {looks} times while sessions without pictures were recorded, as "
        "fast as the machine can, in another process: no fault, no damage; and at some moment "
        "`report`, which ends with 0, or with 2 and a sentence."
    )
    return Result("meanwhile", outcomes, how, count)


def case(folder: Path, _number: int, seed: int) -> dict[str, Any]:
    """Record a session, and read it meanwhile."""
    commands.import_all()
    place = folder / "case"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    study = place / "study"
    resumed.room(resumed.protocol().scene_source("room.gltf"))
    recording = _recording(study)
    with named("reading"):
        looks, wrong = _read(study, recording, int(np.random.default_rng(seed).integers(1, 60)))
    wrong += [str(each) for each in verify_study(study).faults]
    fault = TRACEBACK if any("Traceback" in each for each in wrong) else OTHER if wrong else ""
    return {"name": f"{looks} looks", "fault": fault, "detail": "; ".join(wrong[:3])[-900:]}


def _recording(study: Path) -> Callable[[], bool]:
    """Record a session in a child; return the function that tells whether it is still running."""
    child = os.fork()
    if not child:
        try:
            resumed.work(study, resume=False)
        finally:
            os._exit(0)
    return lambda: os.waitpid(child, os.WNOHANG)[0] == 0


def _read(study: Path, running: Callable[[], bool], report_at: int) -> tuple[int, list[str]]:
    """Read a study while it is recorded; return how often, and what was wrong."""
    looks, wrong = 0, set[str]()
    while running():
        if not (study / "dataset_description.json").exists():
            continue
        looks += 1
        try:
            wrong |= {str(each) for each in verify_study(study).faults}
            wrong |= {each.fault for who in status_of(study).people for each in who.sessions}
        except Exception:  # of any kind: it is what this looks for
            wrong.add(traceback.format_exc())
        if looks == report_at:
            words = ["report", "study", "--figures", "none", "--out", "report", "--quiet"]
            ended, _ = commands.in_child(study.parent, partial(command, words))
            wrong.add(_fault(ended))
    return looks, sorted(wrong - {""})


def _fault(ended: Ended) -> str:
    return " ".join(ended.fault({0, 2}))[-600:].strip()
