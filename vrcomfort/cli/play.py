"""`play`: a head trace through a scene, or a recorded session drawn again."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vrcomfort.api.outputs import output_file, output_folder
from vrcomfort.api.playback import open_trace, require_recorded_gaze
from vrcomfort.api.rendering import make_renderer
from vrcomfort.cli.options import (
    ConditionOption,
    Json,
    ProtocolOption,
    Quiet,
    RefreshRate,
    output_option,
    parse_size,
    pick_condition,
)
from vrcomfort.cli.play_session import ReplayOptions, play_session
from vrcomfort.cli.terminal import conclude, progress_bar, warn
from vrcomfort.errors import InputError, spare
from vrcomfort.frame import MEAN_IPD_M
from vrcomfort.protocol import Condition
from vrcomfort.protocol.quality_levels import Quality

if TYPE_CHECKING:
    from vrcomfort.records import Row
    from vrcomfort.traces.trace import Trace


# A head trace through a scene: pictures, frame log and video.


LOG, SETTINGS = WRITTEN = ("frames.csv", "meta.json")
"""Files in the folder of results, beside the pictures."""


def play_trace(
    trace: Trace,
    scene_source: str,
    condition: Condition,
    *,
    beside: Condition | None,
    size_px: tuple[int, int],
    ipd_m: float,
    frames: int | None,
    refresh_hz: float | None,
    video: Path | None,
    out: Path | None,
    quiet: bool,
) -> int:
    """Render a trace; return the number of frames.

    Pictures, ``frames.csv`` and ``meta.json`` go into `out`, the film to `video`.

    A trace without avatar poses is anchored at the scene's spawn point. Images are of both eyes;
    with another condition `beside`, of the left eye under each.
    """
    from vrcomfort.headset.playback import PlaybackHeadset
    from vrcomfort.render.pipeline import StereoRenderer
    from vrcomfort.scene.load import load_scene

    scene = load_scene(scene_source)
    for warning in scene.warnings:
        warn(warning)
    headset = PlaybackHeadset(
        trace,
        image_size_px=size_px,
        refresh_hz=refresh_hz,
        ipd_m=ipd_m,
        spawn=scene.spawn,
        loop=frames is not None,
        max_frames=frames,
    )
    renderer = make_renderer(size_px)
    renderer.begin(scene, condition)
    second = None
    if beside is not None:
        second = StereoRenderer(renderer.ctx, size_px)
        second.begin(scene, beside)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        _write_settings(out, scene.name, condition, beside, headset, renderer)
    total = frames or len(trace)
    return _draw(headset, renderer, second, out, video=video, total=total, quiet=quiet)


def _draw(
    headset: Any,
    renderer: Any,
    second: Any,
    out: Path | None,
    *,
    video: Path | None,
    total: int,
    quiet: bool,
) -> int:
    from vrcomfort.render.output import VideoWriter, read_rgb8, side_by_side, write_png
    from vrcomfort.replay.film import PICTURES, cleared
    from vrcomfort.session.frame_log import FrameLog

    pictures = None if out is None else cleared(out / PICTURES)
    count, start_ns = 0, None
    with ExitStack() as owned:
        rows: Any = _NoRows() if out is None else owned.enter_context(_rows(out / LOG))
        film = None
        if video is not None:
            film = owned.enter_context(VideoWriter(video, frames_per_s=headset.refresh_hz))
        advance = owned.enter_context(progress_bar("drawn", total, quiet=quiet, unit="frames"))
        log = FrameLog(rows)
        for frame in headset.frames():
            start_ns = frame.predicted_display_time_ns if start_ns is None else start_ns
            time_s = (frame.predicted_display_time_ns - start_ns) / 1e9
            rendered = renderer.render(frame, time_s)
            log.add(frame, rendered, trial=1, session_s=time_s)
            shown = rendered.eyes
            if second is not None:
                shown = shown[0], second.render(frame, time_s).eyes[0]
            image = side_by_side(*map(read_rgb8, shown))
            if pictures is not None:
                write_png(pictures / f"{frame.index:06d}.png", image)
            if film is not None:
                film.write(image)
            headset.submit(frame, rendered.eyes)
            count += 1
            advance()
        log.finish(renderer.drain())
    return count


class _NoRows:
    """Where no log is wanted."""

    def write(self, *rows: Row) -> None:
        """Write nothing."""


class _RowFile:
    """Appends rows to one CSV file."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def write(self, *rows: Row) -> None:
        from vrcomfort.records.rows import csv_line

        for row in rows:
            self._stream.write(csv_line(row.cells()))


@contextmanager
def _rows(file: Path) -> Iterator[_RowFile]:
    from vrcomfort.records import FrameRow
    from vrcomfort.records.rows import csv_line

    with file.open("w", encoding="utf-8", newline="") as stream:
        stream.write(csv_line(FrameRow.columns()))
        yield _RowFile(stream)


def _write_settings(
    out: Path,
    scene: str,
    condition: Condition,
    beside: Condition | None,
    headset: Any,
    renderer: Any,
) -> None:
    settings = {
        "scene": scene,
        "condition": condition.model_dump(mode="json"),
        **({"beside": beside.model_dump(mode="json")} if beside else {}),
        "passes": [step.name for step in renderer.plan() if step.needed],
        "size_px": list(headset.image_size_px),
        "refresh_hz": headset.refresh_hz,
        "ipd_m": headset.ipd_m,
    }
    (out / SETTINGS).write_text(json.dumps(settings, indent=2) + "\n", encoding="utf-8")


class Level(StrEnum):
    """Levels of quality, as options have them."""

    FAST = "fast"
    BALANCED = "balanced"
    ACCURATE = "accurate"
    REFERENCE = "reference"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command()(play)


def play(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="TRACE|SESSION",
            help="Head trace or frames.csv; or a session's folder, STUDY/sub-P01/ses-1.",
        ),
    ],
    scene: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.glb",
            help="For a trace: a shipped scene, or any glTF 2.0 file. A session knows its own.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        output_option("--out", help="Folder for numbered pictures; earlier ones are replaced."),
    ] = None,
    video: Annotated[
        Path | None, output_option("--video", help="Video file (.mp4); an earlier one is replaced.")
    ] = None,
    protocol: ProtocolOption = None,
    condition: ConditionOption = None,
    quality: Annotated[
        Level | None, typer.Option(help="Quality level to draw at, instead of that of the session.")
    ] = None,
    beside: Annotated[
        str | None,
        typer.Option(metavar="CONDITION", help="Draw another condition beside it."),
    ] = None,
    trial: Annotated[
        str | None, typer.Option(help="Only this trial; 0 is training.", show_default=False)
    ] = None,
    from_s: Annotated[
        float | None, typer.Option("--from-s", metavar="S", help="Session: only from session_s on.")
    ] = None,
    to_s: Annotated[
        float | None, typer.Option("--to-s", metavar="S", help="Session: only up to session_s.")
    ] = None,
    show: Annotated[
        str, typer.Option(metavar="gaze,ratings", help="Session: overlays to draw.")
    ] = "",
    eye: Annotated[
        str | None,
        typer.Option(
            metavar="left|right|both",
            help="Session: eye to draw; by default both, with --beside the left.",
        ),
    ] = None,
    gaze: Annotated[
        Path | None,
        typer.Option(help="Gaze (gaze.csv); by default the one beside frames.csv."),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(
            metavar="WxH", help="Pixels of one eye's image: the session's, or 640x800 of a trace."
        ),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option(
            help="Trace: number of frames (short traces loop); by default all, once.", min=1
        ),
    ] = None,
    refresh_hz: RefreshRate = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Replay a recorded session, or a head trace in a scene.

    A session is drawn from its own files: conditions, scenes, cuts and dropped frames are those
    that were shown, and its images are compared with the hashes that were recorded (images.csv).
    Both eyes stand side by side; a trace's folder gets frames.csv, too.

    - `vrcomfort play my_study/sub-P01/ses-1 --trial 1 --video seen.mp4`
    - `vrcomfort play my_study/sub-P01/ses-1 --beside dof_off --show gaze,ratings --video both.mp4`
    - `vrcomfort play my_study/sub-P01/ses-1 --from-s 65 --to-s 70 --out pictures`
    - `vrcomfort play walk.csv --scene temple --frames 300 --size 320x400 --out played`
    - `vrcomfort play hands.csv --scene depths --protocol motion_blur_2020_hands
      --condition in_world --beside with_head --video hands.mp4`
    """
    of_traces = {
        "--scene": scene, "--gaze": gaze, "--frames": frames, "--refresh-hz": refresh_hz,
    }  # fmt: skip
    of_sessions = {
        "--from-s": from_s, "--to-s": to_s, "--show": show or None, "--eye": eye,
    }  # fmt: skip
    if not source.exists():
        raise InputError("there is no such file or folder", file=source)
    is_session = source.is_dir()
    if is_session:
        from vrcomfort.replay import require_session

        require_session(source)
        _refuse(of_traces, "a recorded session, which knows it")
    else:
        _refuse(of_sessions, "a head trace; give a session's folder")
    _require_place(out, video)
    level: Quality | None = None if quality is None else quality.value
    size_px = None if size is None else parse_size(size)
    if is_session:
        options = ReplayOptions(
            protocol,
            condition,
            beside,
            level,
            _trial_number(trial),
            from_s,
            to_s,
            show,
            eye,
            size_px,
        )
        folder = None if out is None else output_folder(out)
        film = None if video is None else output_file(video, source / "frames.csv")
        play_session(source, options, out=folder, video=film, quiet=quiet, as_json=as_json)
        return
    if scene is None:
        raise InputError("a head trace needs a scene to play in: --scene temple, for example")
    study, shown = pick_condition(protocol, condition)
    other = None if beside is None else pick_condition(protocol, beside)[1]
    wanted = [each.in_scene(scene) for each in (shown, other) if each is not None]
    wanted = wanted if level is None else [each.at_level(level) for each in wanted]
    played = open_trace(source, trial=trial, gaze=gaze, note=warn)
    require_recorded_gaze(wanted, played)
    if out is not None:
        spare([source, gaze], [out / name for name in WRITTEN])
    count = play_trace(
        played,
        scene,
        wanted[0],
        beside=None if other is None else wanted[1],
        size_px=size_px or (640, 800),
        ipd_m=study.headset.ipd_m if study else MEAN_IPD_M,
        frames=frames,
        refresh_hz=refresh_hz,
        video=None if video is None else output_file(video, source),
        out=None if out is None else output_folder(out),
        quiet=quiet or as_json,
    )
    places = [str(each) for each in (out, video) if each is not None]
    sentence = f"{count} stereo frames: {', '.join(places)}"
    conclude(sentence, {"frames": count, "written": places}, quiet=quiet, as_json=as_json)


def _refuse(options: dict[str, Any], what: str) -> None:
    for name, value in options.items():
        if value is not None:
            raise InputError(f"{name} means nothing for {what}")


def _require_place(out: Path | None, video: Path | None) -> None:
    if out is None and video is None:
        raise InputError("nothing would be written; give --video FILE.mp4, or --out FOLDER")
    if video is None:
        return
    if video.suffix.lower() != ".mp4":
        raise InputError("a video's name ends in .mp4; choose such a name", file=video)
    from vrcomfort.render.output import require_video

    require_video()


def _trial_number(text: str | None) -> int | None:
    if text is None:
        return None
    if not text.isdecimal():
        raise InputError(f"--trial {text!r} is not a trial; write 1, 2, … or 0 (training)")
    return int(text)
