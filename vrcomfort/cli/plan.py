"""`plan`: what each condition draws and costs, before anybody puts a headset on."""

from __future__ import annotations

from typing import Annotated

import typer

from vrcomfort.cli.options import Json, ProtocolArgument, Size, parse_size
from vrcomfort.cli.terminal import answer, progress_bar
from vrcomfort.protocol import load_protocol


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(plan)


def plan(
    protocol: ProtocolArgument,
    size: Size = "1832x1920",
    draw: Annotated[
        bool,
        typer.Option("--draw/--no-draw", help="Draw a frame of each, to count bytes and draws."),
    ] = True,
    as_json: Json = False,
) -> None:
    """Show which passes each condition needs in each scene and why, and what it costs.

    Draws a frame of each, which without a GPU takes some seconds at --size. GPU memory is what is
    allocated here, for both eyes at --size. Cost and error are those shipped for the condition's
    settings, where they have been measured.

    - `vrcomfort plan carnegie_2015`
    - `vrcomfort plan my_study.toml --size 2064x2208 --json`
    """
    from vrcomfort.cli import plan_table

    study = load_protocol(protocol)
    with progress_bar("planning", None, quiet=as_json):
        found = plan_table.planned(study, parse_size(size), draw=draw)
    if as_json:
        answer(found.as_data())
    else:
        plan_table.show(found, study)
