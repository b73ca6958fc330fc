#!/usr/bin/env python3
"""Writes docs/images/frame.svg: the parts of a frame, and the images that each reads and writes.

It is made from the declaration (`vrcomfort.render.graph`): a part is a row, an image a column; a
filled circle writes, an open one reads.
"""

from __future__ import annotations

import sys
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from vrcomfort.protocol.conditions import Condition  # noqa: E402 - found through the line above
from vrcomfort.render.graph import FramePart, frame_of  # noqa: E402

FILE = ROOT / "docs" / "images" / "frame.svg"
LEFT, TOP, ROW, COLUMN, RADIUS = 170, 44, 30, 96, 6
STYLE = "text{font:13px sans-serif;fill:#222}.i{font-style:italic;text-anchor:middle}"


def frame_svg(parts: tuple[FramePart, ...]) -> str:
    """Return the figure of a frame with these parts."""
    images = list(dict.fromkeys(image for part in parts for image in (*part.writes, *part.reads)))
    width, height = LEFT + COLUMN * len(images), TOP + ROW * len(parts) + 10
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}">',
        f"<style>{STYLE}</style>",
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    for number, image in enumerate(images):
        x = LEFT + COLUMN * number + COLUMN / 2
        used = [row for row, part in enumerate(parts) if image in (*part.reads, *part.writes)]
        lines.append(f'<text class="i" x="{x:g}" y="{TOP - 18}">{escape(image)}</text>')
        lines.append(
            f'<line x1="{x:g}" x2="{x:g}" y1="{_y(used[0])}" y2="{_y(used[-1])}" '
            'stroke="#999" stroke-width="2"/>'
        )
    for row, part in enumerate(parts):
        if row % 2 == 0:
            lines.insert(
                3,
                f'<rect y="{_y(row) - ROW / 2:g}" width="{width}" height="{ROW}" fill="#f3f3f3"/>',
            )
        lines.append(f'<text x="12" y="{_y(row) + 5}">{row + 1}. {escape(part.name)}</text>')
        for number, image in enumerate(images):
            x = LEFT + COLUMN * number + COLUMN / 2
            lines += _marks(part, image, x, _y(row))
    return "\n".join([*lines, "</svg>", ""])


def _y(row: int) -> int:
    return TOP + ROW * row + ROW // 2


def _marks(part: FramePart, image: str, x: float, y: int) -> list[str]:
    """Return the circles of a part in an image's column: read first, then written."""
    reads, writes = image in part.reads, image in part.writes
    offsets = (-9, 9) if reads and writes else (0, 0)
    circle = '<circle cx="{:g}" cy="{}" r="{}" fill="{}" stroke="#1f5fa8" stroke-width="2"/>'
    read = [circle.format(x + offsets[0], y, RADIUS, "#fff")] if reads else []
    written = [circle.format(x + offsets[1], y, RADIUS, "#1f5fa8")] if writes else []
    return [*read, *written]


def main() -> None:
    """Write the figure."""
    FILE.write_text(frame_svg(frame_of(Condition(name="all"))), encoding="utf-8")


if __name__ == "__main__":
    main()
