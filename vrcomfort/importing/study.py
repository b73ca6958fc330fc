"""Writes an import as a study folder, with its provenance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from vrcomfort import __version__
from vrcomfort.errors import InputError, spare
from vrcomfort.files import sha256_of
from vrcomfort.importing.mapping import MappingFile
from vrcomfort.importing.rows import Imported
from vrcomfort.json_text import json_of
from vrcomfort.questionnaire import FOLDER
from vrcomfort.records.checksums import CHECKSUMS, replace_listed
from vrcomfort.records.disk import OWNER, make_folders, replace_text
from vrcomfort.records.exposure_rows import RatingRow, TrialRow
from vrcomfort.records.names import check_study
from vrcomfort.records.rows import Cell, csv_line
from vrcomfort.records.schema import SCHEMA_VERSION
from vrcomfort.records.session_rows import ParticipantRow, QuestionnaireRow

PROVENANCE = "import.json"
MAPPING = "mapping.toml"


def write_study(
    folder: Path, imported: Imported, mapping: MappingFile, files: Sequence[Path]
) -> list[Path]:
    """Write a study folder; return its files.

    An import that stands there already is replaced; nothing else is.

    Raises
    ------
    InputError
        If the folder holds anything that is no import, or a file that is read would be replaced.
    """
    _require_room(folder)
    check_study(folder.resolve().name)
    texts = {
        "dataset_description.json": _json(_description(imported, mapping, folder)),
        ParticipantRow.FILE: _participants(imported),
        PROVENANCE: _json(_provenance(imported, mapping, files)),
        MAPPING: mapping.text,
    }
    own = imported.instruments.values()
    texts |= {f"{FOLDER}/{each.name}.toml": each.text for each in own}
    if imported.responses:
        texts[QuestionnaireRow.FILE] = _questionnaires(imported)
    if imported.ratings:
        texts[RatingRow.FILE] = _ratings(imported)
    if imported.ends:
        texts[TrialRow.FILE] = _trials(imported)
    spare([mapping.file, *files], [folder / name for name in texts])
    make_folders(folder, folder, OWNER)
    if own:
        make_folders(folder, folder / FOLDER, OWNER)
    for stale in {*_ALL, CHECKSUMS} - texts.keys():
        (folder / stale).unlink(missing_ok=True)
    for name, text in texts.items():
        if "/" in name:
            replace_text(folder / name, text, OWNER)
        else:
            replace_listed(folder / name, text, OWNER)
    return [folder / name for name in texts]


_PACKED = Path(RatingRow.FILE).with_suffix(".parquet").name  # that of `vrcomfort pack`
_ALL = frozenset((
    "dataset_description.json", ParticipantRow.FILE, PROVENANCE, MAPPING,
    QuestionnaireRow.FILE, RatingRow.FILE, TrialRow.FILE, _PACKED,
))  # fmt: skip


def _require_room(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise InputError("is a file; the output needs a folder", file=folder)
    there = {each.name for each in folder.iterdir()} if folder.exists() else set()
    if there and PROVENANCE not in there:
        message = "holds files other than an import; choose a new output folder"
        raise InputError(message, file=folder)
    others = sorted(there - _ALL - {FOLDER, CHECKSUMS})
    if others:
        message = f"holds {others[0]} beside an import"
        raise InputError(f"{message}; choose another output folder, or move it away", file=folder)


def _json(content: object) -> str:
    return json_of(content) + "\n"


def _description(imported: Imported, mapping: MappingFile, folder: Path) -> dict[str, object]:
    labels = mapping.mapping.condition_labels
    named = {name: labels[name] for name in labels if name in imported.conditions}
    conditions = {**named, **{c: c for c in imported.conditions if c not in named}}
    instruments = dict.fromkeys(name for name, _ in imported.responses)
    instruments |= dict.fromkeys(rating.instrument for rating in imported.ratings)
    return {
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "schema_version": SCHEMA_VERSION,
        "name": mapping.mapping.name or folder.resolve().name,
        "description": f"Answers imported with vrcomfort; where from, {PROVENANCE} says.",
        "conditions": conditions,
        "levels": mapping.mapping.condition_levels,
        "instruments": list(instruments),
        "scores_without_answers": imported.scores,
        "not_asked": {name: list(items) for name, items in imported.not_asked.items()},
    }


def _provenance(
    imported: Imported, mapping: MappingFile, files: Sequence[Path]
) -> dict[str, object]:
    return {
        "schema_version": SCHEMA_VERSION,
        "imported_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "vrcomfort": __version__,
        "mapping": {"file": mapping.file.name, "sha256": mapping.sha256, "copy": MAPPING},
        "sources": [
            {
                "file": file.name,
                "bytes": file.stat().st_size,
                "sha256": sha256_of(file),
            }
            for file in files
        ],
        "doubts": [doubt.model_dump() for doubt in mapping.mapping.doubts],
        "notes": imported.notes,
    }


def _table(columns: Iterable[str], rows: Iterable[Iterable[Cell]]) -> str:
    lines = [csv_line(columns)]
    lines += [csv_line(row) for row in rows]
    return "".join(lines)


def _questionnaires(imported: Imported) -> str:
    """Return the answers; the scene, which sessions have in trials.csv, is the last column."""
    return _table(
        (*QuestionnaireRow.columns(), "scene"),
        (
            (m.participant, m.session, m.period, m.block, m.trial, m.condition, m.timepoint,
             instrument, item, answer, None, None, order, None, None, m.scene)
            for (instrument, m), response in imported.responses.items()
            for order, (item, answer) in enumerate(response.answers.items(), start=1)
        ),
    )  # fmt: skip


_UNSAID = {"status": "enrolled"}


def _participants(imported: Imported) -> str:
    own = ParticipantRow.columns()
    extra = [name for name in imported.covariates if name not in own]
    rows = [
        (name, *(known.get(each, "") or _UNSAID.get(each, "") for each in (*own[1:], *extra)))
        for name, known in imported.participants.items()
    ]
    return _table((*own, *extra), rows)


def _ratings(imported: Imported) -> str:
    rows = [
        (m.participant, m.session, m.trial, m.condition, onset_s, None, instrument, response,
         int(response is None), None)
        for m, instrument, onset_s, response in imported.ratings
    ]  # fmt: skip
    return _table(RatingRow.columns(), rows)


def _trials(imported: Imported) -> str:
    """Return the exposures whose ends are known.

    Who left one exposure and has others has left that session alone, not the study.
    """
    met = Counter(end.administration.participant for end in imported.ends)
    rows: list[list[Cell]] = []
    for m, end_s, left in imported.ends:
        why = ("participant_session" if met[m.participant] > 1 else "participant") if left else None
        known: dict[str, Cell] = {
            "participant": m.participant, "session": m.session, "period": m.period,
            "block": m.block, "trial": m.trial, "condition": m.condition, "scene": m.scene,
            "start_s": 0.0, "end_s": end_s, "status": "withdrawn" if left else "completed",
            "abort_code": why,
        }  # fmt: skip
        rows.append([known.get(name) for name in TrialRow.columns()])
    return _table(TrialRow.columns(), rows)
