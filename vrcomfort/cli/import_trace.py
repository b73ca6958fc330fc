"""`import-trace`: a head trace out of the log of another program."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.options import Quiet, output_option
from vrcomfort.cli.outputs import output_file
from vrcomfort.cli.terminal import console, warn
from vrcomfort.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("import-trace")(import_trace)


def import_trace(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A log that another program wrote.")],
    out: Annotated[Path, output_option(help="The trace to write (CSV).")],
    format: Annotated[str, typer.Option(help="What wrote it: unity-euler.")] = "unity-euler",  # noqa: A002
    quiet: Quiet = False,
) -> None:
    """Turn another program's head log into a trace.

    `unity-euler` is text: a first line `Time x y z alpha beta gamma`, then one row for each sample,
    with commas between its seven numbers and points as decimals, such as `0.5,0,1.6,0,10,90,0`.

    - Time in seconds, each later than the one before.
    - x, y, z: the head's position in metres, in Unity's left-handed frame (x right, y up,
      z forward).
    - alpha, beta, gamma: Unity's Euler angles in degrees about x (positive looks down), y (positive
      turns right) and z (positive tips to the left), as eulerAngles gives them: it turns about z
      first, then x, then y.

    The trace has OpenXR's right-handed frame (z backwards) and quaternions.

    - `vrcomfort import-trace log.txt --format unity-euler --out trace.csv`
    """
    from vrcomfort.traces.trace import import_trace as read
    from vrcomfort.traces.trace import write_trace

    if format != "unity-euler":
        raise InputError(f"--format {format!r} is not known; the one there is: unity-euler")
    trace = read(file, format="unity-euler")
    for warning in trace.warnings:
        warn(warning)
    write_trace(trace, output_file(out, file))
    console(quiet).print(f"{len(trace)} samples over {trace.duration_s:.1f} s: {out}")
