"""Lays the images of replayed frames out on a sheet; writes sheets as pictures and as a video."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from PIL import Image, ImageDraw

from vrcomfort.geometry import Array, View
from vrcomfort.json_text import json_of
from vrcomfort.render.output import Rgb8, VideoWriter, read_rgb8, write_png
from vrcomfort.replay.drawn import DrawnFrame
from vrcomfort.replay.recorded import RecordedRating
from vrcomfort.text_layout import TextCanvas

Eye: TypeAlias = Literal["left", "right"]
EYES: tuple[Eye, ...] = ("left", "right")

BACKGROUND, TEXT, QUIET, WARNING = (28, 32, 38), (240, 240, 240), (150, 158, 168), (250, 160, 60)
GAZE = 255, 64, 208

_FAR_M = 1000.0
"""Where a gaze goes that meets nothing that is known."""
# Smaller letters cannot be read.
_SMALLEST_PX = 9


@dataclass(frozen=True)
class ContactSheet:
    """How a frame is laid out.

    Parameters
    ----------
    eyes
        Which are shown, from left to right.
    titles
        Condition that was seen → what is written below what is drawn in its place.
    beside
        What is written below the other condition, if there is one.
    gaze, ratings
        Whether they are drawn in.
    """

    eyes: tuple[Eye, ...]
    titles: Mapping[str, str]
    beside: str | None = None
    gaze: bool = False
    ratings: bool = False

    @property
    def has_words(self) -> bool:
        """Whether there is a strip with words below the images."""
        return self.gaze or self.ratings or self.beside is not None

    def draw(self, drawn: DrawnFrame, images: Sequence[tuple[Rgb8, Rgb8]]) -> Rgb8:
        """Return (height, width, 3) of a frame.

        Parameters
        ----------
        images
            Of both eyes (height, width, 3), as it was seen and then, if any, beside it.
        """
        groups = [np.concatenate([self._eye(drawn, each, eye) for eye in self.eyes], axis=1)
                  for each in images]  # fmt: skip
        image = np.concatenate(groups, axis=1)
        if not self.has_words:
            return image
        return np.concatenate([image, self._words(drawn, image.shape[1], len(groups))])

    def _eye(self, drawn: DrawnFrame, images: tuple[Rgb8, Rgb8], eye: Eye) -> Rgb8:
        index = EYES.index(eye)
        image = images[index]
        gaze = drawn.frame.gaze
        if not (self.gaze and gaze is not None and gaze.valid):
            return image
        place = looked_at(drawn.frame.views[index], gaze_point(drawn), (image.shape[1], len(image)))
        if place is None:
            return image
        canvas = Image.fromarray(image)
        _draw_cross(ImageDraw.Draw(canvas), place, radius_px=max(image.shape[1] / 50, 3.0))
        return np.asarray(canvas)

    def _words(self, drawn: DrawnFrame, width: int, groups: int) -> Rgb8:
        size = max(width // 64, _SMALLEST_PX)
        line_px = round(1.5 * size)
        curve_px = 4 * line_px if self.ratings else 0
        canvas = Image.new("RGB", (width, 2 * line_px + curve_px + size), BACKGROUND)
        pen = TextCanvas(canvas)
        titles = [self.titles[drawn.exposure.condition], self.beside or ""][:groups]
        for group, title in enumerate(titles):
            left = size + group * width // groups
            room = width // groups - 2 * size
            _write(pen, (left, size // 2), title, size, room, TEXT)
        facts, odd = _facts(drawn, gaze=self.gaze)
        colour = WARNING if odd else QUIET
        _write(pen, (size, size // 2 + line_px), facts, size, width - 2 * size, colour)
        if self.ratings:
            box = size, size // 2 + 2 * line_px, width - size, size // 2 + 2 * line_px + curve_px
            _draw_ratings(pen, box, drawn, size)
        return np.asarray(canvas)


def _facts(drawn: DrawnFrame, *, gaze: bool) -> tuple[str, bool]:
    """Return a frame's caption, and whether it is a warning."""
    seen = f"trial {drawn.trial}" if drawn.trial else "training"
    words, odd = [seen, f"session {drawn.session_s:.2f} s"], False
    if drawn.focus_m is not None:
        words.append(f"focus {drawn.focus_m:.2f} m" if drawn.focus_m < _FAR_M else "focus far")
    if missed := drawn.missed_refreshes:
        words.append(f"{missed} refreshes missed before" if missed > 0 else "dropped before")
        odd = True
    if gaze and (drawn.frame.gaze is None or not drawn.frame.gaze.valid):
        words.append("gaze not known")
        odd = odd or drawn.frame.gaze is not None
    if drawn.equal is not None:
        words.append("image as recorded" if drawn.equal else "image not as recorded")
        odd = odd or not drawn.equal
    return ", ".join(words), odd


def gaze_point(drawn: DrawnFrame) -> Array:
    """Return (3,) where the gaze of a frame goes to, in the stage: as far away as the focus.

    Without a focus it goes to 1 km, where both eyes' lines of sight are parallel.
    """
    gaze = drawn.frame.gaze
    if gaze is None:
        raise ValueError("a frame without gaze looks nowhere")
    depth_m = drawn.focus_m or _FAR_M
    along = float(gaze.pose.forward @ drawn.frame.head_pose.forward)
    distance_m = min(depth_m / along, _FAR_M) if along > 1e-3 else _FAR_M
    return np.asarray(gaze.pose.position + gaze.pose.forward * distance_m)


def looked_at(view: View, point: Array, size_px: tuple[int, int]) -> tuple[float, float] | None:
    """Return (x, y) in px from the upper left where an eye sees a point of the stage.

    None where it is behind the eye or outside of its image.
    """
    x, y, z = ((point - view.pose.position) @ view.pose.rotation).tolist()
    if z >= 0:
        return None
    left, right, up, down = view.fov.tangents
    across, below = (x / -z - left) / (right - left), (up - y / -z) / (up - down)
    if not (0 <= across <= 1 and 0 <= below <= 1):
        return None
    return across * size_px[0], below * size_px[1]


def _draw_cross(pen: ImageDraw.ImageDraw, place: tuple[float, float], *, radius_px: float) -> None:
    x, y = place
    width = max(round(radius_px / 5), 1)
    box = (x - radius_px, y - radius_px, x + radius_px, y + radius_px)
    pen.ellipse(box, outline=GAZE, width=width)
    pen.line((x - radius_px / 2, y, x + radius_px / 2, y), fill=GAZE, width=width)
    pen.line((x, y - radius_px / 2, x, y + radius_px / 2), fill=GAZE, width=width)


def _draw_ratings(
    pen: TextCanvas, box: tuple[int, int, int, int], drawn: DrawnFrame, size: int
) -> None:
    """Draw the exposure's answers up to now over its time, and write the last one."""
    left, top, right, bottom = box
    known = [each for each in drawn.exposure.ratings if each.answered_s <= drawn.session_s]
    _write(pen, (left, top), rating_words(known), size, right - left, TEXT)
    answers = [each for each in drawn.exposure.ratings if each.response is not None]
    if not answers:
        return
    values = [each.response or 0 for each in answers]
    low, high = min(0, *values), max(1, *values)
    start_s, end_s = drawn.exposure.start_s, drawn.exposure.end_s
    area = left, top + round(1.5 * size), right, bottom - 2

    def place(time_s: float, value: float) -> tuple[float, float]:
        share = (time_s - start_s) / max(end_s - start_s, 1e-9)
        x = area[0] + min(max(share, 0.0), 1.0) * (area[2] - area[0])
        return x, area[3] - (value - low) / (high - low) * (area[3] - area[1])

    pen.line((area[0], area[3], area[2], area[3]), fill=QUIET)
    points = [place(each.answered_s, each.response or 0) for each in answers if each in known]
    if len(points) > 1:
        pen.line(points, fill=WARNING, width=max(size // 6, 1))
    for x, y in points:
        pen.ellipse((x - size / 4, y - size / 4, x + size / 4, y + size / 4), fill=WARNING)
    x, _ = place(drawn.session_s, low)
    pen.line((x, area[1], x, area[3]), fill=TEXT)


def rating_words(known: Sequence[RecordedRating]) -> str:
    """Return the last of some ratings in words."""
    if not known:
        return "no rating yet"
    last = known[-1]
    return f"{last.instrument}: {'missed' if last.response is None else last.response}"


def _write(
    pen: TextCanvas,
    place: tuple[int, int],
    text: str,
    size_px: int,
    room_px: int,
    colour: tuple[int, int, int],
) -> None:
    """Write one line, smaller where it would be wider than its room."""
    wide = pen.width_px(text, size_px)
    if wide > room_px:
        size_px = max(int(size_px * room_px / wide), 6)
    pen.write(place, text, size_px, fill=colour)


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
    """Write frames as they are drawn; yield the progress after each.

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
    """Write a summary of the replay beside the pictures."""
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
