"""The hut and the wind pump of the mountain terrace."""

from __future__ import annotations

import itertools

import numpy as np

from .alpine import stone_block
from .mesh import Mesh, grid, join
from .ornaments import Parts
from .shapes import box, lathe, plane, ring, tube


def hut(detail: float = 1.0) -> Parts:
    """Return a log hut, 4.4 × 3.4 m, on a stone base; its door faces +Z."""
    w, d, wall = 4.4, 3.4, 2.2
    n = 7 if detail > 0.5 else 4
    base = [
        stone_block(200 + i, (0.62, 0.42, 0.4), detail=6 if detail > 0.5 else 3).at(x, -0.05, z)
        for i, (x, z) in enumerate(_around(w, d, 0.56))
    ]
    logs = []
    for row in range(11):
        y = 0.36 + row * 0.2
        for z in (d / 2, -d / 2):
            logs += (
                [_log(w + 0.5, n).at(0, y, z)]
                if z < 0 or row > 8
                else [_log(1.55, n).at(-1.65 + 0.03, y, z), _log(1.55, n).at(1.65 - 0.03, y, z)]
            )
        logs += [_log(d + 0.5, n).turned("y", 90).at(x, y + 0.1, 0) for x in (w / 2, -w / 2)]
    gables = [_gable(d, 1.1).at(s * (w / 2 - 0.02), wall + 0.28, 0) for s in (1, -1)]
    inner = box([w - 0.1, wall + 0.2, d - 0.1], uv_m=1.0).at(0, 0.2)
    roof_parts = _roof(w + 1.1, d + 0.9, wall + 0.25, 1.45)
    door = [
        box([1.15, 1.95, 0.06], uv_m=1.2).at(0, 0.3, d / 2 + 0.02),
        box([1.4, 0.1, 0.16]).at(0, 2.25, d / 2 + 0.03),
        *(box([0.12, 2.0, 0.16]).at(s * 0.65, 0.28, d / 2 + 0.03) for s in (1, -1)),
        box([0.04, 0.16, 0.05]).at(0.42, 1.15, d / 2 + 0.07),
    ]
    step = box([1.5, 0.18, 0.7], bevel_m=0.03).at(0, 0, d / 2 + 0.5)
    chimney = box([0.55, 1.6, 0.55], bevel_m=0.03, uv_m=1.0).at(-1.2, wall + 0.9, -0.5)
    return [
        (join([*base, step, chimney]), "granite"),
        (join([*logs, *gables]), "timber"),
        (join([inner, *door]), "planks"),
        (roof_parts, "shingles"),
    ]


def _around(w: float, d: float, step: float) -> list[tuple[float, float]]:
    across, along = np.arange(-w / 2, w / 2 + 0.01, step), np.arange(-d / 2, d / 2 + 0.01, step)
    return [(x, s * d / 2) for x in across for s in (1, -1)] + [
        (s * w / 2, z) for z in along for s in (1, -1)
    ]


def _log(length: float, segments: int) -> Mesh:
    """Return a log along X."""
    section = [
        (0.0, -length / 2),
        (0.098, -length / 2),
        (0.1, 0),
        (0.098, length / 2),
        (0.0, length / 2),
    ]
    return lathe(section, segments=segments, crease_deg=50, uv=(0.6, length)).turned("z", 90)


def _gable(width: float, rise: float) -> Mesh:
    """Return both sides of a triangle in the plane x = 0."""
    corners = np.array(
        [[[0, 0, width / 2], [0, 0, -width / 2]], [[0, rise, 0.001], [0, rise, -0.001]]]
    )
    sheet = grid(corners, corners[..., [2, 1]])
    return join([sheet, sheet.turned("y", 180)])


def _roof(width: float, depth: float, y: float, rise: float) -> Mesh:
    """Return two shingled slopes with a thickness of 12 cm (ridge along X)."""
    half, x = depth / 2, width / 2
    across, up = [width, 0, 0], [0, rise, -half]
    sheets = [
        plane([-x, 0, half], across, up, step_m=9, uv_m=1.6),
        plane([-x, -0.12, half], up, across, step_m=9, uv_m=1.6),
        plane([-x, -0.12, half], across, [0, 0.12, 0], step_m=9, uv_m=1.6),
    ]
    for side in (x, -x):
        low = [[side, -0.12, half], [side, rise - 0.12, 0]]
        edge = np.array([low, [[side, 0, half], [side, rise, 0]]])
        sheets.append(grid(edge, edge[..., [2, 1]], flip=side < 0))
    slope = join(sheets)
    return join([slope, slope.turned("y", 180)]).at(0, y)


def wind_wheel_tower(detail: float = 1.0) -> Parts:
    """Return the lattice tower of a wind pump, 6 m, without its wheel."""
    n = 6 if detail > 0.5 else 4
    legs, braces = [], []
    levels = [(0.0, 0.85), (1.7, 0.66), (3.3, 0.48), (4.8, 0.31), (6.0, 0.18)]
    for turn in range(4):
        path = [(h, y, h) for y, h in levels]
        legs.append(tube(path, 0.045, segments=n).turned("y", 90 * turn))
        for (y0, h0), (y1, h1) in itertools.pairwise(levels):
            braces.append(
                tube([(-h0, y0, h0), (h1, y1, h1)], 0.02, segments=4).turned("y", 90 * turn)
            )
            braces.append(
                tube([(-h1, y1, h1), (h1, y1, h1)], 0.022, segments=4).turned("y", 90 * turn)
            )
    head = box([0.3, 0.3, 0.55], bevel_m=0.03).at(0, 6.0, 0.05)
    vane = box([0.03, 0.6, 0.9]).at(0, 5.95, -1.45)
    boom = tube([(0, 6.15, -0.2), (0, 6.22, -1.5)], 0.03, segments=6)
    return [(join([*legs, *braces, head]), "timber"), (join([vane, boom]), "red_paint")]


def wind_wheel() -> Parts:
    """Return the wheel about its hub, facing +Z, 2.6 m wide."""
    blades = []
    for index in range(14):
        turn = 360 / 14 * index
        points = np.array(
            [
                [(x, r, 0.16 * x / 0.2 * (1.1 - 0.4 * r)) for x in (-w / 2, 0, w / 2)]
                for r, w in ((0.38, 0.1), (0.85, 0.2), (1.28, 0.29))
            ]
        )
        uvs = points[..., :2]
        blade = grid(points, uvs)
        blades.append(blade.turned("z", turn))
    rods = [
        tube([(0, 0, 0), (0, 1.15, 0)], 0.012, segments=4).turned("z", 360 / 7 * i)
        for i in range(7)
    ]
    rims = [ring(r, 0.014, segments=28, sides=3).turned("x", 90) for r in (0.6, 1.08)]
    hub = lathe(
        [(0, -0.1), (0.1, -0.1), (0.1, 0.1), (0.0, 0.18)], segments=12, crease_deg=40
    ).turned("x", 90)
    return [(join(blades), "blades"), (join([*rods, *rims, hub]), "iron")]
