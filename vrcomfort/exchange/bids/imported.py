"""An import as a BIDS dataset: participants, questionnaires, ratings.

Beside `phenotype/`, each participant has a table of behaviour with the answers and ratings as they
were imported, a row each: BIDS wants a folder for everybody who is in ``participants.tsv``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vrcomfort import __version__
from vrcomfort.exchange.bids.dataset import (
    BIDS_VERSION,
    column_of_participants,
    described_column,
    meaning_of_answer,
    write_instrument,
)
from vrcomfort.exchange.bids.runs import write_json, write_tsv
from vrcomfort.exchange.imports import Import, labels_of, place_of
from vrcomfort.plurals import counted
from vrcomfort.questionnaire import instruments_in, shipped_instruments
from vrcomfort.records.exposure_rows import RatingRow
from vrcomfort.records.rows import declared
from vrcomfort.records.session_rows import ParticipantRow, QuestionnaireRow

_README = """# {name}

Answers of another program's study, imported with vrcomfort and exported as BIDS {bids}.

- `phenotype/`: a table for each questionnaire, a row for each participant, a column for an answer.
- `sub-*/beh/*_beh.tsv`: the same answers, and the ratings, a row each.
"""
_COLUMNS = (
    "onset_s", "session", "period", "block", "trial", "condition", "scene", "timepoint",
    "instrument", "item", "response",
)  # fmt: skip


def write_import(source: Import, out: Path, said: str) -> list[str]:
    """Write an import as a dataset; return a sentence for each omission.

    Parameters
    ----------
    said
        What the README says of faults that were accepted.

    Raises
    ------
    InputError
        If a table is damaged.
    """
    name = source.name
    made = [{"Name": "vrcomfort", "Version": __version__}]
    content = {"Name": name, "BIDSVersion": BIDS_VERSION, "DatasetType": "raw", "GeneratedBy": made}
    write_json(out / "dataset_description.json", content)
    readme = _README.format(name=name, bids=BIDS_VERSION) + said
    (out / "README.md").write_text(readme, encoding="utf-8")
    rows: dict[str, list[dict[str, str]]] = {}
    for row_type in (QuestionnaireRow, RatingRow):
        for row in source.table(row_type).dicts():
            rows.setdefault(row["participant"], []).append(row)
    labels = labels_of([who for who in source.names if who in rows])
    _write_participants(source, out, labels)
    _write_answers(source, out, labels)
    task = re.sub("[^A-Za-z0-9]", "", name) or "comfort"
    for who, label in labels.items():
        _write_rows(out, label, task, rows[who])
    nobody = len(source.names) - len(labels)
    return [f"{counted(nobody, 'participants')} without an answer"] if nobody else []


def _write_participants(source: Import, out: Path, labels: Mapping[str, str]) -> None:
    others = source.covariates()
    known = {row["participant"]: row for row in source.people}
    own = ["participant"] if any(who != label for who, label in labels.items()) else []
    columns = (*own, *others)
    table = [
        (f"sub-{label}", *({"participant": who, **known.get(who, {})}.get(c, "") for c in columns))
        for who, label in labels.items()
    ]
    write_tsv(out / "participants.tsv", ("participant_id", *columns), table)
    said = {each.name: described_column(each) for each in declared(ParticipantRow)}
    origin = "in the files that were imported"
    described = {name: column_of_participants(name, origin) for name in others}
    write_json(out / "participants.json", {**{name: said[name] for name in own}, **described})


def _write_answers(source: Import, out: Path, labels: Mapping[str, str]) -> None:
    known = {**shipped_instruments(), **instruments_in([source.folder])}
    tables: dict[str, dict[str, dict[str, str]]] = {}
    columns: dict[str, dict[str, dict[str, Any]]] = {}
    for row in source.table(QuestionnaireRow).dicts():
        name = row["instrument"]
        places = list(place_of(row))
        column = "_".join(
            [*(f"{key}-{_plain(value)}" for key, value in places), row["timepoint"], row["item"]]
        )
        when = ", ".join([*(f"{key} {value}" for key, value in places), row["timepoint"]])
        whose = f"sub-{labels[row['participant']]}"
        tables.setdefault(name, {}).setdefault(whose, {})[column] = row["response"]
        said = columns.setdefault(name, {})
        said.setdefault(column, meaning_of_answer(row, when, known.get(name)))
    for name, rows in tables.items():
        write_instrument(out / "phenotype", name, rows, columns[name], known)


def _plain(value: str) -> str:
    return re.sub("[^A-Za-z0-9]+", "-", value)


def _write_rows(out: Path, label: str, task: str, rows: list[dict[str, str]]) -> None:
    """Write the answers and ratings of one participant."""
    stem = out / f"sub-{label}" / "beh" / f"sub-{label}_task-{task}_beh"
    columns = [name for name in _COLUMNS if any(row.get(name) for row in rows)]
    write_tsv(
        stem.with_suffix(".tsv"), columns, ([row.get(c, "") for c in columns] for row in rows)
    )
    known = {each.name: each for each in (*declared(RatingRow), *declared(QuestionnaireRow))}
    said = {name: described_column(known[name]) for name in columns if name in known}
    scene = {"scene": {"Description": "What was shown"}} if "scene" in columns else {}
    text = "Answers and ratings, a row each; where there is no onset, of a questionnaire"
    write_json(
        stem.with_suffix(".json"),
        {"TaskName": task, "TaskDescription": text, **said, **scene},
    )
