"""`play`: pictures along a head trace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.condition_choice import pick_condition
from vrcomfort.cli.gaze_check import require_recorded_gaze
from vrcomfort.cli.options import (
    ConditionOption,
    Out,
    ProtocolOption,
    Quiet,
    RefreshRate,
    SceneOption,
    Size,
    parse_size,
)
from vrcomfort.cli.outputs import output_folder
from vrcomfort.cli.play_trace import WRITTEN, play_trace
from vrcomfort.cli.playback import open_trace
from vrcomfort.cli.terminal import console
from vrcomfort.errors import spare
from vrcomfort.frame import MEAN_IPD_M


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(play)


def play(
    trace: Annotated[Path, typer.Argument(metavar="TRACE", help="Head trace or frames.csv.")],
    scene: SceneOption,
    out: Out,
    protocol: ProtocolOption = None,
    condition: ConditionOption = None,
    trial: Annotated[
        str | None, typer.Option(help="Only this trial of a recorded frames.csv.")
    ] = None,
    gaze: Annotated[
        Path | None,
        typer.Option(help="Where the eyes looked (gaze.csv); the one beside a frames.csv is used."),
    ] = None,
    size: Size = "640x800",
    frames: Annotated[
        int | None,
        typer.Option(help="So many frames (a short trace loops); without it, all once.", min=1),
    ] = None,
    refresh_hz: RefreshRate = None,
    video: Annotated[bool, typer.Option(help="Also write video.mp4.")] = True,
    quiet: Quiet = False,
) -> None:
    """Play a head trace through a scene: one side-by-side picture per frame, and frames.csv.

    - `vrcomfort play walk.csv --scene temple --frames 300 --size 320x400 --out played`
    - `vrcomfort play my_study/sub-P01/ses-1/frames.csv --trial 1 --scene temple --out replay`
    """
    study, shown = pick_condition(protocol, condition)
    played = open_trace(trace, trial=trial, gaze=gaze)
    require_recorded_gaze([shown], played)
    spare([trace, gaze], [out / name for name in WRITTEN])
    count = play_trace(
        played,
        scene,
        shown,
        size_px=parse_size(size),
        ipd_m=study.headset.ipd_m if study else MEAN_IPD_M,
        frames=frames,
        refresh_hz=refresh_hz,
        video=video,
        out=output_folder(out),
        quiet=quiet,
    )
    console(quiet).print(f"{count} stereo frames: {out}")
