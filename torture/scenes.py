"""Scene files made to take all memory or time, or what is not theirs."""

from __future__ import annotations

import resource
import shutil
import time
from pathlib import Path
from typing import Any

from torture.case import OTHER, Result, Rig
from torture.small_scene import HOSTILE, REFUSED
from torture.worker import named, workers
from vrcomfort.errors import InputError
from vrcomfort.scene.load import load_scene

GIGABYTES, CASE_S = 3, 180.0
NAMES = (*REFUSED, *HOSTILE)


def torture(rig: Rig) -> Result:
    """Load them, each in a process of its own."""
    count = rig.count(len(NAMES), len(REFUSED) + 4)
    limits: dict[str, Any] = {
        "name": NAMES.__getitem__,
        "gigabytes": GIGABYTES,
        "case_s": CASE_S,
        "renewed": 1,
    }
    with workers("torture.scenes", rig.place("scenes"), **limits) as pool:
        outcomes = list(rig.all("scenes", count, pool.run, limit_s=rig.count(240, 40)))
    how = (
        f"Each in a process of its own with {GIGABYTES} GiB of address space and {CASE_S:g} s: "
        f"loads or is refused in one sentence. Must be refused: {', '.join(REFUSED)}. Either: "
        f"{', '.join(NAMES[len(REFUSED) : count])}."
    )
    return Result("scenes", outcomes, how, count)


def case(folder: Path, number: int, seed: int) -> dict[str, Any]:
    """Make a scene file and load it."""
    del seed  # there is one of each
    place = folder / "scene"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    name = NAMES[number]
    path = {**REFUSED, **HOSTILE}[name](place)
    began_s = time.monotonic()
    fault, became = "", "loaded"
    try:
        with named(name):
            load_scene(path)
    except InputError as error:
        became = f"refused: {error.message}"
    took_s, peak_mb = time.monotonic() - began_s, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if name in REFUSED and became == "loaded":
        fault = OTHER
    return {
        "name": name,
        "fault": fault,
        "detail": f"{became}; {took_s:.1f} s, {peak_mb / 1024:.0f} MB at most",
    }
