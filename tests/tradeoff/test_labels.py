"""Labels of the Pareto figures lie on nothing: measured on what is drawn of the shipped numbers."""

from __future__ import annotations

import math
import re
from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.transforms import Bbox

from tests.support.places import ROOT
from vrcomfort.tradeoff import figures
from vrcomfort.tradeoff.figures import MARKER_PT, RING_PT, STYLE, coinciding, draw, joined

DOCS = ROOT / "docs" / "tradeoff_tables.md"
HEADING = re.compile(r"### (\w+), ([a-z ]+)(?:, lens ([\w.]+) %)?(?:, (\d+×\d+))?\n\n((?:\|.*\n)+)")


def shipped():
    """Return the rows of the shipped tables by scene and effect."""
    found = {}
    for scene, effect, lens, size, table in HEADING.findall(DOCS.read_text(encoding="utf-8")):
        lines = [
            [cell.strip() for cell in line.strip("|").split("|")] for line in table.split("\n")
        ]
        rows = [dict(zip(lines[0], line, strict=True)) for line in lines[2:-1]]
        found[f"{scene} {effect} {lens} {size}"] = [
            row_of(scene, effect, lens, row) for row in rows
        ]
    assert found, f"no table in {DOCS.name}"
    return found


def row_of(scene, effect, lens, row):
    name = row["method"]
    step = re.match(r"ours (\d+) (\w+)", name)
    family = ("dial" if "view" in step[2] else "ours") if step else "source"
    none = name in {"no blur", "ideal scatter (R2)"}
    rms = float(row["RMS R1 · 10³"]) / 1e3
    cost = row["cost"]
    return {
        "scene": scene,
        "effect": effect.replace(" ", "_"),
        "lens": lens or "3.5",
        "method": name,
        "family": "none" if none else family,
        "step": int(step[1]) if step else None,
        "views": 2,
        "cost": None if cost == "–" else float(cost),
        "rms": rms,
        "reference_rms": float(row["split-half"]) * rms,
        "counts": row["counts"] == "yes",
    }


SHIPPED = shipped()


@pytest.fixture(scope="module", params=SHIPPED)
def drawn(request):
    """Return a figure's axes, the boxes of its texts and of its markers, and its leaders."""
    rows = SHIPPED[request.param]
    with mpl.rc_context(STYLE):
        figure = draw(rows)
    figure.draw_without_rendering()
    axes = figure.axes[0]
    texts = {text.get_text(): text.get_window_extent() for text in axes.texts}
    assert len(texts) == len(axes.texts)
    leaders = [
        line.get_transform().transform(np.column_stack(line.get_data()))
        for line in axes.lines
        if line.get_transform() == axes.transAxes
    ]
    return axes, texts, markers(axes, rows, figure.dpi / 72), leaders


def markers(axes, rows, pixels_per_point):
    timed = [row for row in rows if row["cost"] and row["family"] != "none"]
    assert len(timed) > 4
    found = []
    for row in timed:
        x, y = axes.transData.transform((row["cost"], row["rms"]))
        reach = (MARKER_PT if row["counts"] else RING_PT) / 2 * pixels_per_point
        found.append(Bbox([[x - reach, y - reach], [x + reach, y + reach]]))
    return found


def overlap(a, b):
    return max(0, min(a.x1, b.x1) - max(a.x0, b.x0)) * max(0, min(a.y1, b.y1) - max(a.y0, b.y0))


@pytest.mark.slow
def test_no_label_lies_on_another_or_on_a_marker(drawn):
    _, texts, found, _ = drawn
    for (a, first), (b, second) in combinations(texts.items(), 2):
        assert overlap(first, second) == 0, (a, b)
    for name, box in texts.items():
        assert not any(overlap(box, marker) for marker in found), name


@pytest.mark.slow
def test_labels_are_inside_the_axes_and_names_of_lines_beside_them(drawn):
    axes, texts, _, _ = drawn
    inside, canvas = axes.get_window_extent(), axes.figure.bbox
    for name, box in texts.items():
        if name in {"no blur", "ideal scatter (R2)", "R1's own error"}:
            assert inside.x1 < box.x0 < box.x1 < canvas.x1, name
        else:
            assert inside.x0 < box.x0 < box.x1 < inside.x1, name
            assert inside.y0 < box.y0 < box.y1 < inside.y1, name


@pytest.mark.slow
def test_a_line_ends_at_one_label_and_crosses_no_other(drawn):
    _, texts, _, leaders = drawn
    for start, end in leaders:
        points = start + (end - start) * np.linspace(0, 1, 200)[:, None]
        met = [name for name, box in texts.items() if box.padded(1.5).count_contains(points)]
        assert len(met) == 1, met


@pytest.mark.slow
def test_every_method_with_a_cost_is_named(drawn):
    axes, texts, found, _ = drawn
    steps = [number for name in texts for part in name.split(", ") for number in listed(part, axes)]
    assert len(steps) == len(found)


def listed(part, axes):
    """Return the methods that a label's part names; none of a line's name."""
    if part in {"no blur", "ideal scatter (R2)", "R1's own error"}:
        return []
    ends = re.match(r"(\d+)–(\d+) (\w+)", part)
    if not ends:
        return [part]
    title = axes.get_title(loc="left")
    dial = [
        row for key, rows in SHIPPED.items() if title.startswith(key.split()[0]) for row in rows
    ]
    word = ends[3].removesuffix("s")
    names = {row["method"]: row["step"] for row in dial if row["step"] and word in row["method"]}
    return [name for name, step in names.items() if int(ends[1]) <= step <= int(ends[2])]


def ring(step, cost, rms=0.01, dial="rings"):
    name = f"ours {step} {dial}"
    return {"method": name, "step": step, "cost": cost, "rms": rms, "family": "ours"}


def test_methods_that_coincide_have_one_label():
    rows = [ring(1, 10), ring(2, 10.1), ring(3, 10.2), ring(2, 10.1, dial="taps"), ring(9, 30)]
    at = np.array([[10.0, 5, 4], [36, 5, 4], [23, 5, 4], [36, 5, 4], [60, 5, 4]])
    groups = coinciding(rows, at)
    assert groups == [[0, 1, 2, 3], [4]]
    assert joined(rows[:4]) == "1–3 rings, 2 taps"
    assert joined(rows[4:]) == "9 rings"
    other = [rows[0], {**rows[1], "rms": 0.011}]
    assert coinciding(other, at * 2) == [[0], [1]]
    assert coinciding([{**rows[0], "step": None}, rows[1]], at * 0) == [[0], [1]]


@pytest.mark.slow
def test_a_place_is_found_in_a_crowd():
    """Nine markers in a row, whose labels are four times as wide as the gaps between them."""
    at = np.array([[100.0 + 10 * i, 100, 3] for i in range(9)])
    crowd = figures.Crowd(np.array([0.0, 0, 280, 200]), at, np.zeros((0, 2, 2)))
    boxes = [Bbox([b[:2], b[2:]]) for b in figures.place([(40, 10)] * 9, at, crowd)]
    assert all(overlap(a, b) == 0 for a, b in combinations(boxes, 2))
    assert all(box.y1 < 97 or box.y0 > 103 or box.x1 < 97 or box.x0 > 183 for box in boxes)
    assert figures.place([], np.zeros((0, 3)), crowd) == []


def test_lines_that_cross_lines_and_boxes_are_found():
    line = np.array([[[0.0, 0], [20, 20]]])
    others = np.array([[[0.0, 20], [20, 0]], [[30.0, 0], [30, 90]], [[0.0, 10], [8, 20]]])
    assert figures._cross(line, others).tolist() == [[True, False, False]]
    ways = np.array([[[-50.0, 5], [50, 5]], [[-50.0, 50], [50, 50]], [[-50.0, 5], [-20, 5]]])
    box = np.array([[0.0, 0, 10, 10]])
    assert figures._hits(box, ways).tolist() == [[True, False, False]]


def test_a_line_leads_from_the_rim_to_the_nearest_point():
    marker = np.array([10.0, 10, 3])
    line = figures.leader(np.array([30.0, 5, 50, 15]), marker)
    np.testing.assert_allclose(line, [[13, 10], [30, 10]])
    assert figures.leader(np.array([15.0, 5, 35, 15]), marker) is None
    assert math.hypot(15 - 10, 0) - 3 < figures.LEADER_PX
