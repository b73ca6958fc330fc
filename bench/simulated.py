"""Cost of simulated participants where nothing is drawn."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from bench.table import Result

PROTOCOLS = ("carnegie_2015", "motion_blur_2020")
LIMIT_S = 20.0
_MAIN = "from vrcomfort.cli import main; main()"


def measure(participants: int = 200) -> Result:
    """Take participants through whole protocols, each in a process, and count its CPU time.

    Parameters
    ----------
    participants
        Of each protocol.
    """
    rows = [_row(protocol, participants) for protocol in PROTOCOLS]
    notes = [
        "CPU time of the whole process, its threads and its start included.",
        f"The goal is {LIMIT_S:g} s for 200 participants.",
    ]
    return Result(f"{participants} simulated participants without frames", rows, notes)


def _row(protocol: str, participants: int) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "study"
        given = ["-n", str(participants), "--no-draw", "--out", str(out), "--quiet"]
        before = os.times()
        subprocess.run([sys.executable, "-c", _MAIN, "simulate", protocol, *given], check=True)
        after = os.times()
        cpu_s = after.children_user - before.children_user
        cpu_s += after.children_system - before.children_system
        trials = sum(_rows(file) for file in out.rglob("trials.csv"))
        answers = sum(_rows(file) for file in out.rglob("questionnaires.csv"))
    return {"protocol": protocol, "cpu_s": cpu_s, "exposures": trials, "answers": answers}


def _rows(file: Path) -> int:
    return len(file.read_text(encoding="utf-8").splitlines()) - 1


if __name__ == "__main__":
    from bench.table import write

    write(Path("out/bench"), "simulated", measure())
