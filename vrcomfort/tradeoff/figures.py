"""Error against cost, both on log axes: the Pareto figure of a scene."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from vrcomfort.geometry import Array
from vrcomfort.tradeoff import keys, labels
from vrcomfort.tradeoff.measure import SCATTER
from vrcomfort.tradeoff.results import by_dial

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text
    from matplotlib.transforms import Transform

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
    "text.parse_math": False,
}
LABEL: dict[str, Any] = {"fontsize": 7.5}
MARKER_PT, RING_PT = 5.0, 10.0
"""Diameters of a marker, and of the ring around one that does not count."""

SAME_PX = 3.0
"""Markers nearer than this have one label; of equal errors, those with less than one between."""


def pareto_figure(name: str, rows: Sequence[Row], folder: Path) -> str:
    """Write `name`.svg and `name`.png into `folder`; return the SVG text."""
    with mpl.rc_context({**STYLE, "svg.hashsalt": name}):
        figure = draw(rows)
        stream = io.StringIO()
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        figure.savefig(folder / f"{name}.png", dpi=150, metadata={"Software": None})
    (folder / f"{name}.svg").write_text(stream.getvalue(), encoding="utf-8")
    return stream.getvalue()


def draw(rows: Sequence[Row]) -> Figure:
    """Return the figure of one scene and effect."""
    timed = [row for row in rows if row["cost"] and row["family"] != "none"]
    figure = Figure(figsize=(7.2, 4.6), layout=ConstrainedLayoutEngine(w_pad=0.08))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    for family in COLOURS:
        _plot(axes, [row for row in timed if row["family"] == family], family)
    _lines(axes, rows)
    _decorate(axes, rows)
    _place_labels(figure, axes, timed)
    return figure


def _plot(axes: Axes, rows: list[Row], family: str) -> None:
    if not rows:
        return
    x, y = [row["cost"] for row in rows], [row["rms"] for row in rows]
    look: dict[str, Any] = {"color": COLOURS[family], "zorder": 3}
    axes.plot(x, y, MARKERS[family], ms=MARKER_PT, label=WORDS[family], **look)
    for steps in by_dial(rows).values():
        joined = [(row["cost"], row["rms"]) for row in steps]
        axes.plot(*zip(*joined, strict=True), "-", lw=1.2, **look)
    unsure = [(a, b) for a, b, row in zip(x, y, rows, strict=True) if not row["counts"]]
    if unsure:
        ring: dict[str, Any] = {"ms": RING_PT, "mfc": "none", "mec": FAINT, "mew": 0.8}
        axes.plot(*zip(*unsure, strict=True), "o", zorder=2, **ring)


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
    title = f"{keys.title(keys.key_of_row(first))} ({first['views']} {views})"
    axes.set_title(title, loc="left", fontsize=10, pad=24)
    axes.set_xlabel("cost: 1 + effect ÷ plain frame")
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
    """Label the markers, those that coincide together."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    spread(axes)
    if not rows:
        return
    pixels_per_point = figure.dpi / 72
    centers = axes.transData.transform([(r["cost"], r["rms"]) for r in rows])
    rings = [MARKER_PT if row["counts"] else RING_PT for row in rows]
    markers = np.column_stack([centers, np.array(rings) / 2 * pixels_per_point])
    groups = coinciding(rows, markers)
    texts = [_text(axes, [rows[index] for index in group]) for group in groups]
    boxes = [text.get_window_extent() for text in texts]
    own = np.array([[*centers[g].mean(axis=0), markers[g, 2].max()] for g in groups])
    inside = np.array(axes.get_window_extent().extents)
    crowd = labels.Crowd(inside, markers, _drawn_lines(axes))
    places = labels.place([(box.width, box.height) for box in boxes], own, crowd)
    for text, marker, place in zip(texts, own, places, strict=True):
        text.set_position(_place_in(axes.transAxes, (place[:2] + place[2:]) / 2))
        line = labels.leader(place, marker)
        if line is not None:
            ends = axes.transAxes.inverted().transform(line)
            axes.plot(*ends.T, color=FAINT, lw=0.6, transform=axes.transAxes, zorder=2.5)


def _text(axes: Axes, rows: list[Row]) -> Text:
    return axes.text(
        0.5,
        0.5,
        joined(rows),
        transform=axes.transAxes,
        ha="center",
        va="center",
        color=COLOURS[rows[0]["family"]],
        **LABEL,
    )


def coinciding(rows: Sequence[Row], markers: Array) -> list[list[int]]:
    """Return the indices of methods that share a label: of ours, where markers coincide."""
    groups: list[list[int]] = []
    for index, row in enumerate(rows):
        near = [g for g in groups if row["step"] and any(_near(rows, markers, index, i) for i in g)]
        groups = [group for group in groups if group not in near]
        groups.append(sorted([index, *(each for group in near for each in group)]))
    return sorted(groups)


def _near(rows: Sequence[Row], markers: Array, index: int, other: int) -> bool:
    """Return whether two of ours share a label."""
    first, second = rows[index], rows[other]
    apart_px = float(np.hypot(*(markers[index] - markers[other])[:2]))
    same = math.isclose(first["rms"], second["rms"], rel_tol=1e-6)
    return bool(second["step"]) and apart_px < (4 * markers[index, 2] if same else SAME_PX)


def joined(rows: Sequence[Row]) -> str:
    """Return the label of methods that coincide: their steps, dial by dial."""
    if not rows[0]["step"]:
        return str(rows[0]["method"])
    parts = []
    dials = by_dial(rows)
    for name, steps in sorted(dials.items(), key=lambda dial: rows.index(dial[1][0])):
        numbers = [row["step"] for row in steps]
        ends = f"{numbers[0]}–{numbers[-1]}" if len(numbers) > 1 else f"{numbers[0]}"
        parts.append(f"{ends} {name if numbers[-1] > 1 else name.removesuffix('s')}")
    return ", ".join(parts)


def spread(axes: Axes) -> None:
    """Move the names of the lines apart where they would lie on each other, in order."""
    texts = sorted(axes.texts, key=lambda text: text.get_window_extent().y0)
    lowest = -math.inf
    for text in texts:
        box = text.get_window_extent()
        up_px = max(0.0, lowest - box.y0)
        x, y = text.get_position()
        if up_px:
            transform = axes.get_yaxis_transform()
            across, height = transform.transform((x, y))
            text.set_position(_place_in(transform, np.array([across, height + up_px])))
        lowest = box.y1 + up_px


def _place_in(transform: Transform, place_px: Array) -> tuple[float, float]:
    x, y = transform.inverted().transform(place_px)
    return float(x), float(y)


def _drawn_lines(axes: Axes) -> Array:
    """Return (k, 2, 2): the ends of all straight lines, in pixels, as far as they are seen."""
    box = axes.get_window_extent()
    found = [np.zeros((0, 2, 2))]
    for line in axes.lines:
        if line.get_linestyle() != "None":
            corners = line.get_transform().transform(np.column_stack(line.get_data()))
            corners[:, 0] = np.clip(corners[:, 0], box.x0, box.x1)
            found.append(np.stack([corners[:-1], corners[1:]], axis=1))
    return np.concatenate(found)
