"""Copies of a whole study with one file changed: `verify` names that file, and no other."""

from __future__ import annotations

import shutil
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from torture import resumed, steps
from torture.case import OTHER, Result, Rig
from torture.commands import in_child
from torture.damaged import command
from torture.mutate import Rng, in_bytes, pick, worse
from torture.steps import Fate
from torture.worker import named, workers
from vrcomfort.exchange.verifying import verify_study

REFERENCE = "whole"
CASE_S = 120.0


def torture(rig: Rig) -> Result:
    """Change a file in each of many copies, and verify them."""
    folder = rig.place("tampered")
    make(folder / REFERENCE)
    count = rig.count(200, 12)
    limits: dict[str, Any] = {"name": "case {}".format, "gigabytes": 0, "case_s": CASE_S}
    with workers("torture.tampered", folder, **limits) as pool:
        outcomes = list(rig.all("tampered", count, pool.run, limit_s=rig.count(300, 30)))
    how = (
        "Copies of a whole study (three people, one of them with a session that was interrupted "
        "twice), in each of which one file was changed in a cell, a value, a row, some bytes, or "
        "removed: `verify` names it, as a fault or (where labs may edit it) in a note, and no "
        "other file."
    )
    return Result("tampered", outcomes, how, count)


def make(folder: Path) -> None:
    """Make the whole study."""
    folder.mkdir(parents=True)
    study = folder / "study"
    steps_taken = resumed.length(folder, "SIGINT")
    for share in (0.3, 0.6):
        fate = Fate("SIGINT", int(share * steps_taken))
        begun = resumed.manifest_of(study).exists()
        steps.run(partial(resumed.work, study, resume=begun), fate, folder)
    resumed.work(study, resume=True)
    words = f"simulate {resumed.STUDY} -n 3 --no-draw --out study --quiet".split()
    ended, _ = in_child(folder, partial(command, words))
    if ended.code:
        raise RuntimeError(ended.said)
    ended, _ = in_child(folder, partial(command, ["pack", "study", "--quiet"]))
    if ended.code:
        raise RuntimeError(ended.said)
    shutil.rmtree(folder / "whole")


def case(folder: Path, _number: int, seed: int) -> dict[str, Any]:
    """Change a file of a copy, and verify it."""
    study, rng = folder / "study", np.random.default_rng(seed)
    shutil.rmtree(study, ignore_errors=True)
    shutil.copytree(folder.parent / REFERENCE / "study", study)
    before = told(study)
    file = pick(rng, sorted(each for each in study.rglob("*.*") if each.suffix in SUFFIXES))
    name = file.relative_to(study).as_posix()
    how = tamper(file, rng)
    with named(f"{name} {how}"):
        found = told(study) - before
    names = {each.partition(": ")[0].partition(", line")[0] for each in found}
    wrong = [f"{name} was not named"] * (name not in names)
    wrong += [each for each in sorted(found) if not each.startswith(name)]
    fault = OTHER if wrong else ""
    return {"name": f"{name} {how}", "fault": fault, "detail": "; ".join(wrong[:3])}


SUFFIXES = {".csv", ".json", ".sha256", ".parquet"}


def told(study: Path) -> set[str]:
    """Return what `verify` says of a study."""
    return {str(each) for each in verify_study(study).findings}


def tamper(file: Path, rng: Rng) -> str:
    """Change a file; return how."""
    content = changed = file.read_bytes()
    if rng.random() < 0.1 and file.suffix != ".parquet":  # which may be removed
        file.unlink()
        return "was removed"
    while changed == content:
        in_text = file.suffix in {".csv", ".json"} and rng.random() < 0.8
        changed = worse(content, file.suffix, rng) if in_text else in_bytes(content, rng)
    file.write_bytes(changed)
    return f"was changed ({len(content)} to {len(changed)} bytes)"
