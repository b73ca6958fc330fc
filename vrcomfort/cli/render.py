"""`render`: a stereo picture of a scene at a pose."""

from __future__ import annotations

from typing import Annotated

import typer

from vrcomfort.cli.condition_choice import pick_condition
from vrcomfort.cli.options import (
    ConditionOption,
    Out,
    ProtocolOption,
    Quiet,
    SceneOption,
    Size,
    parse_size,
)
from vrcomfort.cli.render_still import PoseText, still
from vrcomfort.cli.terminal import console, output_folder
from vrcomfort.frame import MEAN_IPD_M

PoseOption = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,Z,YAW,PITCH,ROLL",
        help="Head in the world: metres and degrees (left, up, roll to the left). "
        "Without it: standing at the scene's spawn point.",
    ),
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(render)


def render(
    scene: SceneOption,
    out: Out,
    pose: PoseOption = None,
    previous_pose: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z,YAW,PITCH,ROLL",
            help="Head one frame (1/90 s) earlier; without it, at rest.",
        ),
    ] = None,
    protocol: ProtocolOption = None,
    condition: ConditionOption = None,
    size: Size = "640x800",
    reference: Annotated[
        int,
        typer.Option(
            metavar="N",
            help="Also draw the ground truth with N lens and shutter samples, and the error.",
            min=0,
        ),
    ] = 0,
    quiet: Quiet = False,
) -> None:
    """Draw one stereo picture with its linear light, depth and settings.

    Writes left.png, right.png, side_by_side.png, left.npz, right.npz and meta.json. Errors
    are those that `vrcomfort tradeoff` takes, in meta.json and on the terminal.

    - `vrcomfort render --scene temple --out picture`
    - `vrcomfort render --scene mountain --pose 0,1.6,0,30,-5,0 --reference 256 --out picture`
    """
    study, shown = pick_condition(protocol, condition)
    poses = PoseText("--pose", pose), PoseText("--previous-pose", previous_pose)
    picture = still(
        scene,
        shown,
        poses=poses,
        size_px=parse_size(size),
        ipd_m=study.headset.ipd_m if study else MEAN_IPD_M,
        out=output_folder(out),
        reference_samples=reference,
        quiet=quiet,
    )
    console(quiet).print(f"Picture: {picture}")
