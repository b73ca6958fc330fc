"""`score`: from answers to scores. Needs neither a GPU nor a headset."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Json
from vrcomfort.cli.terminal import answer, warn
from vrcomfort.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(score)


def score(
    answers: Annotated[
        list[str],
        typer.Argument(
            metavar="[INSTRUMENT] FILE.csv", help="Answers: one row a person, or a row an answer."
        ),
    ],
    instrument: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.toml",
            help="The questionnaire; without it, the one whose items the file has.",
        ),
    ] = None,
    skip_incomplete: Annotated[
        bool,
        typer.Option(
            "--skip-incomplete", help="Leave out questionnaires without all answers; list them."
        ),
    ] = False,
    coded_from: Annotated[
        int | None,
        typer.Option(
            help="The number that stands for the lowest answer: 1 where 1 to 4 are 0 to 3."
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Score questionnaires: a CSV (or JSON) of scores on standard output.

    Items are found by their names, in any order; other columns are kept. Instruments are shipped
    ones (ssq, vrsq, csq_vr, nasa_tlx, sus, …) or a lab's own file, see docs/instruments.md.

    - `vrcomfort score answers.csv > scores.csv`
    - `vrcomfort score answers.csv --instrument vrsq > scores.csv`
    - `vrcomfort score answers.csv --instrument my_questionnaire.toml > scores.csv`
    - `vrcomfort score ssq answers.csv --skip-incomplete > scores.csv`
    """
    from vrcomfort.api.answers import scored_rows

    if len(answers) > 2 or (len(answers) == 2 and instrument is not None):
        raise InputError("`score` takes one file of answers; score several one after the other")
    file, name = Path(answers[-1]), answers[0] if len(answers) == 2 else instrument
    if file.is_file() and not os.access(file, os.R_OK):
        raise typer.BadParameter(f"path '{file}' is not readable")
    rows = scored_rows(file, name, skip_incomplete, coded_from, warn)
    if as_json:
        answer(rows)
        return
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    typer.echo(text.getvalue(), nl=False)
