"""Practice as BIDS' table of behaviour: a row for each exposure, which is no run."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.csv_table import CsvTable
from vrcomfort.exchange.bids.files import write_json, write_tsv
from vrcomfort.exchange.meanings import MEANINGS
from vrcomfort.records.exposure_rows import PracticeRow

_OF_THE_NAME = ("participant", "session")


def write_practice(source: Path, folder: Path, whose: str, task: str) -> None:
    """Write the practice of one session, if it had any.

    Parameters
    ----------
    source, folder
        Of the session in the study, and in the dataset.
    whose
        Beginning of its files' names.
    task
        Label of what the exposures are; practice is told from it by its own.

    Raises
    ------
    InputError
        If the table is damaged.
    """
    file = source / PracticeRow.FILE
    rows = list(CsvTable.read(file, appended=True).dicts()) if file.exists() else []
    if not rows:
        return
    label = f"{task}practice"
    columns = [name for name in PracticeRow.columns() if name not in _OF_THE_NAME]
    stem = folder / "beh" / f"{whose}_task-{label}_beh"
    table = ([row.get(name, "") for name in columns] for row in rows)
    write_tsv(stem.with_suffix(".tsv"), columns, table)
    write_json(
        stem.with_suffix(".json"),
        {
            "TaskName": label,
            "TaskDescription": "Practice before the exposures of a session, of which it is none",
            **{name: _described(name) for name in columns},
        },
    )


def _described(column: str) -> dict[str, str]:
    return {
        "Description": MEANINGS[column],
        **({"Units": "s"} if column.endswith("_s") else {}),
    }
