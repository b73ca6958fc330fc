"""`render`: a stereo picture of a scene at a pose."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from vrcomfort.api.outputs import output_folder
from vrcomfort.api.views import EYES, as_pose, render_views
from vrcomfort.cli.options import (
    ConditionOption,
    Json,
    Out,
    ProtocolOption,
    Quiet,
    SceneOption,
    Size,
    parse_size,
    pick_condition,
)
from vrcomfort.cli.terminal import conclude, console, progress_bar, warn
from vrcomfort.frame import MEAN_IPD_M
from vrcomfort.geometry import Pose
from vrcomfort.protocol.changed import changed, idle_settings

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
            help="Head pose one frame (1/90 s) earlier; by default at rest.",
        ),
    ] = None,
    trace: Annotated[
        Path | None,
        typer.Option(help="Instead of a pose: a moment of a head trace (CSV), with its hands."),
    ] = None,
    at_s: Annotated[
        float | None,
        typer.Option(
            metavar="S",
            help="Time in the trace and in the scene's animations, in s. Without it, "
            "nothing moves but the head.",
        ),
    ] = None,
    protocol: ProtocolOption = None,
    condition: ConditionOption = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="SETTING=VALUE",
            help="A setting of the condition, such as vignette.open_deg=60, or motion_blur=none; "
            "once for each.",
        ),
    ] = None,
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
    as_json: Json = False,
) -> None:
    """Draw one stereo picture with its linear light, depth and settings.

    Writes left.png, right.png, side_by_side.png, left.npz, right.npz and meta.json; with motion
    blur, pictures of the velocity buffer, too. Errors are those that `vrcomfort tradeoff` takes,
    in meta.json and on the terminal.

    - `vrcomfort render --scene temple --out picture`
    - `vrcomfort render --scene mountain --pose 0,1.6,0,30,-5,0 --reference 256 --out picture`
    - `vrcomfort render --scene temple --set motion_blur=none --set vignette.open_deg=60 --out v`
    - `vrcomfort render --scene depths --trace hands.csv --at-s 20 --out hands`
    """
    study, shown = pick_condition(protocol, condition)
    shown = changed(shown, "--set", settings or ())
    for note in idle_settings(shown, settings or ()):
        warn(f"--set {note}")
    folder = output_folder(out)
    views = render_views(
        scene,
        shown.in_scene(scene),
        pose=parse_pose("--pose", pose),
        previous_pose=parse_pose("--previous-pose", previous_pose),
        trace=trace,
        at_s=at_s,
        size_px=parse_size(size),
        ipd_m=study.headset.ipd_m if study else MEAN_IPD_M,
        reference_samples=reference,
        note=warn,
        progress=partial(progress_bar, quiet=quiet or as_json),
    )
    picture = views.write(folder)
    for name in EYES if reference else ():
        words = _in_words(views.meta["reference"][name], reference)
        console(quiet or as_json).print(f"{name} eye: {words}")
    if full_px := views.meta.get("velocity_full_px"):
        words = f"direction as hue, fullest from {full_px:g} px per frame on"
        pictures = "left_velocity.png and right_velocity.png"
        console(quiet or as_json).print(f"Velocities: {pictures} ({words})")
    facts = {"picture": str(picture), **views.meta}
    conclude(f"Picture: {picture}", facts, quiet=quiet, as_json=as_json)


def parse_pose(option: str, text: str | None) -> Pose | None:
    """Read ``X,Y,Z,YAW,PITCH,ROLL`` in metres and degrees; None of None.

    Raises
    ------
    InputError
        If it is not six numbers, or too far from the scene's origin.
    """
    if text is None:
        return None
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    return as_pose(numbers, f"{option} {text!r}")


def _in_words(found: dict[str, Any], samples: int) -> str:
    """Return the error of an eye, its certainty, and the compared pixels."""
    psnr = "none" if found["psnr_db"] is None else f"{found['psnr_db']:.1f} dB"
    enough = "the error counts" if found["counts"] else "more samples are needed to count"
    return (
        f"PSNR {psnr}, RMS {found['rms']:.2g}, FLIP {found['flip']:.2g} against {samples} samples "
        f"of brute force, whose own RMS is {found['reference_rms']:.2g} ({enough}); "
        f"{found['compared_px']} pixels were compared; a margin of {found['margin_px']} px and "
        f"{found['left_out_px']} pixels that are too bright or unsure were left out"
    )
