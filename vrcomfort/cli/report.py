"""`report` and `score`: from answers to numbers. Neither needs a GPU or a headset."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.terminal import Json, Quiet, answer, console, output_folder, output_option, warn
from vrcomfort.errors import InputError
from vrcomfort.questionnaire import score_ssq


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(report)
    app.command()(score)


def report(
    study: Annotated[
        Path,
        typer.Argument(
            metavar="STUDY",
            help="A study folder, any folder that holds questionnaires.csv files, or one file.",
        ),
    ],
    out: Annotated[Path, output_option(help="Folder for the report.")],
    plan: Annotated[
        Path | None, typer.Option(help="Analysis plan (TOML); without it, the protocol's own.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Analyse a study: a page, the numbers as JSON and CSV, and figures as SVG.

    - `vrcomfort report out/demo/study --out out/demo/report`
    - `vrcomfort report answers/questionnaires.csv --plan my_plan.toml --out report`
    """
    from vrcomfort.report import build_report

    summary = build_report(study, plan=plan, out=output_folder(out))
    for warning in summary.warnings:
        warn(warning)
    if as_json:
        typer.echo((out / "results.json").read_text(encoding="utf-8"))
    else:
        console(quiet).print(f"Report: {out / 'index.html'}")


def score(
    instrument: Annotated[str, typer.Argument(metavar="ssq", help="The questionnaire.")],
    file: Annotated[Path, typer.Argument(metavar="FILE.csv", help="Answers: one row a person.")],
    as_json: Json = False,
) -> None:
    """Score questionnaires: a CSV (or JSON) of scores on standard output.

    Items are found by their names, in any order; other columns are kept.

    - `vrcomfort score ssq answers.csv > scores.csv`
    """
    if instrument != "ssq":
        raise InputError(f"there is no scorer for {instrument!r}; the one there is: ssq")
    rows = score_ssq(file)
    if as_json:
        answer(rows)
        return
    text = io.StringIO()
    writer = csv.DictWriter(text, fieldnames=list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    typer.echo(text.getvalue(), nl=False)
