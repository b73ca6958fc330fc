"""`anonymise`: a copy of a study that can be handed on."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Quiet, output_option
from vrcomfort.cli.terminal import console, warn


class DateChoice(StrEnum):
    """What becomes of dates."""

    SHIFT = "shift"
    REMOVE = "remove"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(anonymise)


def anonymise(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="The study folder.")],
    out: Annotated[Path, output_option("--out", help="A new folder for the anonymous copy.")],
    dates: Annotated[
        DateChoice,
        typer.Option(help="shift: times between sessions stay; remove: they go, too."),
    ] = DateChoice.SHIFT,
    keep_motion: Annotated[
        bool, typer.Option("--keep-motion", help="Keep head and hands: they identify people.")
    ] = False,
    keep_gaze: Annotated[
        bool, typer.Option("--keep-gaze", help="Keep the gaze: it identifies people.")
    ] = False,
    key: Annotated[
        Path | None,
        output_option("--key", help="Write old and new names here, outside of both folders."),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, help="Of the new names, written nowhere; who knows it can undo them."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Copy a study with new ids, other dates, and without notes, head motion and gaze.

    The study itself is not changed. What was done stands in the copy's anonymised.json.

    - `vrcomfort anonymise my_study --out shared`
    - `vrcomfort anonymise my_study --out shared --key ../keys/my_study.csv`
    - `vrcomfort anonymise my_study --out shared --keep-motion --dates remove`
    """
    from vrcomfort.exchange.anonymising import RECORD, Wishes
    from vrcomfort.exchange.anonymising import anonymise as copy

    record = copy(study, out, Wishes(seed, dates.value, keep_motion, keep_gaze, key))
    still = record["still_there"]
    for what in still["people_are_recognised_by"]:
        warn(f"{what} is kept: people can be recognised by it")
    smallest = still["smallest_group_with_the_same_covariates"]
    if smallest is not None:
        names = ", ".join(still["covariates"])
        warn(f"covariates are kept ({names}): the smallest group alike in them is of {smallest}")
    for name in record["events_not_known"]:
        warn(f"details of events `{name}` are left out: this version does not know them")
    console(quiet).print(f"{out}: what was done stands in {out / RECORD}")
