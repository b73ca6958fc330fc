"""Writes replayed frames as numbered pictures and as a video in which each stands as it stood."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vrcomfort.json_text import json_of
from vrcomfort.render.output import Rgb8, VideoWriter, read_rgb8, write_png
from vrcomfort.replay.drawn import DrawnFrame
from vrcomfort.replay.sheet import ContactSheet

PICTURES, SUMMARY = "frames", "replay.json"
"""In the folder of results: numbered pictures, and what was drawn."""


@dataclass
class FilmProgress:
    """Frames and seconds written so far."""

    frames: int = 0
    video_s: float = 0.0


def write_film(
    frames: Iterable[DrawnFrame],
    sheet: ContactSheet,
    *,
    out: Path | None,
    video: Path | None,
    refresh_hz: float,
) -> Iterator[FilmProgress]:
    """Write frames as they are drawn; yield what was written after each.

    Parameters
    ----------
    out
        A folder that takes pictures; those of before are removed.
    video
        An .mp4 file; each frame stands in it until the next was seen.
    refresh_hz
        Its nominal rate.
    """
    pictures = None if out is None else cleared(out / PICTURES)
    written = FilmProgress()
    with ExitStack() as owned:
        film = None
        if video is not None:
            film = owned.enter_context(VideoWriter(video, frames_per_s=refresh_hz))
        for drawn in frames:
            image = sheet.draw(drawn, _images(drawn))
            if pictures is not None:
                write_png(pictures / f"{written.frames:06d}.png", image)
            if film is not None:
                film.write(image, drawn.video_s)
            written.frames += 1
            written.video_s = drawn.video_s + drawn.frame.period_ns / 1e9
            yield written


def write_summary(out: Path, facts: dict[str, Any]) -> None:
    """Write what was drawn beside the pictures."""
    text = json_of(facts)
    (out / SUMMARY).write_text(text + "\n", encoding="utf-8")


def cleared(folder: Path) -> Path:
    """Make a folder for numbered pictures, without those of before."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("[0-9]" * 6 + ".png"):
        old.unlink()
    return folder


def _images(drawn: DrawnFrame) -> list[tuple[Rgb8, Rgb8]]:
    both = [drawn.eyes] if drawn.beside is None else [drawn.eyes, drawn.beside]
    return [(read_rgb8(left), read_rgb8(right)) for left, right in both]
