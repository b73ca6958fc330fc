"""Cost of a report of many answers: `python -m bench.many_answers [--people 1000]`.

Makes a study of 16 questionnaires for each participant (four conditions in two scenes, a baseline
before each; 256,000 answers of 1,000 people), reports it, and prints the processor time of each
part: for these people, and for a quarter and a sixteenth of them, each in a program of its own on
one thread. The slope is that of the logarithm of time over that of answers: 1 is linear.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from bench.apart import in_a_program
from bench.clocked import replaced
from bench.table import Result
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.report import build as report

CONDITIONS, SCENES = ("off", "weak", "middle", "strong"), ("near", "far")
SEED = 20150323
PARTS = {
    "reading": "read_study",
    "analysing": "analyse",
    "residuals": "residuals_of",
    "drawing": "draw_figures",
    "figure files": "_figure_files",
    "page": "render_page",
    "tables": "all_tables",
    "results": "results_json",
}
"""Part of a report → the function in `vrcomfort.report.build` that makes it."""
SHARES = (16, 4, 1)
"""Sizes, as parts of the people asked for."""


def write_study(file: Path, people: int) -> int:
    """Write ``questionnaires.csv`` and return its number of answers."""
    random = np.random.default_rng(SEED)
    items = [item.name for item in shipped_instruments()["ssq"].items]
    rows = 0
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(
            ["participant", "session", "trial", "condition", "scene", "timepoint", "instrument",
             "item", "response"]
        )  # fmt: skip
        for person in range(people):
            level = random.normal(-0.6, 0.7)
            trials = random.permutation(len(CONDITIONS) * len(SCENES))
            for trial, cell in enumerate(trials, start=1):
                condition, scene = CONDITIONS[cell // 2], SCENES[cell % 2]
                for timepoint, more in (("baseline", -0.6), ("post", 0.15 * (cell // 2))):
                    felt = level + more + random.normal(0, 0.7, len(items))
                    answers = np.clip(np.floor(felt + 1), 0, 3).astype(int)
                    where = (f"P{person:05d}", 1, trial, condition, scene, timepoint, "ssq")
                    writer.writerows([*where, i, a] for i, a in zip(items, answers, strict=True))
                    rows += len(items)
    return rows


def measure(people: int) -> Result:
    """Report a study of `people`, and smaller ones; return the cost of each part."""
    sizes = (max(people // share, 2) for share in SHARES)
    rows = [in_a_program("bench.many_answers", "--people", size, one_thread=True) for size in sizes]
    for row in rows:
        row["all s"] = sum(value for name, value in row.items() if name.endswith(" s"))
        row["slope"] = float("nan")
    for before, row in pairwise(rows):
        grown = math.log(row["answers"] / before["answers"])
        row["slope"] = math.log(row["all s"] / before["all s"]) / grown
    notes = [
        "CPU time of the whole process, one thread of BLAS; packages that are imported on the way "
        "are in it.",
        "Slope of log time over log answers, from the row before: 1 is linear.",
    ]
    return Result("A report of many answers", rows, notes)


def once(people: int) -> dict[str, Any]:
    """Return the people, their answers, and the seconds of each part."""
    times = dict.fromkeys([f"{name} s" for name in (*PARTS, "rest")], 0.0)
    with tempfile.TemporaryDirectory() as folder, ExitStack() as timed:
        file = Path(folder) / "questionnaires.csv"
        answers = write_study(file, people)
        for name, function in PARTS.items():
            timed.enter_context(_timed(function, times, f"{name} s"))
        start = time.process_time()
        report.build_report(file, out=Path(folder) / "report")
        times["rest s"] = time.process_time() - start - sum(times.values())
    return {"people": people, "answers": answers, **times}


@contextmanager
def _timed(function: str, times: dict[str, float], name: str) -> Iterator[None]:
    """Add the time that a part of the report takes to `times`."""
    plain = getattr(report, function)

    def clocked(*arguments: Any, **named: Any) -> Any:
        start = time.process_time()
        made = plain(*arguments, **named)
        times[name] += time.process_time() - start
        return made

    with replaced(report, function, clocked):
        yield


def main() -> None:
    """Read the command line, make the studies and report them."""
    parser = argparse.ArgumentParser(prog="python -m bench.many_answers", description=__doc__)
    parser.add_argument("--people", type=int, default=1000)
    parser.add_argument("--once", action="store_true", help="this size alone, as JSON")
    options = parser.parse_args()
    if options.once:
        print(json.dumps(once(options.people)))
        return
    result = measure(options.people)
    for row in result.rows:
        parts = ", ".join(f"{n[:-2]} {v:.2f}" for n, v in row.items() if n.endswith(" s"))
        slope = "" if math.isnan(row["slope"]) else f", slope {row['slope']:.2f}"
        print(f"{row['answers']} answers of {row['people']} people, s of CPU: {parts}{slope}")


if __name__ == "__main__":
    main()
