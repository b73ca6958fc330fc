"""Pareto figures of a scene and of a choice: error against cost, both on log axes."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.plurals import counted
from vrcomfort.tradeoff import results
from vrcomfort.tradeoff.measure import SCATTER
from vrcomfort.tradeoff.recommendation import Recommendation
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
    return _write(name, lambda: draw(rows), folder)


def _write(name: str, draw: Callable[[], Figure], folder: Path) -> str:
    with mpl.rc_context({**STYLE, "svg.hashsalt": name}):
        figure = draw()
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
    """Draw errors without a cost as lines: no blur, the best post-process, the reference."""
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
    views = counted(first["views"], "views")
    title = f"{results.title(results.key_of_row(first))} ({views})"
    axes.set_title(title, loc="left", fontsize=10, pad=24)
    _frame(axes, "cost: 1 + effect ÷ plain frame")


def front_figure(choice: Recommendation, folder: Path) -> str:
    """Write the front of a choice as `choice_….svg` and `.png`; return the SVG text."""
    name = f"choice_{results.figure_name(('all', *choice.key[1:]))}"
    return _write(name, lambda: draw_front(choice), folder)


def draw_front(choice: Recommendation) -> Figure:
    """Plot error against milliseconds of a frame: the front, and the chosen level on it."""
    figure = Figure(figsize=(7.2, 3.9), layout=ConstrainedLayoutEngine(w_pad=0.08))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_xscale("log")
    axes.set_yscale("log")
    x, y = [each.frame_ms for each in choice.others], [each.rms for each in choice.others]
    axes.plot(x, y, "o", ms=MARKER_PT, color="#cfcfcf", zorder=2, label="not on the front")
    x, y = [each.frame_ms for each in choice.front], [each.rms for each in choice.front]
    axes.plot(x, y, "-", lw=1.2, color=FAINT, zorder=2.2)
    for family, colour in COLOURS.items():
        mine = [(each.frame_ms, each.rms) for each in choice.front if each.family == family]
        if mine:
            look: dict[str, Any] = {"color": colour, "zorder": 3, "label": WORDS[family]}
            axes.plot(*zip(*mine, strict=True), MARKERS[family], ms=MARKER_PT, **look)
    ring: dict[str, Any] = {"ms": RING_PT + 2, "mfc": "none", "mec": INK, "mew": 1.6}
    at = choice.chosen
    axes.plot([x[at]], [y[at]], "o", zorder=4, label="to choose", **ring)
    _frame(axes, "milliseconds of a stereo frame")
    low, high = axes.get_xlim()
    if low < choice.budget_ms < high:
        axes.axvline(choice.budget_ms, color=FAINT, lw=0.9, ls="--", zorder=1)
    nothing = {"counts": False, "step": None}
    rows = [
        {**nothing, "method": o.label, "cost": o.frame_ms, "rms": o.rms, "family": o.family}
        for o in (*choice.front, *choice.others)
    ]
    _place_labels(figure, axes, rows, len(choice.front))
    for text in axes.texts:
        if text.get_text() == choice.front[at].label:
            text.set_fontweight("bold")
    return figure


def _frame(axes: Axes, cost: str) -> None:
    """Name and number the axes."""
    axes.set_xlabel(cost)
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
            frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=5
        )


def _place_labels(figure: Figure, axes: Axes, rows: list[Row], labelled: int | None = None) -> None:
    """Label the markers (the first ones, where `labelled` says how many), coinciding ones once."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    spread(axes)
    if not rows:
        return
    pixels_per_point = figure.dpi / 72
    centers = axes.transData.transform([(r["cost"], r["rms"]) for r in rows])
    rings = [MARKER_PT if row["counts"] else RING_PT for row in rows]
    markers = np.column_stack([centers, np.array(rings) / 2 * pixels_per_point])
    groups = coinciding(rows[:labelled], markers)
    texts = [_text(axes, [rows[index] for index in group]) for group in groups]
    boxes = [text.get_window_extent() for text in texts]
    own = np.array([[*centers[g].mean(axis=0), markers[g, 2].max()] for g in groups])
    inside = np.array(axes.get_window_extent().extents)
    crowd = Crowd(inside, markers, _drawn_lines(axes))
    places = place([(box.width, box.height) for box in boxes], own, crowd)
    for text, marker, box in zip(texts, own, places, strict=True):
        text.set_position(_place_in(axes.transAxes, (box[:2] + box[2:]) / 2))
        line = leader(box, marker)
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


# Placing of labels, so that none lies on another, on a marker or on an axis. Everything is in
# pixels of the canvas. A place is a box (x0, y0, x1, y1); a line of two ends leads from a marker
# to the nearest point of its label's box.


DIRECTIONS = 20
GAPS_PX = (4, 10, 16, 24, 34, 46, 60, 76, 94)
"""Between a marker's rim and its label."""

KEPT = 100
"""Places of each label that are looked at: those that are best on their own."""

PAD_PX = 2.0
"""At least so far from all that a label must not touch (twice as far from the next label)."""

LEADER_PX = 9.0
"""From so large a gap on a line shows whose label it is."""

MUST_NOT, BETTER_NOT, WORSE = 1e4, 300.0, 60.0
"""A label on a label, on a marker, outside, or under another's line; a label on a drawn line, or a
line over a marker; a label nearer to another marker than to its own, behind a drawn line, or two
lines that cross. Beside them, the gap in pixels counts."""

TRIES, ROUNDS, UNREST = 600, 8, 60.0
"""So often labels are put elsewhere, as noise on what is bad about their places has it, and moved
one at a time until none moves, or so often."""


class Crowd(NamedTuple):
    """Obstacles of labels: the frame, markers and lines.

    Parameters
    ----------
    inside
        The box they must stay in.
    markers
        (m, 3): centre and radius of all markers.
    lines
        (k, 2, 2): ends of straight lines that are drawn; may be none.
    """

    inside: Array
    markers: Array
    lines: Array


class _Places(NamedTuple):
    """Possible places of a label, and the penalty of each on its own."""

    boxes: Array
    lines: Array
    """(n, 2, 2): from the marker to where a line would end."""
    has_line: NDArray[np.bool_]
    bad: Array


def place(sizes_px: Sequence[tuple[float, float]], markers: Array, crowd: Crowd) -> list[Array]:
    """Return the box of each label: the best that is found by moving some, then one at a time.

    Parameters
    ----------
    sizes_px
        (width, height) of the labels' texts.
    markers
        (n, 3): centre and radius of what each label belongs to.
    """
    if not len(markers):
        return []
    places = [_places(size, own, crowd) for size, own in zip(sizes_px, markers, strict=True)]
    search = _LabelSearch(places)
    taken = search.best(np.random.default_rng(0))
    return [each.boxes[index] for each, index in zip(places, taken, strict=True)]


def leader(box: Array, marker: Array) -> Array | None:
    """Return the ends (2, 2) of a line from a marker's rim to its label; None of a near one."""
    end = np.clip(marker[:2], box[:2], box[2:])
    way = end - marker[:2]
    length = float(np.hypot(*way))
    if length - marker[2] < LEADER_PX:
        return None
    return np.array([marker[:2] + way * marker[2] / length, end])


def _places(size_px: tuple[float, float], marker: Array, crowd: Crowd) -> _Places:
    angle = np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS
    toward = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    gap = np.repeat(GAPS_PX, DIRECTIONS)[:, None] + marker[2]
    half = np.array(size_px) / 2
    centre = marker[:2] + np.tile(toward, (len(GAPS_PX), 1)) * (half + gap)
    boxes = np.concatenate([centre - half, centre + half], axis=-1)
    ends = np.clip(marker[:2], boxes[:, :2], boxes[:, 2:])
    distance = np.hypot(*(ends - marker[:2]).T) - marker[2]
    has_line = distance >= LEADER_PX
    inside = crowd.inside + PAD_PX * np.array([1, 1, -1, -1])
    outside = np.any((boxes[:, :2] < inside[:2]) | (boxes[:, 2:] > inside[2:]), axis=-1)
    rims = _around(crowd.markers[:, :2], crowd.markers[:, 2:])
    strange = np.hypot(*(crowd.markers[:, :2] - marker[:2]).T) > marker[2]
    elsewhere = crowd.lines[~_hits(_around(marker[None, :2], marker[2:]), crowd.lines)[0]]
    own = np.stack([np.broadcast_to(marker[:2], ends.shape), ends], axis=1)
    must_not = outside + _overlaps(boxes, rims).sum(axis=-1)
    better_not = _hits(boxes, crowd.lines).any(axis=-1)
    better_not = better_not + has_line * _hits(rims[strange], own).sum(axis=0)
    nearest = _gaps(boxes, crowd.markers[strange]).min(axis=-1, initial=np.inf)
    worse = (nearest < distance + PAD_PX) + 1.0 * _cross(own, elsewhere).any(axis=-1)
    bad = MUST_NOT * must_not + BETTER_NOT * better_not + WORSE * worse + distance
    kept = np.argsort(bad, kind="stable")[:KEPT]
    return _Places(boxes[kept], own[kept], has_line[kept], bad[kept])


class _LabelSearch:
    """Looks for places that go together: a list with the number of a place for each label."""

    def __init__(self, places: Sequence[_Places]) -> None:
        self._alone = [each.bad for each in places]
        self._together = [[_together(a, b, same=a is b) for b in places] for a in places]

    def best(self, random: np.random.Generator) -> list[int]:
        """Return the best that is found."""
        best = self._settled([int(np.argmin(bad)) for bad in self._alone], random)
        least = self._total(best)
        for _ in range(TRIES):
            found = self._settled(self._disturbed(best, random), random)
            total = self._total(found)
            if total < least:
                best, least = found, total
        return best

    def _disturbed(self, taken: list[int], random: np.random.Generator) -> list[int]:
        """Return the places with a third of the labels, at least one, elsewhere."""
        found = list(taken)
        for index in random.permutation(len(found))[: 1 + len(found) // 3]:
            bad = self._alone[index]
            found[index] = int(np.argmin(bad + random.exponential(UNREST, len(bad))))
        return found

    def _settled(self, taken: list[int], random: np.random.Generator) -> list[int]:
        """Return places that no label can better by moving alone."""
        found = list(taken)
        for _ in range(ROUNDS):
            before = list(found)
            for index in random.permutation(len(found)):
                found[index] = int(np.argmin(self._bad(found, int(index))))
            if found == before:
                break
        return found

    def _total(self, taken: list[int]) -> float:
        return sum(float(self._bad(taken, i)[at]) for i, at in enumerate(taken))

    def _bad(self, taken: list[int], index: int) -> Array:
        """Return the penalty of each place of a label while the others stay."""
        rows = self._together[index]
        found: Array = self._alone[index] + sum(
            row[at] for row, at in zip(rows, taken, strict=True)
        )
        return found


def _together(a: _Places, b: _Places, *, same: bool) -> Array:
    """Return (places of b, places of a): the penalty of two labels' places together."""
    if same:
        return np.zeros((len(b.bad), len(a.bad)))
    apart = PAD_PX * np.array([-1, -1, 1, 1])
    over = _overlaps(b.boxes, a.boxes + apart) + 1.0 * (_hits(b.boxes, a.lines) & a.has_line)
    over = over + (_hits(a.boxes, b.lines) & b.has_line).T
    crossing = _cross(b.lines, a.lines) & a.has_line & b.has_line[:, None]
    found: Array = MUST_NOT * over + WORSE * crossing
    return found


def _around(centres: Array, reach: Array) -> Array:
    """Return (n, 4) boxes around centres."""
    return np.concatenate([centres - reach, centres + reach], axis=-1)


def _gaps(boxes: Array, markers: Array) -> Array:
    """Return (n, m): how far each box is from the rim of each marker."""
    centres = markers[None, :, :2]
    nearest = np.clip(centres, boxes[:, None, :2], boxes[:, None, 2:])
    gaps: Array = np.linalg.norm(nearest - centres, axis=-1) - markers[:, 2]
    return gaps


def _overlaps(a: Array, b: Array) -> NDArray[np.bool_]:
    """Return (n, m): which boxes come nearer to each other than :data:`PAD_PX`."""
    low = np.maximum(a[:, None, :2], b[None, :, :2]) - PAD_PX
    high = np.minimum(a[:, None, 2:], b[None, :, 2:])
    found: NDArray[np.bool_] = np.all(low < high, axis=-1)
    return found


def _hits(boxes: Array, lines: Array) -> NDArray[np.bool_]:
    """Return (n, m): which lines (m, 2, 2) come nearer to which boxes than :data:`PAD_PX`."""
    start, way = lines[None, :, 0], lines[None, :, 1] - lines[None, :, 0]
    way = np.where(way == 0, 1e-9, way)
    enter = (boxes[:, None, :2] - PAD_PX - start) / way
    leave = (boxes[:, None, 2:] + PAD_PX - start) / way
    first = np.minimum(enter, leave).max(axis=-1)
    last = np.maximum(enter, leave).min(axis=-1)
    found: NDArray[np.bool_] = (first <= last) & (last >= 0) & (first <= 1)
    return found


def _cross(a: Array, b: Array) -> NDArray[np.bool_]:
    """Return (n, m): which lines (n, 2, 2) cross which others (m, 2, 2)."""
    a, b = a[:, None], b[None]
    start, end, first, second = a[..., 0, :], a[..., 1, :], b[..., 0, :], b[..., 1, :]
    apart = _side(start, end, first) * _side(start, end, second)
    split = _side(first, second, start) * _side(first, second, end)
    found: NDArray[np.bool_] = (apart < 0) & (split < 0)
    return found


def _side(a: Array, b: Array, c: Array) -> Array:
    """Return a number that is positive where `c` lies to the left of the way from a to b."""
    along, across = b - a, c - a
    found: Array = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
    return np.sign(found)
