"""Small studies of other designs than the crossover: groups, before and after, tasks, choices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tests.support.report import answers, write_csv
from vrcomfort.records import QuestionnaireRow

RNG_SEED = 14
GROUPS = ("vignette", "none")


def _ssq(name: str, timepoint: str, total: int, condition: str = "") -> list[dict[str, object]]:
    return [
        {"participant": name, "session": 1, "instrument": "ssq", "item": item, "response": answer,
         "timepoint": timepoint, "condition": condition, "order": order}
        for order, (item, answer) in enumerate(answers(total).items(), start=1)
    ]  # fmt: skip


def between_groups(folder: Path, people: int = 16) -> Path:
    """Half of the people see a vignette, the others none; SSQ before and after, and age."""
    rng = np.random.default_rng(RNG_SEED)
    persons, rows = [], []
    for place in range(people):
        name, group = f"P{place + 1:02d}", GROUPS[place % 2]
        before = int(rng.poisson(2))
        after = before + int(rng.poisson(2 if group == "vignette" else 7))
        persons.append({"participant": name, "status": "completed", "group": group,
                        "age": int(rng.integers(19, 40))})  # fmt: skip
        rows += _ssq(name, "baseline", before) + _ssq(name, "post", after)
    write_csv(folder / "participants.csv", ("participant", "status", "group", "age"), persons)
    write_csv(folder / "questionnaires.csv", QuestionnaireRow.columns(), rows)
    return folder


def before_and_after(folder: Path, people: int = 12) -> Path:
    """One condition; SSQ before and after."""
    rng = np.random.default_rng(RNG_SEED)
    rows = []
    for place in range(people):
        name, before = f"P{place + 1:02d}", int(rng.poisson(2))
        rows += _ssq(name, "baseline", before, "blur")
        rows += _ssq(name, "post", before + int(rng.poisson(3)), "blur")
    write_csv(folder / "questionnaires.csv", QuestionnaireRow.columns(), rows)
    return folder


def tasks_only(folder: Path, people: int = 12) -> Path:
    """Search times and errors under two conditions, three trials each; nobody was asked."""
    rng = np.random.default_rng(RNG_SEED)
    rows = [
        {"participant": f"P{place + 1:02d}", "session": 1, "trial": 1 + 3 * block + trial,
         "condition": condition, "search_s": f"{level + rng.gamma(4, 0.5):.3f}",
         "errors": int(rng.poisson(1))}
        for place in range(people)
        for block, (condition, level) in enumerate((("sharp", 2.0), ("blur", 2.6)))
        for trial in range(3)
    ]  # fmt: skip
    columns = ("participant", "session", "trial", "condition", "search_s", "errors")
    write_csv(folder / "tasks.csv", columns, rows)
    return folder


def preferences_only(folder: Path, people: int = 20) -> Path:
    """Which of two people liked better, and nothing else."""
    said = ["blur"] * 12 + ["sharp"] * 4 + ["none"] * 3 + [""]
    rows = [
        {"participant": f"P{place + 1:02d}", "status": "completed", "liked": said[place]}
        for place in range(people)
    ]
    write_csv(folder / "participants.csv", ("participant", "status", "liked"), rows)
    return folder
