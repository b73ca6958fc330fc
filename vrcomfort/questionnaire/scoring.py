"""A file of SSQ answers in, a table of scores out."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple, TypeAlias

from vrcomfort.questionnaire.instruments import SSQ
from vrcomfort.questionnaire.ssq import score
from vrcomfort.questionnaire.tables import Sheet, read_sheets

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


class Scores(NamedTuple):
    """Scores, and the lines of the questionnaires that were left out."""

    rows: list[dict[str, Cell]]
    left_out: list[int]


def score_complete_ssq(file: Path) -> Scores:
    """Score the questionnaires of a CSV file that have all their answers, as `score_ssq` does.

    Raises
    ------
    InputError
        If a column or an answer is wrong, with line and column.
    """
    sheets = read_sheets(Path(file), allow_blank=True)
    complete = [sheet for sheet in sheets if _is_complete(sheet)]
    return Scores(
        [_scored(sheet) for sheet in complete],
        [sheet.line for sheet in sheets if not _is_complete(sheet)],
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
    return [_scored(sheet) for sheet in read_sheets(Path(file))]


def _scored(sheet: Sheet) -> dict[str, Cell]:
    scored = score(sheet.answers)
    return {**sheet.keys, **{name: getattr(scored, name, None) for name in _SCORES}}


def _is_complete(sheet: Sheet) -> bool:
    return all(sheet.answers.get(item.name) is not None for item in SSQ.items)
