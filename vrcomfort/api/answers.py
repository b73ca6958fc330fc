"""Scores of questionnaires from tables of answers."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from vrcomfort.api.outputs import Note, as_warning
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import find_instrument, guess_for_file, score_file

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.questionnaire.scoring import Cell


def score_answers(
    answers: pd.DataFrame | str | Path,
    instrument: str | Path | None = None,
    *,
    skip_incomplete: bool = False,
    coded_from: int | None = None,
    note: Note = as_warning,
) -> pd.DataFrame:
    """Score questionnaires, as `vrcomfort score` does.

    Parameters
    ----------
    answers : pandas.DataFrame, str or Path
        One row for each questionnaire, its items in columns under their names in any order; or one
        row for each answer in columns ``item`` and ``response``. A CSV file, or a data frame.
    instrument : str or Path, optional
        Name of a shipped questionnaire (``"ssq"``, ``"vrsq"``, …) or a file of your own; without
        it, the one whose items the table has.
    skip_incomplete : bool
        Leave out questionnaires without all answers, with a note that names their lines.
    coded_from : int, optional
        The number that stands for the lowest answer: 1 where 1 to 4 are 0 to 3.
    note : callable
        Takes sentences on the data; Python warnings without it.

    Returns
    -------
    pandas.DataFrame
        A row for each questionnaire in the table's order: its other columns, then for each scale
        the raw number (``nausea_raw``) and the points (``nausea``).

    Raises
    ------
    InputError
        If a column or an answer is wrong, with its line (1 is the header) and column.

    Examples
    --------
    >>> import pandas as pd, vrcomfort
    >>> from vrcomfort.questionnaire import shipped_instruments
    >>> items = [item.name for item in shipped_instruments()["ssq"].items]
    >>> answers = pd.DataFrame([[0] + [1] * 15], columns=items)
    >>> vrcomfort.score_answers(answers)[["nausea", "total"]]
       nausea  total
    0   57.24  71.06
    """
    import pandas as pd

    if not isinstance(answers, pd.DataFrame):
        file = Path(answers)
        return _frame(scored_rows(file, instrument, skip_incomplete, coded_from, note))
    with TemporaryDirectory() as folder:
        file = Path(folder) / "answers.csv"
        _whole(answers).to_csv(file, index=False)
        try:
            rows = scored_rows(
                file, instrument, skip_incomplete, coded_from,
                lambda sentence: note(sentence.replace(str(file), file.name)),
            )  # fmt: skip
        except InputError as error:
            raise error.in_file(file.name) from None
    return _frame(rows)


def _frame(rows: list[dict[str, Cell]]) -> pd.DataFrame:
    import pandas as pd

    frame = pd.DataFrame(rows)
    raw = [name for name in frame if str(name).endswith("_raw")]
    return frame.astype(dict.fromkeys(raw, "Int64"))


def _whole(answers: pd.DataFrame) -> pd.DataFrame:
    """Return whole numbers as such: in a column with blanks, pandas has them as floats."""
    floats = answers.select_dtypes("float").columns
    whole = [name for name in floats if (answers[name].dropna() % 1 == 0).all()]
    return answers.astype(dict.fromkeys(whole, "Int64"))


def scored_rows(
    file: Path,
    instrument: str | Path | None,
    skip_incomplete: bool,
    coded_from: int | None,
    note: Note,
) -> list[dict[str, Cell]]:
    """Return the rows of scores of a CSV file of answers; see `score_answers`.

    Raises
    ------
    InputError
        As `score_answers`.
    """
    if file.suffix.lower() in {".xlsx", ".json"} and file.exists():
        message = "`score` takes CSV; other files: vrcomfort import FILE --suggest --out map.toml"
        raise InputError(message, file=file)
    if file.is_dir():
        message = "this is a folder; give a CSV of it, or a whole study to vrcomfort report"
        raise InputError(message, file=file)
    asked = find_instrument(instrument) if instrument is not None else guess_for_file(file)
    rows, left_out = score_file(file, asked, skip_incomplete=skip_incomplete, coded_from=coded_from)
    if left_out:
        count, lines = len(rows) + len(left_out), ", ".join(map(str, left_out))
        note(
            f"{file}: {len(left_out)} of {count} questionnaires lack answers and were left out; "
            f"they begin in line: {lines}"
        )
    return rows
