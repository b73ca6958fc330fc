"""Compares the rows that a recorder took with the files that are left."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from pathlib import Path
from typing import NamedTuple

PARTICIPANT = "P01"
TRIALS, ITEMS = 3, 16
"""Of ``study.toml``."""


class Told(NamedTuple):
    """A row that the recorder took, and when."""

    ns: int
    file: str
    cells: tuple[tuple[str, str], ...]


Rows = Counter[tuple[str, tuple[tuple[str, str], ...]]]


def session_folder(study: Path) -> Path:
    """Return where the session's files are."""
    return study / f"sub-{PARTICIPANT}" / "ses-1"


def resume_codes(study: Path) -> set[int]:
    """Return the exit codes that `--resume` may have: refused where the session is complete."""
    try:
        manifest = json.loads((session_folder(study) / "manifest.json").read_text())
    except (OSError, ValueError):
        return {0}
    return {0, 2} if manifest.get("status") == "completed" else {0}


def missing(rows: Rows, study: Path) -> Rows:
    """Return which rows are not in the files; half-written ones are not."""
    lost: Rows = Counter()
    for file in {file for file, _ in rows}:
        there = _table(session_folder(study) / file)
        columns = {tuple(name for name, _ in cells) for told, cells in rows if told == file}
        for names in columns:
            found = Counter(tuple((name, row.get(name) or "") for name in names) for row in there)
            wanted = Counter(
                {
                    cells: count
                    for (told, cells), count in rows.items()
                    if told == file and tuple(name for name, _ in cells) == names
                }
            )
            lost.update({(file, cells): count for cells, count in (wanted - found).items()})
    return lost


def _table(file: Path) -> list[dict[str, str]]:
    """Read whole rows by rules of our own: what the product's reader takes is not the question."""
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        return []
    whole = content.rpartition(b"\n")[0] + b"\n" if b"\n" in content else b""
    text = whole.decode("utf-8", errors="replace")
    lines = [line for line in text.splitlines(keepends=True) if "\0" not in line]
    return list(csv.DictReader(io.StringIO("".join(lines), newline="")))


def whole_rows(study: Path) -> Rows:
    """Return the whole rows of all of the session's tables, but for the recorder's own word."""
    found: Rows = Counter()
    for file in session_folder(study).glob("*.csv"):
        for row in _table(file):
            row.pop("resumed", None)
            found[file.name, tuple((name, cell or "") for name, cell in row.items())] += 1
    return found


def never_asked(study: Path) -> int:
    """Return how many items of its questionnaires a session that is complete does not have."""
    folder = session_folder(study)
    rows = _table(folder / "questionnaires.csv")
    answered = {(row["timepoint"], row["trial"], row["item"]) for row in rows}
    owed = ITEMS * (TRIALS + 2)  # before, after each trial, at the end
    return max(owed - len(answered), 0)


def by_file(rows: Rows) -> str:
    """Return how many rows of each file there are, in words."""
    counts: Counter[str] = Counter()
    for (file, _), count in rows.items():
        counts[file] += count
    return ", ".join(f"{count} of {file}" for file, count in sorted(counts.items()))
