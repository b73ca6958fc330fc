"""`score`: from answers to scores. Needs neither a GPU nor a headset."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Json
from vrcomfort.cli.terminal import answer, warn
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import score_complete_ssq, score_ssq
from vrcomfort.questionnaire.scoring import Cell


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(score)


def score(
    instrument: Annotated[str, typer.Argument(metavar="ssq", help="The questionnaire.")],
    file: Annotated[Path, typer.Argument(metavar="FILE.csv", help="Answers: one row a person.")],
    skip_incomplete: Annotated[
        bool,
        typer.Option(
            "--skip-incomplete", help="Leave out questionnaires without all answers; list them."
        ),
    ] = False,
    as_json: Json = False,
) -> None:
    """Score questionnaires: a CSV (or JSON) of scores on standard output.

    Items are found by their names, in any order; other columns are kept.

    - `vrcomfort score ssq answers.csv > scores.csv`
    - `vrcomfort score ssq answers.csv --skip-incomplete > scores.csv`
    """
    if instrument != "ssq":
        raise InputError(f"there is no scorer for {instrument!r}; the one there is: ssq")
    rows = _complete(file) if skip_incomplete else score_ssq(file)
    if as_json:
        answer(rows)
        return
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    typer.echo(text.getvalue(), nl=False)


def _complete(file: Path) -> list[dict[str, Cell]]:
    """Return the scores of what is complete, and name the lines of the rest."""
    rows, left_out = score_complete_ssq(file)
    if left_out:
        count, lines = len(rows) + len(left_out), ", ".join(map(str, left_out))
        warn(
            f"{file}: {len(left_out)} of {count} questionnaires lack answers and were left out; "
            f"they begin in line: {lines}"
        )
    return rows
