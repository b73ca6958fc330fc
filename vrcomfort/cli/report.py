"""`report`: from answers to numbers and figures. Needs neither a GPU nor a headset."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Json, Quiet, output_option
from vrcomfort.cli.outputs import output_folder
from vrcomfort.cli.terminal import console, progress_bar, warn


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(report)


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
    instrument: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.toml",
            help="Whose answers to report; without it, the plan's, or what was asked most.",
        ),
    ] = None,
    simulated: Annotated[
        bool,
        typer.Option(
            "--simulated", help="Of a study with both, the simulated participants, not the real."
        ),
    ] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Analyse a study: a page, the numbers as JSON and CSV, and figures as SVG.

    - `vrcomfort report out/demo/study --out out/demo/report`
    - `vrcomfort report answers/questionnaires.csv --plan my_plan.toml --out report`
    """
    from vrcomfort.report import build_report

    with progress_bar("analysing", None, quiet=quiet):
        summary = build_report(
            study,
            plan=plan,
            instrument=instrument,
            out=output_folder(out),
            simulated=simulated or None,
        )
    for warning in summary.warnings:
        warn(warning)
    if as_json:
        typer.echo((out / "results.json").read_text(encoding="utf-8"))
    else:
        console(quiet).print(f"Report: {out / 'index.html'}")
