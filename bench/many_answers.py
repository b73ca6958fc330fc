"""What a report of many answers costs: `python -m bench.many_answers [--people 1000]`.

Makes a study of 16 questionnaires for each participant (four conditions in two scenes, a baseline
before each; 256,000 answers of 1,000 people), reports it, and prints the processor time of that,
and of reading and analysing alone.
"""

from __future__ import annotations

import argparse
import csv
import tempfile
import time
from pathlib import Path

import numpy as np

from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.report import build_report
from vrcomfort.report.plan import plan_of
from vrcomfort.report.results import analyse
from vrcomfort.report.study_data import read_study

CONDITIONS, SCENES = ("off", "weak", "middle", "strong"), ("near", "far")
SEED = 20150323


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


def main() -> None:
    """Read the command line, make the study and report it."""
    parser = argparse.ArgumentParser(prog="python -m bench.many_answers", description=__doc__)
    parser.add_argument("--people", type=int, default=1000)
    people = parser.parse_args().people
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "questionnaires.csv"
        rows = write_study(file, people)
        times = [time.process_time()]
        study = read_study(file)
        times.append(time.process_time())
        analyse(study, plan_of(study))
        times.append(time.process_time())
        build_report(file, out=Path(folder) / "report", forms=("svg",))
        times.append(time.process_time())
    reading, analysing, whole = np.diff(times)
    print(f"{rows} answers of {people} people: {whole:.1f} s of CPU with figures as SVG")
    print(f"reading {reading:.1f} s, analysing {analysing:.1f} s (with loading pingouin)")


if __name__ == "__main__":
    main()
