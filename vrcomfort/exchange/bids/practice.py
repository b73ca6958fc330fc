"""Practice as BIDS' table of behaviour: a row for each exposure, which is no run."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.exchange.bids.files import write_json, write_tsv
from vrcomfort.records.exposure_rows import PracticeRow
from vrcomfort.records.reader import Session
from vrcomfort.records.rows import Column, declared
from vrcomfort.records.schema import full_meaning

_OF_THE_NAME = ("participant", "session")


def write_practice(session: Session, folder: Path, whose: str, task: str) -> None:
    """Write the practice of one session, if it had any.

    Parameters
    ----------
    folder
        Of the session in the dataset.
    whose
        Beginning of its files' names.
    task
        Label of what the exposures are; practice is told from it by its own.

    Raises
    ------
    InputError
        If the table is damaged.
    """
    rows = list(session.text_rows(PracticeRow))
    if not rows:
        return
    label = f"{task}practice"
    described = [each for each in declared(PracticeRow) if each.name not in _OF_THE_NAME]
    columns = [each.name for each in described]
    stem = folder / "beh" / f"{whose}_task-{label}_beh"
    table = ([row.get(name, "") for name in columns] for row in rows)
    write_tsv(stem.with_suffix(".tsv"), columns, table)
    write_json(
        stem.with_suffix(".json"),
        {
            "TaskName": label,
            "TaskDescription": "Practice before the exposures of a session, of which it is none",
            **{each.name: _described(each) for each in described},
        },
    )


def _described(column: Column) -> dict[str, str]:
    return {
        "Description": full_meaning(column),
        **({"Units": column.unit} if column.unit else {}),
    }
