"""Error against cost, both on log axes: the Pareto figure of a scene."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from vrcomfort.tradeoff.measure import SCATTER
from vrcomfort.tradeoff.results import by_dial

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.transforms import Bbox

Row = dict[str, Any]

COLOURS = {"source": "#b4541a", "ours": "#20639b", "dial": "#3a7d44"}
MARKERS = {"source": "s", "ours": "o", "dial": "D"}
WORDS = {"source": "sources' methods", "ours": "ours", "dial": "ours, K views"}
INK, FAINT = "#222222", "#8a8a8a"
STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.labelcolor": INK,
    "text.color": INK,
    "svg.fonttype": "path",
}
OFFSETS = [
    (x, y, side)
    for reach in (7, 14, 22, 32, 44)
    for x, y, side in (
        (reach, 0, "left"), (0.7 * reach, 0.7 * reach, "left"), (0.7 * reach, -0.7 * reach, "left"),
        (-reach, 0, "right"), (-0.7 * reach, 0.7 * reach, "right"),
        (-0.7 * reach, -0.7 * reach, "right"), (0, reach, "center"), (0, -reach, "center"),
    )
]  # fmt: skip
"""Where a label may go, in points from its marker: near places first."""

FAR_PT = 12.0
"""From here on a line shows whose label it is."""


def pareto_figure(name: str, rows: Sequence[Row], folder: Path) -> str:
    """Write `name`.svg and `name`.png into `folder`; return the SVG text."""
    timed = [row for row in rows if row["effect_to_copy"] and row["family"] != "none"]
    with mpl.rc_context({**STYLE, "svg.hashsalt": name}):
        figure = Figure(figsize=(7.2, 4.6), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.set_xscale("log")
        axes.set_yscale("log")
        for family in COLOURS:
            _plot(axes, [row for row in timed if row["family"] == family], family)
        _lines(axes, rows)
        _decorate(axes, rows)
        _place_labels(figure, axes, timed)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        figure.savefig(folder / f"{name}.png", dpi=150, metadata={"Software": None})
    (folder / f"{name}.svg").write_text(stream.getvalue(), encoding="utf-8")
    return stream.getvalue()


def _plot(axes: Axes, rows: list[Row], family: str) -> None:
    if not rows:
        return
    x, y = [row["effect_to_copy"] for row in rows], [row["rms"] for row in rows]
    look: dict[str, Any] = {"color": COLOURS[family], "zorder": 3}
    axes.plot(x, y, MARKERS[family], ms=5, label=WORDS[family], **look)
    for steps in by_dial(rows).values():
        joined = [(row["effect_to_copy"], row["rms"]) for row in steps]
        axes.plot(*zip(*joined, strict=True), "-", lw=1.2, **look)
    unsure = [(a, b) for a, b, row in zip(x, y, rows, strict=True) if not row["counts"]]
    if unsure:
        axes.plot(*zip(*unsure, strict=True), "o", ms=10, mfc="none", mec=FAINT, mew=0.8, zorder=2)


def _lines(axes: Axes, rows: Sequence[Row]) -> None:
    """Draw what has an error and no cost: no blur, the best post-process, the reference itself."""
    named = {row["method"]: row for row in rows}
    place: dict[str, Any] = {
        "transform": axes.get_yaxis_transform(),
        "fontsize": 7.5,
        "color": FAINT,
    }
    marks = [
        (named["no blur"]["rms"], "no blur", ":"),
        (named[SCATTER]["rms"], "ideal scatter (R2)", "--"),
        (named[SCATTER]["reference_rms"], "R1's own error", "-."),
    ]
    for error, text, style in marks:
        if error > 0:
            axes.axhline(error, color=FAINT, lw=0.9, ls=style, zorder=1)
            axes.text(1.01, error, text, va="center", **place)


def _decorate(axes: Axes, rows: Sequence[Row]) -> None:
    first = rows[0]
    views = "view" if first["views"] == 1 else "views"
    title = f"{first['scene']}: {first['effect'].replace('_', ' ')} ({first['views']} {views})"
    axes.set_title(title, loc="left", fontsize=10, pad=24)
    axes.set_xlabel("cost of the effect ÷ cost of copying the stereo frame")
    axes.set_ylabel("RMS error against brute force (R1)\nlinear light, display white = 1")
    for axis in (axes.xaxis, axes.yaxis):
        start, end = axis.get_view_interval()
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if end / start < 300 else (1,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.margins(x=0.12, y=0.12)
    low, high = axes.get_xlim()
    widen = max(1.0, (10 / (high / low)) ** 0.5)  # at least a decade, or noise looks like a trend
    axes.set_xlim(low / widen, high * widen)
    axes.grid(visible=True, lw=0.4, color="#e2e2e2", zorder=0)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=3
        )


def _place_labels(figure: Figure, axes: Axes, rows: list[Row]) -> None:
    """Label each marker where its text meets neither another nor a marker."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    centers = [axes.transData.transform((r["effect_to_copy"], r["rms"])) for r in rows]
    lines = [point for line in axes.lines for point in _along(axes, line)]
    taken: list[Bbox] = [text.get_window_extent() for text in axes.texts]
    for row, center in zip(rows, centers, strict=True):
        text = row["method"].removeprefix("ours ")
        spot = axes.annotate(
            text,
            (row["effect_to_copy"], row["rms"]),
            xytext=(0, 0),
            textcoords="offset points",
            va="center",
            fontsize=7.5,
            color=COLOURS[row["family"]],
        )
        best = min(
            OFFSETS, key=lambda offset: _clash(spot, offset, axes, taken, lines, centers, center)
        )
        _put(spot, best)
        taken.append(spot.get_window_extent())
        if math.hypot(*best[:2]) > FAR_PT:
            _lead(axes, spot)


def _lead(axes: Axes, spot: Any) -> None:
    """Draw a thin line from a marker to its label."""
    line = {"arrowstyle": "-", "color": FAINT, "lw": 0.6, "shrinkA": 5, "shrinkB": 3}
    axes.annotate("", spot.xy, xytext=spot.xyann, textcoords="offset points", arrowprops=line)


def _along(axes: Axes, line: Any) -> Any:
    """Return places along a drawn line, some pixels apart, on the canvas."""
    if line.get_linestyle() == "None":
        return []
    corners = line.get_transform().transform(np.column_stack(line.get_data()))
    left, right = axes.get_window_extent().x0, axes.get_window_extent().x1
    corners[:, 0] = np.clip(corners[:, 0], left, right)
    steps = np.linspace(0, 1, 60)[:, None]
    parts = [a + (b - a) * steps for a, b in pairwise(corners)]
    return np.concatenate(parts) if parts else []


def _put(spot: Any, offset: tuple[float, float, str]) -> None:
    spot.xyann = offset[:2]
    spot.set_ha(offset[2])


def _clash(
    spot: Any,
    offset: tuple[float, float, str],
    axes: Axes,
    taken: Any,
    lines: Any,
    centers: Any,
    own: Any,
) -> float:
    """Return how bad a place is: square pixels on other texts, markers, or outside the axes."""
    _put(spot, offset)
    box = spot.get_window_extent()
    bad: float = sum(_overlap(box, other) for other in taken)
    bad += sum(8.0 for x, y in lines if _holds(box, x, y))
    bad += sum(60.0 for x, y in centers if _holds(box, x, y) and (x, y) != tuple(own))
    inside = axes.get_window_extent()
    bad += 1e4 * (
        box.x0 < inside.x0 or box.x1 > inside.x1 or box.y0 < inside.y0 or box.y1 > inside.y1
    )
    return bad + 0.02 * (abs(offset[0]) + abs(offset[1]))


def _overlap(a: Any, b: Any) -> float:
    width = float(min(a.x1, b.x1) - max(a.x0, b.x0))
    height = float(min(a.y1, b.y1) - max(a.y0, b.y0))
    return max(width, 0.0) * max(height, 0.0)


def _holds(box: Any, x: float, y: float) -> bool:
    return bool(box.x0 - 4 <= x <= box.x1 + 4 and box.y0 - 4 <= y <= box.y1 + 4)
