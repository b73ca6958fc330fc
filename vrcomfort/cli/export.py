"""`export`: a study in a format that other programs read."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Quiet, output_option
from vrcomfort.cli.terminal import console, warn


class Format(StrEnum):
    """What a study can be exported as."""

    BIDS = "bids"
    PSYCH_DS = "psych-ds"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(export)


def export(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="The study folder.")],
    format_: Annotated[
        Format,
        typer.Option("--format", help="bids: BIDS 1.11.1; psych-ds: Psych-DS 1.5.1, tables alone."),
    ],
    out: Annotated[Path, output_option("--out", help="A new folder for the dataset.")],
    quiet: Quiet = False,
) -> None:
    """Write a study as a dataset of BIDS (motion, gaze, events, answers) or Psych-DS (tables).

    Head motion and gaze identify people, and dates are the study's: anonymise it first, where the
    dataset is to be shared.

    - `vrcomfort export my_study --format bids --out my_study_bids`
    - `vrcomfort export my_study --format psych-ds --out my_study_psych_ds`
    """
    from vrcomfort.exchange.bids import export_bids
    from vrcomfort.exchange.psych_ds import export_psych_ds

    write = export_bids if format_ is Format.BIDS else export_psych_ds
    for sentence in write(study, out):
        warn(f"left out: {sentence}")
    console(quiet).print(f"{out}: a dataset in {format_.value}; its README.md says what is where")
