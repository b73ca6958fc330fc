"""Files as labs have them: one study, whose answers are known, in many layouts."""

from __future__ import annotations

import csv
import io
import json
import random
from collections.abc import Callable, Sequence
from pathlib import Path

from vrcomfort.questionnaire import shipped_instruments

ITEMS = tuple(item.name for item in shipped_instruments()["ssq"].items)
PEOPLE = tuple(f"P{n:02d}" for n in range(1, 11))
CONDITIONS = ("blur", "plain")
TIMES = ("baseline", "post")
WORDS = ("None", "Slight", "Moderate", "Severe")

Key = tuple[str, str, str]
"""Participant, condition (blank where the layout has none), timepoint."""
Truth = dict[Key, tuple[int, ...]]


def study(
    conditions: Sequence[str] = CONDITIONS, times: Sequence[str] = TIMES, seed: int = 1
) -> Truth:
    """Return answers of every person, condition and time; all four occur in each item."""
    draw = random.Random(seed)  # noqa: S311
    truth: Truth = {}
    for person in PEOPLE:
        for condition in conditions:
            for time in times:
                truth[person, condition, time] = tuple(
                    draw.choices(range(4), (6, 3, 2, 1), k=len(ITEMS))
                )
    first = next(iter(truth))
    truth[first] = tuple(n % 4 for n in range(len(ITEMS)))
    return truth


def write(
    file: Path, rows: Sequence[Sequence[object]], *, separator: str = ",", encoding: str = "utf-8"
) -> Path:
    """Write rows as a text table."""
    text = io.StringIO()
    csv.writer(text, delimiter=separator, lineterminator="\r\n").writerows(rows)
    file.write_bytes(text.getvalue().encode(encoding))
    return file


ENGLISH = tuple(item.text for item in shipped_instruments()["ssq"].items)
GERMAN = (
    "Allgemeines Unwohlsein", "Ermüdung", "Kopfschmerzen", "Überanstrengte Augen",
    "Schwierigkeiten beim Scharfsehen", "Erhöhter Speichelfluss", "Schwitzen", "Übelkeit",
    "Konzentrationsschwierigkeiten", "Kopfdruck", "Verschwommenes Sehen",
    "Schwindel (bei geöffneten Augen)", "Schwindel (bei geschlossenen Augen)",
    "Gleichgewichtsstörung", "Magenbeschwerden", "Aufstoßen",
)  # fmt: skip
GERMAN_WORDS = ("gar nicht", "etwas", "mittel", "stark")


def google_forms(folder: Path) -> tuple[list[Path], Truth]:
    """One row per person and condition; the question in each heading; answers in words."""
    truth = study(times=("post",))
    ask = "How strongly do you feel each symptom right now?"
    head = ["Timestamp", "Participant ID", "Which condition did you just complete?"]
    rows: list[Sequence[object]] = [[*head, *(f"{ask} [{text}]" for text in ENGLISH), "Comments"]]
    for (person, condition, _), answers in truth.items():
        words = [WORDS[answer] for answer in answers]
        rows.append(["2024/05/01 10:00:00 AM", person, condition, *words, "fine, thanks"])
    return [write(folder / "SSQ (Responses) - Form Responses 1.csv", rows)], truth


def qualtrics(folder: Path) -> tuple[list[Path], Truth]:
    """Three rows of headings; before and after in one row; ids in the first heading."""
    truth = study(times=TIMES)
    fixed = ["StartDate", "ResponseId", "Finished", "PID", "Condition", "Age"]
    texts = ["Start Date", "Response ID", "Finished", "Participant ID", "Condition", "Age"]
    names = [f"{time}_SSQ_{n}" for time in ("pre", "post") for n in range(1, 17)]
    questions = [f"How do you feel now? - {text}" for _ in TIMES for text in ENGLISH]
    ids = [json.dumps({"ImportId": f"QID{n}"}) for n in range(len(fixed) + len(names))]
    rows: list[Sequence[object]] = [[*fixed, *names], [*texts, *questions], ids]
    for place, person in enumerate(PEOPLE):
        for condition in CONDITIONS:
            answers = [a for time in TIMES for a in truth[person, condition, time]]
            own = [
                "2024-05-01 10:00:00",
                f"R_{place}{condition}",
                "1",
                person,
                condition,
                20 + place,
            ]
            rows.append([*own, *answers])
    return [write(folder / "Comfort+Study_May+1.csv", rows, encoding="utf-8-sig")], truth


def limesurvey(folder: Path) -> tuple[list[Path], Truth]:
    """Semicolons, codes with brackets, answers from 1 to 4."""
    truth = study(times=("post",))
    rows: list[Sequence[object]] = [
        ["id", "submitdate", "lastpage", "startlanguage", "subject", "cond",
         *(f"SSQ[SQ{n:03d}]" for n in range(1, 17))]
    ]  # fmt: skip
    for number, ((person, condition, _), answers) in enumerate(truth.items(), start=1):
        own = [number, "2024-05-01 10:00:00", 3, "en", person, condition]
        rows.append([*own, *(answer + 1 for answer in answers)])
    return [write(folder / "results-survey123456.csv", rows, separator=";")], truth


def spss_wide(folder: Path) -> tuple[list[Path], Truth]:
    """One row per person: condition, time and item in each heading; −99 is missing; sums."""
    truth = study()
    places = [(c, t) for c in CONDITIONS for t in TIMES]
    head = ["VPN", "age", "sex", "group"]
    for condition, time in places:
        short = "pre" if time == "baseline" else "post"
        head += [f"{condition}_{short}_{item}" for item in ITEMS]
        head += [f"{condition}_{short}_sum"]
    rows: list[Sequence[object]] = [head]
    for place, person in enumerate(PEOPLE):
        row: list[object] = [person, 20 + place, "fm"[place % 2], "AB"[place % 2]]
        for condition, time in places:
            answers = truth[person, condition, time]
            row += [*answers, sum(answers)]
        rows.append(row)
    return [write(folder / "spss_export.csv", rows)], truth


def unity_json(folder: Path) -> tuple[list[Path], Truth]:
    """One JSON file per person, records inside records."""
    truth = study(times=("post",))
    files = []
    for person in PEOPLE:
        trials = [
            {
                "trialNumber": n,
                "condition": condition,
                "answers": [
                    {"questionnaire": "SSQ", "item": text, "value": answer, "rt": 1.5}
                    for text, answer in zip(ENGLISH, truth[person, condition, "post"], strict=True)
                ],
            }
            for n, condition in enumerate(CONDITIONS, start=1)
        ]
        file = folder / f"session_{person}.json"
        file.write_text(json.dumps({"participantId": person, "trials": trials}))
        files.append(file)
    return files, truth


def german(folder: Path) -> tuple[list[Path], Truth]:
    """German headings and answers, semicolons, decimal commas, Windows-1252."""
    truth = study(times=("post",))
    rows: list[Sequence[object]] = [["Probandennummer", "Alter", "Bedingung", "Dauer_min", *GERMAN]]
    for (person, condition, _), answers in truth.items():
        words = [GERMAN_WORDS[answer] for answer in answers]
        rows.append([person, 20 + int(person[1:]), condition, "12,5", *words])
    file = folder / "fragebogen.csv"
    return [write(file, rows, separator=";", encoding="windows-1252")], truth


def excel_sheets(folder: Path) -> tuple[list[Path], Truth]:
    """A sheet for each condition, a title above, means below, and a sheet of remarks."""
    from openpyxl import Workbook

    truth = study(times=("post",))
    book = Workbook()
    book.remove(book.active)
    for condition in CONDITIONS:
        sheet = book.create_sheet(condition)
        sheet.append([f"SSQ after {condition}"])
        sheet.append([])
        sheet.append(["ID", *ENGLISH])
        for person in PEOPLE:
            sheet.append([person, *truth[person, condition, "post"]])
        columns = list(zip(*(truth[p, condition, "post"] for p in PEOPLE), strict=True))
        sheet.append(["Mean", *(sum(column) / len(column) for column in columns)])
    notes = book.create_sheet("Notes")
    notes.append(["Remark"])
    notes.append(["P03 came late"])
    file = folder / "ssq.xlsx"
    book.save(file)
    return [file], truth


def headerless(folder: Path) -> tuple[list[Path], Truth]:
    """No headings: person, condition, sixteen answers."""
    truth = study(times=("post",))
    rows = [[person, condition, *answers] for (person, condition, _), answers in truth.items()]
    return [write(folder / "data.txt", rows, separator="\t")], truth


def named_files(folder: Path) -> tuple[list[Path], Truth]:
    """A file per person, condition and time, which only their names tell apart."""
    truth = study()
    files = []
    for (person, condition, time), answers in truth.items():
        rows = [["item", "answer"], *zip(ENGLISH, answers, strict=True)]
        short = "pre" if time == "baseline" else "post"
        files.append(write(folder / f"ssq_{person}_{condition}_{short}.csv", rows))
    return files, truth


def long_numbers(folder: Path) -> tuple[list[Path], Truth]:
    """A row per answer with the number of the item; another questionnaire in between."""
    truth = study(times=("post",))
    rows: list[Sequence[object]] = [
        ["subject_id", "condition", "questionnaire", "question", "response"]
    ]
    for (person, condition, _), answers in truth.items():
        rows += [[person, condition, "Comfort", n, 4] for n in range(1, 15)]
        rows += [[person, condition, "SSQ", n, a] for n, a in enumerate(answers, start=1)]
    return [write(folder / "answers.tsv", rows, separator="\t", encoding="utf-16")], truth


def two_row_heading(folder: Path) -> tuple[list[Path], Truth]:
    """Conditions over their items, in two rows of headings."""
    truth = study(times=("post",))
    upper = ["", *(name for c in CONDITIONS for name in (c, *[""] * 15))]
    rows: list[Sequence[object]] = [upper, ["Participant", *(ENGLISH * 2)]]
    for person in PEOPLE:
        answers = [a for c in CONDITIONS for a in truth[person, c, "post"]]
        rows.append([person, *answers])
    return [write(folder / "table1.csv", rows)], truth


def misspelt(folder: Path) -> tuple[list[Path], Truth]:
    """Misspelt and shortened headings with numbers, words with numbers as answers."""
    truth = study(times=("post",))
    names = [
        "1. General discomfort", "2. Fatigue", "3. Headache", "4. Eyestrain",
        "5. Difficulty focussing", "6. Increased salivaton", "7. Sweating", "8. Nausea",
        "9. Diff. concentrating", "10. Fullnes of head", "11. Blurred vision",
        "12. Dizzy (eyes open)", "13. Dizzy (eyes closed)", "14. Vertigo",
        "15. Stomach awarness", "16. Burping",
    ]  # fmt: skip
    rows: list[Sequence[object]] = [["Subject", "Display", *names]]
    for (person, condition, _), answers in truth.items():
        words = [f"{answer} - {WORDS[answer]}" for answer in answers]
        rows.append([person, condition, *words])
    return [write(folder / "ssq_answers.csv", rows)], truth


LAYOUTS: dict[str, Callable[[Path], tuple[list[Path], Truth]]] = {
    each.__name__: each
    for each in (
        google_forms, qualtrics, limesurvey, spss_wide, unity_json, german, excel_sheets,
        headerless, named_files, long_numbers, two_row_heading, misspelt,
    )
}  # fmt: skip


def example(file: Path) -> Path:
    """Write the file of docs/import.md: eight people, two displays, before and after, in words."""
    texts = [text.replace("Fullness", "Fullnes") for text in ENGLISH]
    head = ["Zeitstempel", "VP-Code", "Age", "Display"]
    head += [f"{time}: {text}" for time in ("Pre", "Post") for text in texts]
    draw = random.Random(13)  # noqa: S311
    rows: list[Sequence[object]] = [[*head, "Total post"]]
    for number in range(1, 9):
        for display in ("60 Hz", "120 Hz"):
            before = draw.choices(range(3), (8, 2, 1), k=16)
            after = draw.choices(
                range(4), (5, 4, 2, 1) if display == "60 Hz" else (8, 3, 1, 0), k=16
            )
            words = [WORDS[answer].casefold() for answer in (*before, *after)]
            when = f"2026-03-{number:02d} 10:{number:02d}"
            rows.append([when, f"VP{number:02d}", 20 + number, display, *words, sum(after)])
    return write(file, rows, separator=";", encoding="windows-1252")
