"""Reads what a study left: every questionnaire at any depth, and whatever else is there."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from vrcomfort.csv_table import CsvTable
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import (
    FOLDER,
    Instrument,
    Sheet,
    asked_in,
    find_instrument,
    instruments_in,
    read_long,
    shipped_instruments,
)
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
_NUMBERS = (
    "start_s", "end_s", "frames", "dropped", "missed", "missed_refreshes",
    "live_s", "frozen_s", "hidden_s", "unfocused_s",
)  # fmt: skip


@dataclass(frozen=True)
class StudyData:
    """Everything a report is made from."""

    title: str
    protocol: str | None
    instrument: Instrument
    """What the sheets are answers to."""
    labels: dict[str, str]
    """Condition → label, in the protocol's order; empty without a study description."""
    sheets: tuple[Sheet, ...]
    participants: tuple[dict[str, str], ...]
    trials: tuple[dict[str, str], ...]
    ratings: tuple[dict[str, str], ...]
    manifests: tuple[dict[str, Any], ...]
    files: int
    warnings: tuple[str, ...]


def read_study(source: Path, instrument: str | Instrument | None = None) -> StudyData:
    """Read a study folder, any folder with ``questionnaires.csv`` in it, or one such file.

    Parameters
    ----------
    instrument
        Whose answers to read: an instrument, or the name or the file of one. Without it, the one
        of which there are most after exposures.

    Raises
    ------
    InputError
        If there is no questionnaire, or a table is wrong, with file, line and column.
    """
    files = _files(source, "questionnaires.csv")
    if not files:
        raise InputError("there is no questionnaires.csv in this folder", file=source)
    warnings: list[str] = []
    tables = {file: _questionnaires(file, source, warnings) for file in files}
    asked = _instrument(source, list(tables.values()), instrument, warnings)
    sheets = [
        sheet for file, table in tables.items() for sheet in _sheets(file, table, source, asked)
    ]
    if not sheets:
        message = f"there is no answered {asked.short} in these questionnaires"
        raise InputError(message, file=source)
    description = _description(source)
    return StudyData(
        title=str(description.get("name") or source.resolve().name),
        protocol=protocol_of(source),
        instrument=asked,
        labels=_labels(description.get("conditions")),
        sheets=tuple(sorted(sheets, key=lambda s: natural(s.participant))),
        participants=_table(source, "participants.csv", warnings),
        trials=_last_attempts(_table(source, "trials.csv", warnings)),
        ratings=_table(source, "ratings.csv", warnings),
        manifests=_manifests(source, warnings),
        files=len(files),
        warnings=tuple(warnings),
    )


def protocol_of(source: Path) -> str | None:
    """Return the name of a study's protocol, where its description gives one."""
    name = _description(source).get("protocol")
    return None if name is None else str(name)


def _description(source: Path) -> dict[str, Any]:
    return _json(source / "dataset_description.json") if source.is_dir() else {}


def of_one_kind(study: StudyData, *, simulated: bool) -> StudyData:
    """Keep the simulated participants of a study, or everybody else; say so where it had both.

    Raises
    ------
    InputError
        If the study has none of that kind.
    """
    kinds = {
        str(each.get("participant")): each.get("respondent") == "simulated"
        for each in study.manifests
    }
    everybody = {sheet.participant for sheet in study.sheets}
    kept = {name for name in everybody if kinds.get(name, False) == simulated}
    what = "simulated" if simulated else "real"
    if not kept:
        raise InputError(f"this study has no {what} participants")
    left = len(everybody - kept)
    if not left:
        return study
    other = "real" if simulated else "simulated"
    note = f"this study has {len(kept)} {what} and {left} {other} participants; only the {what} are"
    hint = "leave --simulated out" if simulated else "give --simulated"
    rows: dict[str, Any] = {
        name: tuple(
            row
            for row in getattr(study, name)
            if kinds.get(str(row.get("participant", "")), False) == simulated
        )
        for name in ("participants", "trials", "ratings", "manifests")
    }
    return replace(
        study,
        sheets=tuple(sheet for sheet in study.sheets if sheet.participant in kept),
        warnings=(*study.warnings, f"{note} in this report; for the others {hint}"),
        **rows,
    )


def trial_s(trial: dict[str, str]) -> float | None:
    """Return how long a trial's stimulus was seen: its live time, or (not recorded) its length."""
    try:
        return float(trial.get("live_s") or float(trial["end_s"]) - float(trial["start_s"]))
    except (KeyError, ValueError):
        return None


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
        json.dumps(content, ensure_ascii=False).encode()  # half of a pair is no text
    except UnicodeDecodeError:
        raise InputError("this is not UTF-8; save it as JSON in UTF-8", file=file) from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"this is not valid JSON: {error}", file=file) from error
    return content if isinstance(content, dict) else {}


def _labels(conditions: Any) -> dict[str, str]:
    """Return condition → label; a description from elsewhere may say something else there."""
    if not isinstance(conditions, dict):
        return {}
    return {str(name): str(label) for name, label in conditions.items()}


def _is_manifest(content: dict[str, Any]) -> bool:
    """Return whether what a report reads of a session's manifest is what it takes it for."""
    protocol, settings = content.get("protocol"), content.get("settings") or {}
    asks = settings.get("questionnaires", []) if isinstance(settings, dict) else None
    return (
        isinstance(protocol, dict)
        and isinstance(protocol.get("sha256", ""), str)
        and isinstance(content.get("clamps", []), list)
        and isinstance(asks, list)
        and all(isinstance(each, dict) for each in asks)
    )


def _manifests(source: Path, warnings: list[str]) -> tuple[dict[str, Any], ...]:
    """Read the sessions' manifests; a file of that name from elsewhere is told and left alone."""
    ours: list[dict[str, Any]] = []
    for file in _files(source, "manifest.json"):
        content = _json(file)
        if _is_manifest(content):
            check_schema_version(content, file)
            ours.append(content)
        else:
            place = file.relative_to(source)
            warnings.append(f"{place}: not used, because it is no session's manifest")
    return tuple(ours)


def _questionnaires(file: Path, source: Path, warnings: list[str]) -> CsvTable:
    found = _read(file, source, warnings)
    if found.header:
        found.require(NEEDED)
    return found


def _instrument(
    source: Path, tables: list[CsvTable], wanted: str | Instrument | None, warnings: list[str]
) -> Instrument:
    """Return the instrument to report, and say which other answers there are."""
    folder = source if source.is_dir() else source.parent
    own = instruments_in(sorted({each.parent.parent for each in folder.rglob(f"{FOLDER}/*.toml")}))
    known = {**shipped_instruments(), **own}
    if isinstance(wanted, str):
        wanted = find_instrument(wanted, known=known)
    if wanted is not None:
        known[wanted.name] = wanted
    found = asked_in(tables, known)
    there = [name for name in found if name in known]
    if wanted is None and not there:
        names = ", ".join(f"`{name}`" for name in found)
        what = f"the instrument {names} is not known" if found else "the items are of no instrument"
        hint = "write it in a TOML file, and give that as --instrument (see docs/instruments.md)"
        raise InputError(f"{what} in these questionnaires; {hint}", file=source)
    chosen = wanted or known[there[0]]
    for name, count in found.items():
        if name == chosen.name:
            continue
        if name in known:
            many = f"{round(count)} questionnaires of the {known[name].short}"
            warnings.append(f"{many} are not in this report; for them give --instrument {name}")
        else:
            warnings.append(f"rows of `{name}` are not used: no instrument of that name is known")
    return chosen


def _sheets(file: Path, found: CsvTable, source: Path, instrument: Instrument) -> list[Sheet]:
    name = file.relative_to(source).as_posix() if source.is_dir() else file.name
    sheets = read_long(found, instrument, _KEYS)
    for sheet in sheets:
        if not sheet.participant:
            raise found.fault("a participant is missing", sheet.line, "participant")
        sheet.keys["timepoint"] = sheet.timepoint or "post"
        sheet.place = f"{name}, line {sheet.line}"
    return sheets
