"""More files as labs have them: what is said in odd places, twice, or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.support.layouts import (
    CONDITIONS,
    ENGLISH,
    ITEMS,
    PEOPLE,
    TIMES,
    WORDS,
    Truth,
    study,
    write,
)

Made = tuple[list[Path], Truth]


def melted(folder: Path) -> Made:
    """One row per answer, times called T0 and T1."""
    truth = study()
    rows: list[Sequence[object]] = [["id", "cond", "time", "variable", "value"]]
    for (person, condition, time), answers in truth.items():
        when = "T0" if time == "baseline" else "T1"
        rows += [
            [person, condition, when, f"ssq_{item}", answer]
            for item, answer in zip(ITEMS, answers, strict=True)
        ]
    return [write(folder / "long.csv", rows)], truth


def asked_twice(folder: Path) -> Made:
    """The same headings twice in a row: before, then after."""
    truth = study()
    rows: list[Sequence[object]] = [["Timestamp", "Code", "Condition", *ENGLISH, *ENGLISH]]
    for person in PEOPLE:
        for condition in CONDITIONS:
            answers = [a for time in TIMES for a in truth[person, condition, time]]
            rows.append(["1", person, condition, *(WORDS[answer] for answer in answers)])
    return [write(folder / "forms.csv", rows)], truth


def json_columns(folder: Path) -> Made:
    """JSON with a list for each column."""
    truth = study(times=("post",))
    columns: dict[str, list[object]] = {
        "pid": [person for person, _, _ in truth],
        "mode": [condition for _, condition, _ in truth],
    }
    columns |= {item: [a[n] for a in truth.values()] for n, item in enumerate(ITEMS)}
    file = folder / "answers.json"
    file.write_text(json.dumps(columns))
    return [file], truth


def numbered(folder: Path) -> Made:
    """Numbers of items inside headings."""
    truth = study()
    names = [f"ssq{n}_{time}" for time in ("pre", "post") for n in range(1, 17)]
    rows: list[Sequence[object]] = [["participant", "technique", *names]]
    for person in PEOPLE:
        for condition in CONDITIONS:
            answers = [a for time in TIMES for a in truth[person, condition, time]]
            rows.append([person, condition, *answers])
    return [write(folder / "ssq.csv", rows)], truth


def with_codes(folder: Path) -> Made:
    """NA and 999 for answers that are missing, scores beside the answers."""
    truth = study(times=("post",))
    items = [f"{n}. {text}" for n, text in enumerate(ENGLISH, start=1)]
    rows: list[Sequence[object]] = [["Subject ID", "Cond", *items, "Nausea score", "SSQ Total"]]
    codes = {("P03", "plain"): "NA", ("P04", "plain"): "999"}
    for (person, condition, time), answers in list(truth.items()):
        cells: list[object] = [*answers]
        if (person, condition) in codes:
            cells[2] = codes[person, condition]
            truth[person, condition, time] = (*answers[:2], -1, *answers[3:])
        rows.append([person, condition, *cells, 1.5, sum(answers) * 3.74])
    return [write(folder / "x.csv", rows)], truth


def side_by_side(folder: Path) -> Made:
    """Items in rows, participants in columns."""
    truth = {(p, "all", t): a for (p, _, t), a in study(("",), ("post",)).items()}
    rows: list[Sequence[object]] = [["Symptom", *PEOPLE]]
    for n, text in enumerate(ENGLISH):
        rows.append([text, *(truth[person, "all", "post"][n] for person in PEOPLE)])
    return [write(folder / "x.csv", rows)], truth


def with_demographics(folder: Path) -> Made:
    """What is known of people in a file of its own."""
    truth = study(times=("post",))
    people = [[person, 20 + n, "f", 63.5] for n, person in enumerate(PEOPLE)]
    known = write(folder / "demo.csv", [["Participant", "Age", "Gender", "IPD (mm)"], *people])
    rows: list[Sequence[object]] = [["Participant", "Condition", *ENGLISH]]
    rows += [[person, condition, *answers] for (person, condition, _), answers in truth.items()]
    return [known, write(folder / "ssq.csv", rows)], truth


def in_sentences(folder: Path) -> Made:
    """Session and condition inside a sentence."""
    truth = study(times=("post",))
    names = [
        f"Session {n} ({condition}): Please rate: {text.lower()}"
        for n, condition in enumerate(CONDITIONS, start=1)
        for text in ENGLISH
    ]
    rows: list[Sequence[object]] = [["What is your participant number?", *names]]
    for person in PEOPLE:
        rows.append([person, *(a for c in CONDITIONS for a in truth[person, c, "post"])])
    return [write(folder / "x.csv", rows)], truth


def baseline_once(folder: Path) -> Made:
    """Baselines among the conditions."""
    after, before = study(times=("post",)), study(("",), ("baseline",), seed=3)
    rows: list[Sequence[object]] = [["Participant", "Phase", *ENGLISH]]
    for (person, condition, _), answers in [*before.items(), *after.items()]:
        rows.append([person, condition or "baseline", *answers])
    return [write(folder / "x.csv", rows)], {**before, **after}


def name_once(folder: Path) -> Made:
    """Excel with a participant's name in the first of their rows alone."""
    from openpyxl import Workbook

    truth = study(times=("post",))
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["Participant", "Condition", *ENGLISH])
    for (person, condition, _), answers in truth.items():
        sheet.append([person if condition == CONDITIONS[0] else None, condition, *answers])
    file = folder / "x.xlsx"
    book.save(file)
    return [file], truth


def item_called_otherwise(folder: Path) -> Made:
    """A column `Nausea` that is the sum of others; the item has another heading."""
    truth = study(times=("post",))
    names = ["Feeling sick" if text == "Nausea" else text for text in ENGLISH]
    rows: list[Sequence[object]] = [["Participant", "Condition", *names, "Nausea"]]
    for (person, condition, _), answers in truth.items():
        subscale = sum(answers[n] for n in (0, 5, 6, 7, 8, 14, 15))
        rows.append([person, condition, *answers, subscale])
    return [write(folder / "x.csv", rows)], truth


def from_one_without_the_highest(folder: Path) -> Made:
    """Answers from 1, of which none is 4."""
    truth = {
        key: tuple(min(answer, 2) for answer in answers)
        for key, answers in study(times=("post",)).items()
    }
    rows: list[Sequence[object]] = [["Participant", "Condition", *ENGLISH]]
    rows += [[p, c, *(answer + 1 for answer in a)] for (p, c, _), a in truth.items()]
    return [write(folder / "x.csv", rows)], truth


def in_initials(folder: Path) -> Made:
    """Items called by their initials, those of one word by up to four letters."""
    truth = study()
    short = ["GD", "FA", "HE", "EYES", "DF", "IS", "SWE", "NAU", "DC", "FH", "BV", "DEO", "DEC"]
    short += ["VERT", "SA", "B"]
    names = [f"SSQ_{time}_{each}" for time in ("pre", "post") for each in short]
    rows: list[Sequence[object]] = [["participant", "condition", *names]]
    for person in PEOPLE:
        for condition in CONDITIONS:
            answers = [a for time in TIMES for a in truth[person, condition, time]]
            rows.append([person, condition, *answers])
    return [write(folder / "x.csv", rows)], truth


def sheet_per_person(folder: Path) -> Made:
    """A sheet for each person, items in rows, before and after side by side."""
    from openpyxl import Workbook

    truth = {(p, "all", t): a for (p, _, t), a in study(("",)).items()}
    book = Workbook()
    for person in PEOPLE:
        sheet = book.create_sheet(person)
        sheet.append(["Symptom", "Pre", "Post"])
        for n, text in enumerate(ENGLISH):
            sheet.append([text, *(truth[person, "all", time][n] for time in TIMES)])
    del book["Sheet"]
    file = folder / "ssq.xlsx"
    book.save(file)
    return [file], truth


def one_row_per_screen(folder: Path) -> Made:
    """A logger's table: rows of other screens have no answers."""
    truth = study(times=("post",))
    names = [f"ssq.{item}" for item in ITEMS]
    rows: list[Sequence[object]] = [["participant", "condition", *names, "frameRate", "rt"]]
    for (person, condition, _), answers in truth.items():
        rows += [[person, condition, *[""] * 16, 60.1, ""]]
        rows += [[person, condition, *answers, 60.1, 0.3]]
    return [write(folder / "x.csv", rows)], truth


ODD_LAYOUTS: dict[str, Callable[[Path], Made]] = {
    each.__name__: each
    for each in (
        melted, asked_twice, json_columns, numbered, with_codes, side_by_side, with_demographics,
        in_sentences, baseline_once, name_once, item_called_otherwise,
        from_one_without_the_highest, in_initials, sheet_per_person, one_row_per_screen,
    )
}  # fmt: skip
