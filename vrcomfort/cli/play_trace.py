"""A head trace through a scene: pictures, frame log and video."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vrcomfort.cli.renderer import make_renderer
from vrcomfort.cli.terminal import progress_bar, warn
from vrcomfort.protocol import Condition

if TYPE_CHECKING:
    from vrcomfort.records import Row
    from vrcomfort.traces.trace import Trace

LOG, SETTINGS = WRITTEN = ("frames.csv", "meta.json")
"""Files in the folder of results, beside the pictures."""


def play_trace(
    trace: Trace,
    scene_source: str,
    condition: Condition,
    *,
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

    A trace without avatar poses is anchored at the scene's spawn point.
    """
    from vrcomfort.headset.playback import PlaybackHeadset
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
    if out is not None:
        _write_settings(out, scene.name, condition, headset, renderer)
    return _draw(headset, renderer, out, video=video, total=frames or len(trace), quiet=quiet)


def _draw(
    headset: Any, renderer: Any, out: Path | None, *, video: Path | None, total: int, quiet: bool
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
            image = side_by_side(*map(read_rgb8, rendered.eyes))
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
    out: Path, scene: str, condition: Condition, headset: Any, renderer: Any
) -> None:
    settings = {
        "scene": scene,
        "condition": condition.model_dump(mode="json"),
        "passes": [step.name for step in renderer.plan() if step.needed],
        "size_px": list(headset.image_size_px),
        "refresh_hz": headset.refresh_hz,
        "ipd_m": headset.ipd_m,
    }
    (out / SETTINGS).write_text(json.dumps(settings, indent=2) + "\n", encoding="utf-8")
