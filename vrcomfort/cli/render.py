"""`render`, `play` and `import-trace`: pictures of a scene, at a pose or along a head trace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vrcomfort.cli.play_trace import WRITTEN, play_trace
from vrcomfort.cli.render_still import PoseText, still
from vrcomfort.cli.terminal import (
    Quiet,
    RefreshRate,
    Size,
    console,
    output_file,
    output_folder,
    output_option,
    parse_size,
    warn,
)
from vrcomfort.cli.playback import (
    open_trace,
    pick_condition,
    require_recorded_gaze,
)
from vrcomfort.errors import InputError, spare
from vrcomfort.frame import MEAN_IPD_M

SceneOption = Annotated[
    str,
    typer.Option(
        metavar="NAME|FILE.glb", help="A shipped scene, or the path of any glTF 2.0 file."
    ),
]
Out = Annotated[Path, output_option(help="Folder for the results; earlier ones are replaced.")]
ProtocolOption = Annotated[
    str | None, typer.Option(help="Protocol (file or name) that defines the condition.")
]
ConditionOption = Annotated[
    str | None,
    typer.Option(
        help="A condition of the protocol. Without one: depth of field and rotation-cancelled "
        "motion blur with their default settings."
    ),
]
PoseOption = Annotated[
    str | None,
    typer.Option(
        metavar="X,Y,Z,YAW,PITCH,ROLL",
        help="Head in the world: metres and degrees (left, up, roll to the left). "
        "Without it: standing at the scene's spawn point.",
    ),
]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(render)
    app.command()(play)
    app.command("import-trace")(import_trace)


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
