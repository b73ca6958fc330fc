"""Things to look at closely. Each stands on the origin, faces +Z, and is a list of parts.

`detail` from 1 down to about 0.25 scales the number of triangles.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from .mesh import Array, Mesh, grid, join, numbers, smooth
from .shapes import ball, box, cube_mapped, lathe, loft, tube

Parts: TypeAlias = list[tuple[Mesh, str]]


"""(triangles, name of their material)."""


def placed(
    parts: Parts, x: float, y: float, z: float, turn_deg: float = 0.0, size: float = 1.0
) -> Parts:
    """Return the parts scaled, turned about +Y and moved."""
    return [(mesh.scaled(size).turned("y", turn_deg).at(x, y, z), name) for mesh, name in parts]


def few(full: int, detail: float, least: int = 6) -> int:
    """Return a number of segments for a level of detail."""
    return max(least, round(full * detail))


def column(detail: float = 1.0, *, height: float = 4.6, radius: float = 0.3) -> Parts:
    """Return a fluted column with a moulded base and a lotus capital."""
    h, r = height, radius
    base = numbers(
        "1.36 0.16, 1.42 0.2, 1.42 0.25, 1.36 0.29, 1.2 0.31, 1.18 "
        "0.36, 1.26 0.39, 1.26 0.43, 1.18 0.46, 1.04 0.48, 1 0.56"
    )
    far = detail < 0.3
    low = lathe(
        [(r * a, y) for a, y in (base[::4] + base[-1:] if far else base)],
        segments=few(32, detail, 10),
        crease_deg=50,
        uv=(2, 0.4),
    )
    flutes = 16 if detail > 0.6 else 0

    def fluted(angle: Array, y: Array) -> Array:
        # Flutes run out before the ends, so that the shaft meets its base and capital all around.
        ends = np.minimum((y - 0.56) / 0.08, (h - 0.73 - y) / 0.08)
        return 1 - 0.085 * np.abs(np.sin(angle * 8)) * np.clip(ends, 0, 1)

    foot, neck = ([(r, 0.64)], [(r * 0.86, h - 0.81)]) if flutes else ([], [])
    shaft = lathe(
        [(r, 0.555), *foot, (r * 0.965, 2.0), *neck, (r * 0.86, h - 0.71)],
        segments=flutes * 4 if flutes else few(32, detail, 10),
        radius=fluted if flutes else None,
        uv=(2, 2.4),
    )
    top = numbers(
        "0.85 -0.72, 0.95 -0.7, 0.95 -0.64, 0.86 -0.62, 0.9 -0.5, 1.06 -0.36, "
        "1.34 -0.2, 1.42 -0.14, 1.3 -0.12, 0 -0.12"
    )

    def petals(angle: Array, y: Array) -> Array:
        return 1 + 0.07 * np.abs(np.cos(angle * 8)) * ((y > h - 0.6) & (y < h - 0.13))

    cap = lathe(
        [(r * a, h + y) for a, y in (top[::3] + top[-1:] if far else top)],
        segments=48 if detail > 0.6 else few(32, detail, 10),
        radius=petals if detail > 0.6 else None,
        crease_deg=60,
        uv=(2, 0.5),
    )
    plinth = box([r * 3, 0.16, r * 3], bevel_m=0.0 if far else 0.02)
    abacus = box([r * 2.9, 0.12, r * 2.9]).at(0, h - 0.12)
    return [(join([low, shaft, cap, cube_mapped(join([plinth, abacus]))]), "marble")]


def pedestal(detail: float = 1.0, *, height: float = 0.95, width: float = 0.5) -> Parts:
    """Return a square pedestal with mouldings and an inscribed die."""
    w, h = width, height
    steps = [
        (1.3, 0.0, 0.09),
        (1.2, 0.09, 0.05),
        (1.1, h - 0.17, 0.05),
        (1.22, h - 0.12, 0.05),
        (1.32, h - 0.07, 0.07),
    ]
    trim = [
        box([w * s, t, w * s], bevel_m=0.012 if detail > 0.5 else 0.0).at(0, y) for s, y, t in steps
    ]
    die = box([w, h - 0.3, w], bottom=False, uv_m=1.2).at(0, 0.14)
    parts: Parts = [(cube_mapped(join(trim)), "marble"), (die, "inscription")]
    if detail > 0.6:
        beads = [ball(0.014, segments=4, rings=3).at(x, h - 0.125, z) for x, z in _rim(w * 0.58, 7)]
        parts.append((join(beads), "gold"))
    return parts


def _rim(half: float, count: int) -> list[tuple[float, float]]:
    """Return places along the four sides of a square."""
    line = np.linspace(-half, half, count)[:-1]
    return [p for t in line for p in ((t, half), (half, -t), (-t, -half), (-half, t))]


def amphora(detail: float = 1.0, *, height: float = 0.75) -> Parts:
    """Return a painted amphora with two handles."""
    profile = numbers(
        "0 0, 0.17 0, 0.18 0.02, 0.13 0.045, 0.12 0.07, 0.2 0.16, 0.31 "
        "0.3, 0.37 0.44, 0.38 0.54, 0.34 0.65, 0.24 0.74, 0.16 0.79, "
        "0.145 0.84, 0.15 0.92, 0.19 0.97, 0.205 0.985, 0.2 1, 0.175 "
        "0.995, 0.13 0.92, 0.11 0.8, 0 0.79"
    )
    body = lathe(np.array(profile) * height * [0.9, 1], segments=few(36, detail, 12))
    parts: Parts = [(body, "vase")]
    if detail > 0.4:
        t = np.linspace(0, 1, few(12, detail))[:, None]
        path = np.concatenate(
            [0.14 + 0.2 * np.sin(np.pi * t) ** 0.8 + 0.12 * t, 0.92 - 0.27 * t, 0 * t], axis=1
        )
        handle = tube(path * height, 0.022 * height, segments=few(8, detail, 5))
        parts.append((join([handle, handle.turned("y", 180)]).tinted([0.1, 0.08, 0.07]), "plaster"))
    return parts


def urn(detail: float = 1.0, *, height: float = 0.55) -> Parts:
    """Return a wide bronze urn with gadroons and a lid."""
    profile = numbers(
        "0 0, 0.24 0, 0.25 0.03, 0.15 0.07, 0.1 0.14, 0.12 0.18, 0.26 "
        "0.27, 0.4 0.42, 0.45 0.58, 0.42 0.7, 0.36 0.74, 0.4 0.77, 0.41 "
        "0.79, 0.3 0.85, 0.14 0.91, 0.05 0.93, 0.07 0.96, 0.05 0.995, 0 1"
    )

    def lobes(angle: Array, y: Array) -> Array:
        return 1 + 0.045 * np.abs(np.sin(angle * 10)) * ((y > 0.2 * height) & (y < 0.55 * height))

    body = lathe(
        np.array(profile) * height,
        segments=60 if detail > 0.6 else few(32, detail, 10),
        radius=lobes,
    )
    return [(body, "bronze")]


def statue(detail: float = 1.0) -> Parts:
    """Return a hooded figure, 1.86 m, that holds a bowl."""
    shape = np.array(
        numbers(
            "0 0.37 0.3 0.05 0, 0.05 0.365 0.295 0.052 0, 0.5 0.29 "
            "0.235 0.042 0, 0.9 0.235 0.19 0.026 0, 1.12 0.205 0.155 "
            "0.014 0, 1.26 0.225 0.165 0.01 0, 1.38 0.255 0.165 0.007 "
            "0, 1.46 0.235 0.15 0.006 0, 1.51 0.165 0.135 0.006 0, "
            "1.545 0.125 0.128 0.004 0.6, 1.62 0.13 0.15 0.002 1, 1.7 "
            "0.13 0.155 0.002 1, 1.77 0.115 0.14 0 0.7, 1.83 0.075 0.1 "
            "0 0.1, 1.855 0.03 0.05 0 0, 1.86 0 0 0 0"
        )
    )
    y = np.concatenate(
        [np.linspace(0, 1.5, few(20, detail, 9)), np.linspace(1.53, 1.86, few(14, detail, 6))]
    )
    rx, rz, fold, hood = (np.interp(y, shape[:, 0], shape[:, c])[:, None] for c in range(1, 5))
    angle = np.linspace(0, 2 * np.pi, few(56, detail, 18), endpoint=False)[None]
    level = y[:, None]
    folds = fold * (
        np.sin(11 * angle + 1.8 * np.sin(2 * angle) + 0.9 * level)
        + 0.5 * np.sin(23 * angle - level)
    )
    front = np.exp(-((np.minimum(angle, 2 * np.pi - angle) / 0.52) ** 4))
    recess = (
        hood
        * front
        * (0.055 - 0.02 * np.exp(-((np.minimum(angle, 2 * np.pi - angle) / 0.16) ** 2)))
    )
    x = (rx + folds) * np.sin(angle)
    z = (rz + folds - recess) * np.cos(angle) + 0.02 * hood
    body = loft(np.stack([x, np.broadcast_to(level, x.shape), z], axis=-1), uv=(2, 2.5))
    arm = np.array(
        numbers(
            "0.19 1.4 0, 0.27 1.3 0.02, 0.29 1.16 0.05, 0.25 1.07 0.15, 0.15 1.09 "
            "0.27, 0.075 1.115 0.33"
        )
    )
    sleeve = tube(arm, [0.075, 0.082, 0.08, 0.085, 0.082, 0.05], segments=few(12, detail))
    hand = (
        ball(0.042, segments=few(12, detail), rings=few(6, detail, 4))
        .scaled(0.9, 0.7, 1.3)
        .at(0.06, 1.115, 0.36)
    )
    arms = join([sleeve, hand])
    pieces = join([body, arms, arms.scaled(-1, 1, 1)])
    dish = numbers(
        "0 0, 0.05 0, 0.045 0.015, 0.1 0.035, 0.135 0.075, 0.125 0.075, 0.09 0.045, 0 0.04"
    )
    return [
        (pieces, "marble"),
        (lathe(dish, segments=few(28, detail, 10), crease_deg=50).at(0, 1.135, 0.38), "gold"),
    ]


def obelisk(detail: float = 1.0, *, height: float = 2.3) -> Parts:
    """Return an inscribed, gold-capped obelisk."""
    w, top = 0.27, 0.17
    faces = []
    for turn in range(4):
        across = np.linspace(-1, 1, 3)[None, :, None]
        up = np.linspace(0, 1, few(6, detail, 2))[:, None, None]
        half = w + (top - w) * up
        points = np.concatenate(
            [across * half, 0.2 + up * (height - 0.4) + 0 * across, half + 0 * across], axis=2
        )
        uvs = np.concatenate(
            [across * 0.22 + 0.22 * turn + 0 * up, -up * (height - 0.4) / 1.2 + 0 * across], axis=2
        )
        faces.append(grid(points, uvs).turned("y", 90 * turn))
    cap = smooth(lathe([(top * 1.42, height - 0.2), (0, height)], segments=4).turned("y", 45), 10)
    foot = box([0.72, 0.2, 0.72], bevel_m=0.03)
    return [(join(faces), "inscription"), (cap, "gold"), (foot, "marble")]


def sarcophagus(detail: float = 1.0) -> Parts:
    """Return an inscribed stone chest with a ridged lid, 2.2 m long (along X)."""
    chest = box([2.2, 0.75, 0.95], bevel_m=0.03 if detail > 0.5 else 0, uv_m=1.1).at(0, 0.12)
    foot = box([2.4, 0.12, 1.15], bevel_m=0.02)
    half = numbers("0 0.5, 0.07 0.53, 0.12 0.5, 0.24 0.28, 0.3 0.1, 0.31 0")
    section = [(y, z) for y, z in half] + [(y, -z) for y, z in half[-2::-1]]
    rows = np.array(
        [
            [(x, 0.87 + y, z) for y, z in section]
            for x in np.linspace(-1.14, 1.14, few(9, detail, 2))
        ]
    )
    uvs = np.stack([rows[..., 0] / 1.1, rows[..., 2] / 1.1], axis=-1)
    lid = smooth(grid(rows, uvs, flip=True), 40)
    ends = [
        grid(
            np.array(
                [
                    [(s * 1.14, 0.87, z) for _, z in section],
                    [(s * 1.14, 0.87 + y, z) for y, z in section],
                ]
            ),
            np.zeros((2, len(section), 2)),
        )
        for s in (1, -1)
    ]
    ends[1] = Mesh(ends[1].positions, -ends[1].normals, ends[1].uvs, ends[1].indices[:, ::-1])
    return [(chest, "inscription"), (foot, "marble"), (join([lid, *ends]), "marble")]


def basin(detail: float = 1.0) -> Parts:
    """Return a round fountain basin, 1.7 m wide, with a raised bowl and still water."""
    rim = numbers(
        "0 0.1, 0.66 0.1, 0.7 0.14, 0.72 0.42, 0.7 0.46, 0.74 0.5, 0.84 0.5, "
        "0.86 0.46, 0.83 0.42, 0.82 0.1, 0.9 0.06, 0.9 0"
    )[::-1]
    foot = numbers(
        "0.16 0.1, 0.12 0.3, 0.09 0.6, 0.12 0.72, 0.3 0.8, 0.4 0.92, 0.42 "
        "0.96, 0.38 0.96, 0.34 0.9, 0.08 0.84, 0.05 1, 0.08 1.08, 0 1.14"
    )

    def lobes(angle: Array, y: Array) -> Array:
        return 1 + 0.03 * np.cos(angle * 12) * (y > 0.78) * (y < 0.97)

    stone = join(
        [
            lathe(rim, segments=few(48, detail, 16), crease_deg=50, uv=(4, 1)),
            lathe(foot, segments=few(48, detail, 12), radius=lobes, uv=(2, 1)),
        ]
    )
    water = lathe([(0.715, 0.40), (0.1, 0.40)], segments=few(32, detail, 16))
    return [(stone, "marble"), (water, "water")]
