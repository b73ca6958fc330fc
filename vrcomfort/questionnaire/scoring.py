"""A file of SSQ answers in, a table of scores out."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from vrcomfort.questionnaire.ssq import score
from vrcomfort.questionnaire.tables import read_sheets

Cell: TypeAlias = str | int | float | None

_SCORES = (
    "nausea_raw",
    "oculomotor_raw",
    "disorientation_raw",
    "total_raw",
    "nausea",
    "oculomotor",
    "disorientation",
    "total",
)


def score_ssq(file: Path) -> list[dict[str, Cell]]:
    """Score every questionnaire of a CSV file (wide or long; see `read_sheets`).

    Returns
    -------
    list of dict
        One row per questionnaire in the file's order: the file's other columns (long files: the
        columns of `LONG_KEYS`), then raw sums (integers) and scores. All blank (None) where a
        long file lacks an answer.

    Raises
    ------
    InputError
        If a column or an answer is wrong, with line and column.
    """
    rows: list[dict[str, Cell]] = []
    for sheet in read_sheets(Path(file)):
        scored = score(sheet.answers)
        scores: dict[str, Cell] = {name: getattr(scored, name, None) for name in _SCORES}
        rows.append({**sheet.keys, **scores})
    return rows
