"""Reads what a study left: every questionnaire at any depth, and whatever else is there."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import SSQ, Sheet, answer_number
from vrcomfort.records.schema import check_schema_version
from vrcomfort.report.ordering import natural

_KEYS = (
    "participant", "session", "period", "trial", "condition", "scene", "sequence", "timepoint"
)  # fmt: skip
NEEDED = ("participant", "condition", "item", "response")
_NEEDED_ELSEWHERE = {
    "participants.csv": ("participant", "status"),
    "trials.csv": ("participant", "session", "trial", "condition", "scene", "status"),
    "ratings.csv": ("missed",),
}
_NUMBERS = ("start_s", "end_s", "frames", "dropped", "missed")


@dataclass(frozen=True)
class StudyData:
    """Everything a report is made from."""

    title: str
    protocol: str | None
    labels: dict[str, str]
    """Condition → label, in the protocol's order; empty without a study description."""
    sheets: tuple[Sheet, ...]
    participants: tuple[dict[str, str], ...]
    trials: tuple[dict[str, str], ...]
    ratings: tuple[dict[str, str], ...]
    manifests: tuple[dict[str, Any], ...]
    files: int
    warnings: tuple[str, ...]


def read_study(source: Path) -> StudyData:
    """Read a study folder, any folder with ``questionnaires.csv`` in it, or one such file.

    Raises
    ------
    InputError
        If there is no questionnaire, or a table is wrong, with file, line and column.
    """
    files = _files(source, "questionnaires.csv")
    if not files:
        raise InputError("there is no questionnaires.csv in this folder", file=source)
    warnings: list[str] = []
    sheets = [sheet for file in files for sheet in _sheets(file, source, warnings)]
    if not sheets:
        raise InputError("there is no answered SSQ in these questionnaires", file=source)
    description = _json(source / "dataset_description.json") if source.is_dir() else {}
    return StudyData(
        title=str(description.get("name") or source.resolve().name),
        protocol=description.get("protocol"),
        labels=_labels(description.get("conditions")),
        sheets=tuple(sorted(sheets, key=lambda s: natural(s.participant))),
        participants=_table(source, "participants.csv", warnings),
        trials=_last_attempts(_table(source, "trials.csv", warnings)),
        ratings=_table(source, "ratings.csv", warnings),
        manifests=_manifests(source, warnings),
        files=len(files),
        warnings=tuple(warnings),
    )


def _files(source: Path, name: str) -> list[Path]:
    if source.is_file():
        return [source] if name == "questionnaires.csv" else []
    if not source.is_dir():
        raise InputError("there is no such file or folder", file=source)
    return sorted(source.rglob(name), key=lambda path: natural(path.as_posix()))


def _read(file: Path, source: Path, warnings: list[str]) -> CsvTable:
    found = CsvTable.read(file, appended=True)
    prefix = f"{source}/" if source.is_dir() else f"{source.parent}/"
    warnings.extend(warning.removeprefix(prefix) for warning in found.warnings)
    return found


def _table(source: Path, name: str, warnings: list[str]) -> tuple[dict[str, str], ...]:
    """Read what enriches a report; a file of that name from elsewhere is told and left alone."""
    rows: list[dict[str, str]] = []
    for file in _files(source, name):
        found = _read(file, source, warnings)
        missing = [column for column in _NEEDED_ELSEWHERE[name] if column not in found.header]
        if missing and found.header:
            place = file.relative_to(source)
            warnings.append(f"{place}: not used, because it has no column {missing[0]}")
        else:
            found.require_numbers(_NUMBERS)
            rows += found.dicts()
    return tuple(rows)


def _last_attempts(trials: tuple[dict[str, str], ...]) -> tuple[dict[str, str], ...]:
    """Leave out what was begun again later; a table without attempts stays as it is."""
    if not all("attempt" in trial for trial in trials):
        return trials
    last = {(trial["participant"], trial["session"], trial["trial"]): trial for trial in trials}
    return tuple(last.values())


def _json(file: Path) -> dict[str, Any]:
    if not file.is_file():
        return {}
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except UnicodeDecodeError:
        raise InputError("this is not UTF-8; save it as JSON in UTF-8", file=file) from None
    except ValueError as error:
        raise InputError(f"this is not valid JSON: {error}", file=file) from error
    return content if isinstance(content, dict) else {}


def _labels(conditions: Any) -> dict[str, str]:
    """Return condition → label; a description from elsewhere may say something else there."""
    if not isinstance(conditions, dict):
        return {}
    return {str(name): str(label) for name, label in conditions.items()}


def _manifests(source: Path, warnings: list[str]) -> tuple[dict[str, Any], ...]:
    """Read the sessions' manifests; a file of that name from elsewhere is told and left alone."""
    ours: list[dict[str, Any]] = []
    for file in _files(source, "manifest.json"):
        content = _json(file)
        protocol, clamps = content.get("protocol"), content.get("clamps", [])
        if isinstance(protocol, dict) and isinstance(clamps, list):
            check_schema_version(content, file)
            ours.append(content)
        else:
            place = file.relative_to(source)
            warnings.append(f"{place}: not used, because it is no session's manifest")
    return tuple(ours)


def _sheets(file: Path, source: Path, warnings: list[str]) -> list[Sheet]:
    found = _read(file, source, warnings)
    if found.header:
        found.require(NEEDED)
    name = file.relative_to(source).as_posix() if source.is_dir() else file.name
    sheets = _SheetsOfFile(found, name)
    for row, line in zip(found.dicts(), found.lines, strict=True):
        if (row.get("instrument") or SSQ.name).lower() == SSQ.name:
            sheets.add(row, line)
    return list(sheets.found.values())


class _SheetsOfFile:
    """The questionnaires of one file, whose rows are in the order in which they were answered."""

    def __init__(self, table: CsvTable, name: str) -> None:
        self._table = table
        self._name = name
        self._runs: dict[tuple[str, ...], int] = {}
        self.found: dict[tuple[str | int, ...], Sheet] = {}

    def add(self, row: dict[str, str], line: int) -> None:
        """Put one answer where it belongs."""
        table = self._table
        key = tuple(row.get(column, "").strip() for column in _KEYS)
        if not key[0]:
            raise table.fault("a participant is missing", line, "participant")
        item = SSQ.item(row["item"])
        if item is None:
            raise table.fault(f"`{row['item']}` is not an item of the SSQ", line, "item")
        run = self._run(row, key, item.name)
        sheet = self.found.setdefault((*key, run), self._sheet(key, line, run))
        sheet.require_unanswered(item, table, line)
        sheet.answers[item.name] = _answer(row["response"].strip(), table, line)

    def _run(self, row: dict[str, str], key: tuple[str, ...], item: str) -> int:
        """Return how often the session had been resumed: each run asks something once."""
        person = key[:2]
        run = self._runs.get(person, 0)
        if row.get("resumed", "").strip() not in {"", "0"}:
            sheet = self.found.get((*key, run))
            repeated = sheet is not None and item in sheet.answers
            run = max(run, 1) + (repeated and run > 0)
            self._runs[person] = run
        return run

    def _sheet(self, key: tuple[str, ...], line: int, run: int) -> Sheet:
        keys = dict(zip(_KEYS, key, strict=True))
        keys["timepoint"] = keys["timepoint"] or "post"
        return Sheet(line, keys, place=f"{self._name}, line {line}", run=run)


def _answer(text: str, table: CsvTable, line: int) -> int | None:
    """Return a whole answer on the scale; blank is missing."""
    if not text:
        return None
    number = answer_number(text)
    if not number.is_integer() or not SSQ.low <= number <= SSQ.high:
        message = f"`{text}` is not a whole number from {SSQ.low} to {SSQ.high}"
        raise table.fault(message, line, "response")
    return int(number)
