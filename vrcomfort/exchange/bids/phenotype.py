"""Questionnaires as BIDS phenotype tables: a row for each participant, a column for each answer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from vrcomfort.exchange.bids.files import write_json, write_tsv
from vrcomfort.questionnaire import Instrument, instruments_in, shipped_instruments
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.session_rows import QuestionnaireRow


def write_phenotype(study: Study, out: Path, participants: Iterable[str]) -> None:
    """Write a table and its sidecar for each instrument that was answered.

    Raises
    ------
    InputError
        If a table is damaged.
    """
    known = {**shipped_instruments(), **instruments_in([study.folder])}
    tables: dict[str, dict[str, dict[str, str]]] = {}
    columns: dict[str, dict[str, dict[str, Any]]] = {}
    for name in participants:
        for session in study.sessions_of(name):
            asked_in = _languages(session)
            for row in session.text_rows(QuestionnaireRow):
                instrument = row["instrument"]
                cells = tables.setdefault(instrument, {}).setdefault(f"sub-{name}", {})
                said = columns.setdefault(instrument, {})
                for column, value, meaning in _cells(row, known.get(instrument)):
                    cells[column] = value
                    said.setdefault(column, meaning)
                if instrument in asked_in:
                    column = f"ses-{row['session']}_language"
                    cells[column] = asked_in[instrument]
                    text = f"Language in which it was asked in session {row['session']}"
                    said.setdefault(column, {"Description": text})
    for instrument, rows in tables.items():
        _write(out / "phenotype", instrument, rows, columns[instrument], known)


def _languages(session: Session) -> dict[str, str]:
    """Return instrument → language in which a session asked it, as its manifest says."""
    wordings = session.manifest.get("wordings") or []
    return {str(each["instrument"]): str(each["language"]) for each in wordings}


def _cells(row: Mapping[str, str], instrument: Instrument | None) -> Iterable[tuple[str, str, Any]]:
    """Yield column, value and meaning of an answer, and of the condition that it is of."""
    place = f"ses-{row['session']}"
    when = f"session {row['session']}, {row['timepoint']}"
    if row["trial"]:
        place += f"_trial-{row['trial']}"
        when += f", exposure {row['trial']}"
        text = f"Condition of exposure {row['trial']} of session {row['session']}"
        yield f"{place}_condition", row["condition"], {"Description": text}
    yield (
        f"{place}_{row['timepoint']}_{row['item']}",
        row["response"],
        _meaning(row, when, instrument),
    )


def _meaning(row: Mapping[str, str], when: str, instrument: Instrument | None) -> dict[str, Any]:
    item = instrument.item(row["item"]) if instrument else None
    if instrument is None or item is None:
        return {"Description": f"{row['item']} ({when})"}
    text = f"{item.text} ({when}); n/a: rather not say, or not asked"
    answers = item.answers
    if len(answers.labels) != len(answers.asked):
        return {"Description": text, "Minimum": answers.low, "Maximum": answers.high}
    levels = zip(map(str, answers.asked), answers.labels, strict=True)
    return {"Description": text, "Levels": dict(levels)}


def _write(
    folder: Path,
    name: str,
    rows: Mapping[str, Mapping[str, str]],
    columns: Mapping[str, dict[str, Any]],
    known: Mapping[str, Instrument],
) -> None:
    table = [(who, *(cells.get(column, "") for column in columns)) for who, cells in rows.items()]
    write_tsv(folder / f"{name}.tsv", ("participant_id", *columns), table)
    instrument = known.get(name)
    tool = {"Description": name}
    if instrument is not None:
        tool = {"Description": f"{instrument.title} ({instrument.short}). {instrument.citation}"}
    write_json(folder / f"{name}.json", {"MeasurementToolMetadata": tool, **columns})
