"""Things to look at closely. Each stands on the origin, faces +Z, and is a list of parts.

`detail` from 1 down to about 0.25 scales the number of triangles.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from .mesh import Array, Mesh, ball, box, cube_mapped, join, lathe, loft, ring, smooth, tube, unit

Parts: TypeAlias = list[tuple[Mesh, str]]
"""(triangles, name of their material)."""


def placed(parts: Parts, x: float, y: float, z: float, turn_deg: float = 0.0, size: float = 1.0) -> Parts:
    """Return the parts scaled, turned about +Y and moved."""
    return [(mesh.scaled(size).turned("y", turn_deg).at(x, y, z), name) for mesh, name in parts]


def _n(full: int, detail: float, least: int = 6) -> int:
    return max(least, round(full * detail))


def column(detail: float = 1.0, *, height: float = 4.6, radius: float = 0.3) -> Parts:
    """Return a fluted column with a moulded base and a lotus capital."""
    h, r = height, radius
    base = [(0, 0.16), (1.36, 0.16), (1.42, 0.2), (1.42, 0.25), (1.36, 0.29), (1.2, 0.31), (1.18, 0.36),
            (1.26, 0.39), (1.26, 0.43), (1.18, 0.46), (1.04, 0.48), (1.0, 0.56)]  # fmt: skip
    low = lathe([(r * a, y) for a, y in base], segments=_n(32, detail, 10), crease_deg=50, uv=(2, 0.4))
    flutes = 16 if detail > 0.6 else 0
    shaft = lathe(
        [(r, 0.56), (r * 0.98, 1.6), (r * 0.94, 2.6), (r * 0.86, h - 0.72)],
        segments=flutes * 3 if flutes else _n(32, detail, 10),
        radius=(lambda angle, y: 1 - 0.055 * np.abs(np.sin(angle * 8)) + 0 * y) if flutes else None,
        uv=(2, 2.4),
    )
    top = [(0.86, -0.72), (0.95, -0.7), (0.95, -0.64), (0.86, -0.62), (0.9, -0.5), (1.06, -0.36),
           (1.34, -0.2), (1.42, -0.14), (1.3, -0.12), (0, -0.12)]  # fmt: skip
    petals = (lambda angle, y: 1 + 0.07 * np.abs(np.cos(angle * 8)) * ((y > h - 0.6) & (y < h - 0.13)))
    cap = lathe([(r * a, h + y) for a, y in top], segments=48 if detail > 0.6 else _n(32, detail, 10),
                radius=petals if detail > 0.6 else None, crease_deg=60, uv=(2, 0.5))  # fmt: skip
    plinth = box([r * 3, 0.16, r * 3], bevel_m=0.02)
    abacus = box([r * 2.9, 0.12, r * 2.9], bevel_m=0.015).at(0, h - 0.12)
    return [(join([low, shaft, cap, cube_mapped(join([plinth, abacus]))]), "marble")]


def pedestal(detail: float = 1.0, *, height: float = 0.95, width: float = 0.5) -> Parts:
    """Return a square pedestal with mouldings and an inscribed die."""
    w, h = width, height
    steps = [(1.3, 0.0, 0.09), (1.2, 0.09, 0.05), (1.1, h - 0.17, 0.05), (1.22, h - 0.12, 0.05), (1.32, h - 0.07, 0.07)]
    trim = [box([w * s, t, w * s], bevel_m=0.012 if detail > 0.5 else 0.0).at(0, y) for s, y, t in steps]
    die = box([w, h - 0.3, w], bottom=False, uv_m=1.2).at(0, 0.14)
    parts: Parts = [(cube_mapped(join(trim)), "marble"), (die, "inscription")]
    if detail > 0.6:
        beads = [ball(0.014, segments=6, rings=4).at(x, h - 0.125, z) for x, z in _rim(w * 0.58, 7)]
        parts.append((join(beads), "gold"))
    return parts


def _rim(half: float, count: int) -> list[tuple[float, float]]:
    """Return places along the four sides of a square."""
    line = np.linspace(-half, half, count)[:-1]
    return [p for t in line for p in ((t, half), (half, -t), (-t, -half), (-half, t))]


def amphora(detail: float = 1.0, *, height: float = 0.75) -> Parts:
    """Return a painted amphora with two handles."""
    profile = [(0.0, 0.0), (0.17, 0.0), (0.18, 0.02), (0.13, 0.045), (0.12, 0.07), (0.2, 0.16), (0.31, 0.3),
               (0.37, 0.44), (0.38, 0.54), (0.34, 0.65), (0.24, 0.74), (0.16, 0.79), (0.145, 0.84), (0.15, 0.92),
               (0.19, 0.97), (0.205, 0.985), (0.2, 1.0), (0.175, 0.995), (0.13, 0.92), (0.11, 0.8), (0.0, 0.79)]  # fmt: skip
    body = lathe(np.array(profile) * height * [0.9, 1], segments=_n(40, detail, 12))
    parts: Parts = [(body, "vase")]
    if detail > 0.4:
        t = np.linspace(0, 1, _n(12, detail))[:, None]
        path = np.concatenate([0.14 + 0.2 * np.sin(np.pi * t) ** 0.8 + 0.12 * t, 0.92 - 0.27 * t, 0 * t], axis=1)
        handle = tube(path * height, 0.022 * height, segments=_n(8, detail, 5))
        parts.append((join([handle, handle.turned("y", 180)]).tinted([0.1, 0.08, 0.07]), "plaster"))
    return parts


def urn(detail: float = 1.0, *, height: float = 0.55) -> Parts:
    """Return a wide bronze urn with gadroons and a lid."""
    profile = [(0.0, 0.0), (0.24, 0.0), (0.25, 0.03), (0.15, 0.07), (0.1, 0.14), (0.12, 0.18), (0.26, 0.27), (0.4, 0.42),
               (0.45, 0.58), (0.42, 0.7), (0.36, 0.74), (0.4, 0.77), (0.41, 0.79), (0.3, 0.85), (0.14, 0.91),
               (0.05, 0.93), (0.07, 0.96), (0.05, 0.995), (0.0, 1.0)]  # fmt: skip
    lobes = lambda angle, y: 1 + 0.045 * np.abs(np.sin(angle * 10)) * ((y > 0.2 * height) & (y < 0.55 * height))  # noqa: E731
    body = lathe(np.array(profile) * height, segments=60 if detail > 0.6 else _n(32, detail, 10), radius=lobes)
    return [(body, "bronze")]


def statue(detail: float = 1.0) -> Parts:
    """Return a hooded figure, 1.86 m, that holds a bowl."""
    shape = np.array([
        (0.0, 0.37, 0.30, 0.050, 0), (0.05, 0.365, 0.295, 0.052, 0), (0.5, 0.29, 0.235, 0.042, 0), (0.9, 0.235, 0.19, 0.026, 0),
        (1.12, 0.205, 0.155, 0.014, 0), (1.26, 0.225, 0.165, 0.010, 0), (1.38, 0.255, 0.165, 0.007, 0), (1.46, 0.235, 0.15, 0.006, 0),
        (1.51, 0.165, 0.135, 0.006, 0), (1.545, 0.125, 0.128, 0.004, 0.6), (1.62, 0.13, 0.15, 0.002, 1), (1.70, 0.13, 0.155, 0.002, 1),
        (1.77, 0.115, 0.14, 0.0, 0.7), (1.83, 0.075, 0.1, 0.0, 0.1), (1.855, 0.03, 0.05, 0, 0), (1.86, 0.0, 0.0, 0, 0),
    ])  # fmt: skip
    y = np.concatenate([np.linspace(0, 1.5, _n(20, detail, 9)), np.linspace(1.53, 1.86, _n(14, detail, 6))])
    rx, rz, fold, hood = (np.interp(y, shape[:, 0], shape[:, c])[:, None] for c in range(1, 5))
    angle = np.linspace(0, 2 * np.pi, _n(56, detail, 18), endpoint=False)[None]
    level = y[:, None]
    folds = fold * (np.sin(11 * angle + 1.8 * np.sin(2 * angle) + 0.9 * level) + 0.5 * np.sin(23 * angle - level))
    front = np.exp(-((np.minimum(angle, 2 * np.pi - angle) / 0.52) ** 4))
    recess = hood * front * (0.055 - 0.02 * np.exp(-((np.minimum(angle, 2 * np.pi - angle) / 0.16) ** 2)))
    x = (rx + folds) * np.sin(angle)
    z = (rz + folds - recess) * np.cos(angle) + 0.02 * hood
    body = loft(np.stack([x, np.broadcast_to(level, x.shape), z], axis=-1), uv=(2, 2.5))
    arm = np.array([(0.19, 1.40, 0.0), (0.27, 1.30, 0.02), (0.29, 1.16, 0.05), (0.25, 1.07, 0.15), (0.15, 1.09, 0.27), (0.075, 1.115, 0.33)])
    sleeve = tube(arm, [0.075, 0.082, 0.08, 0.085, 0.082, 0.05], segments=_n(12, detail))
    hand = ball(0.042, segments=_n(12, detail), rings=_n(6, detail, 4)).scaled(0.9, 0.7, 1.3).at(0.06, 1.115, 0.36)
    arms = join([sleeve, hand])
    pieces = join([body, arms, arms.scaled(-1, 1, 1)])
    dish = [(0.0, 0.0), (0.05, 0.0), (0.045, 0.015), (0.1, 0.035), (0.135, 0.075), (0.125, 0.075), (0.09, 0.045), (0, 0.04)]
    return [(pieces, "marble"), (lathe(dish, segments=_n(28, detail, 10)).at(0, 1.135, 0.38), "gold")]


def obelisk(detail: float = 1.0, *, height: float = 2.3) -> Parts:
    """Return an inscribed, gold-capped obelisk."""
    w, top = 0.27, 0.17
    faces = []
    for turn in range(4):
        across = np.linspace(-1, 1, 3)[None, :, None]
        up = np.linspace(0, 1, _n(6, detail, 2))[:, None, None]
        half = w + (top - w) * up
        points = np.concatenate([across * half, 0.2 + up * (height - 0.4) + 0 * across, half + 0 * across], axis=2)
        uvs = np.concatenate([across * 0.22 + 0.22 * turn + 0 * up, -up * (height - 0.4) / 1.2 + 0 * across], axis=2)
        faces.append(_sheet(points, uvs).turned("y", 90 * turn))
    cap = smooth(lathe([(top * 1.42, height - 0.2), (0, height)], segments=4).turned("y", 45), 10)
    foot = box([0.72, 0.2, 0.72], bevel_m=0.03)
    return [(join(faces), "inscription"), (cap, "gold"), (foot, "marble")]


def _sheet(points: Array, uvs: Array) -> Mesh:
    from .mesh import grid  # noqa: PLC0415

    return grid(points, uvs)


def brazier(detail: float = 1.0) -> Parts:
    """Return a tripod with a bowl of embers and a flame, 1.35 m to the rim."""
    bowl = [(0.0, 1.02), (0.12, 1.03), (0.26, 1.12), (0.33, 1.28), (0.35, 1.34), (0.32, 1.34), (0.29, 1.27), (0.0, 1.25)]
    parts: Parts = [(lathe(bowl, segments=_n(36, detail, 12), crease_deg=60), "bronze")]
    leg = tube([(0.26, 1.14, 0), (0.2, 0.8, 0), (0.17, 0.45, 0), (0.24, 0.14, 0), (0.36, 0.0, 0)], [0.02, 0.022, 0.02, 0.022, 0.03], segments=6)
    parts.append((join([leg.turned("y", t) for t in (90, 210, 330)] + [ring(0.175, 0.012, segments=_n(24, detail), sides=5).at(0, 0.5)]), "bronze"))
    rng = np.random.default_rng(5)
    coals = [ball(0.05, segments=6, rings=4).scaled(1, 0.7, 1).at(*(rng.uniform(-0.17, 0.17, 2)[[0]]), 1.28, rng.uniform(-0.17, 0.17)) for _ in range(_n(14, detail))]
    parts.append((join(coals), "ember"))
    parts.append((flame(detail).at(0, 1.28), "flame"))
    return parts


def flame(detail: float = 1.0) -> Mesh:
    """Return three licking tongues, 0.35 m."""
    y = np.linspace(0, 1, _n(9, detail, 5))
    tongues = []
    for turn, height, lean in ((0, 0.36, 0.05), (130, 0.27, 0.09), (250, 0.22, 0.08)):
        path = np.stack([0.05 + lean * np.sin(3.5 * y), y * height, 0.03 * np.sin(5 * y + turn)], axis=1)
        tongues.append(tube(path, 0.075 * (1 - y) ** 0.7 * (0.5 + 2.2 * y * (1 - y) + 0.25) + 0.001, segments=7).turned("y", turn))
    return join(tongues)


def candle(height: float = 0.16) -> Parts:
    """Return a candle with its flame."""
    wax = lathe([(0, 0), (0.026, 0), (0.026, height), (0.018, height - 0.004), (0, height - 0.008)], segments=10, crease_deg=50)
    tip = lathe([(0, height), (0.009, height + 0.018), (0.006, height + 0.035), (0, height + 0.055)], segments=6)
    return [(wax.tinted([0.95, 0.88, 0.72]), "plaster"), (tip, "flame")]


def lamp_stand(detail: float = 1.0) -> Parts:
    """Return a bronze stand with five candles."""
    stem = [(0.0, 0.0), (0.2, 0.0), (0.19, 0.03), (0.06, 0.07), (0.03, 0.14), (0.025, 0.5), (0.045, 0.54), (0.025, 0.58), (0.022, 1.05), (0.06, 1.1), (0.0, 1.12)]
    parts: Parts = [(lathe(stem, segments=_n(20, detail, 8), crease_deg=60), "bronze")]
    for index in range(5):
        angle = 2 * np.pi * index / 5
        x, z = 0.2 * np.cos(angle), 0.2 * np.sin(angle)
        branch = tube([(0, 1.0, 0), (x * 0.6, 0.96, z * 0.6), (x, 1.04, z), (x, 1.14, z)], 0.011, segments=5)
        dish = lathe([(0, 0), (0.02, 0), (0.045, 0.015), (0.04, 0.02), (0, 0.012)], segments=10)
        parts += [(join([branch, dish.at(x, 1.13, z)]), "bronze"), *placed(candle(0.11 + 0.02 * (index % 3)), x, 1.145, z)]
    return parts


def potted_palm(seed: int, *, leaves: int = 14, reach: float = 1.0) -> Parts:
    """Return a terracotta pot with arching fronds."""
    pot = lathe([(0, 0), (0.2, 0), (0.23, 0.1), (0.29, 0.42), (0.33, 0.43), (0.33, 0.5), (0.29, 0.5), (0.28, 0.44), (0, 0.43)], segments=24, crease_deg=50, uv=(2, 1))
    rng = np.random.default_rng(seed)
    fronds = [_frond(reach * rng.uniform(0.75, 1.15), rng.uniform(0.7, 1.35)).turned("y", 137.5 * i + rng.uniform(-15, 15)) for i in range(leaves)]
    return [(pot.tinted([0.62, 0.30, 0.18]), "plaster"), (join(fronds).at(0, 0.44), "frond")]


def _frond(length: float, lift: float) -> Mesh:
    """Return one frond, folded along its stem, that rises along +X and falls."""
    t = np.linspace(0, 1, 6)
    angle = lift - 1.75 * t**1.3
    path = np.concatenate([[[0, 0]], np.cumsum(np.stack([np.cos(angle), np.sin(angle)], 1)[:-1] * length / 5, axis=0)])
    width = 0.2 * length * np.array([0.35, 0.9, 1, 0.9, 0.7, 0.25])
    points = np.stack([
        np.stack([path[:, 0], path[:, 1] + 0.28 * width * (1 - abs(s)) - 0.1 * width, s * width], axis=1) for s in (1, 0, -1)
    ], axis=1)  # fmt: skip
    uvs = np.stack(np.broadcast_arrays(np.array([1, 0.5, 0])[None], 1 - t[:, None]), axis=-1)
    sheet = _sheet(points, uvs)
    # Leaves scatter light: normals lean towards the sky.
    soft = unit(sheet.normals * 0.6 + [0, 0.8, 0])
    return Mesh(sheet.positions, soft, sheet.uvs, sheet.indices)


def sarcophagus(detail: float = 1.0) -> Parts:
    """Return an inscribed stone chest with a ridged lid, 2.2 m long (along X)."""
    chest = box([2.2, 0.75, 0.95], bevel_m=0.03 if detail > 0.5 else 0, uv_m=1.1).at(0, 0.12)
    foot = box([2.4, 0.12, 1.15], bevel_m=0.02)
    half = [(0.0, 0.50), (0.07, 0.53), (0.12, 0.5), (0.24, 0.28), (0.3, 0.1), (0.31, 0.0)]
    section = [(y, z) for y, z in half] + [(y, -z) for y, z in half[-2::-1]]
    rows = np.array([[(x, 0.87 + y, z) for y, z in section] for x in np.linspace(-1.14, 1.14, _n(9, detail, 2))])
    uvs = np.stack([rows[..., 0] / 1.1, rows[..., 2] / 1.1], axis=-1)
    lid = smooth(_sheet(rows, uvs), 40)
    ends = [_sheet(np.array([[(s * 1.14, 0.87, z) for _, z in section], [(s * 1.14, 0.87 + y, z) for y, z in section]]),
                   np.zeros((2, len(section), 2))) for s in (1, -1)]  # fmt: skip
    ends[1] = Mesh(ends[1].positions, -ends[1].normals, ends[1].uvs, ends[1].indices[:, ::-1])
    return [(chest, "inscription"), (foot, "marble"), (join([lid, *ends]), "marble")]


def basin(detail: float = 1.0) -> Parts:
    """Return a round fountain basin, 1.7 m wide, with a raised bowl and still water."""
    rim = [(0.0, 0.1), (0.66, 0.1), (0.7, 0.14), (0.72, 0.42), (0.70, 0.46), (0.74, 0.5), (0.84, 0.5), (0.86, 0.46), (0.83, 0.42), (0.82, 0.1), (0.9, 0.06), (0.9, 0.0)][::-1]
    foot = [(0.16, 0.1), (0.12, 0.3), (0.09, 0.6), (0.12, 0.72), (0.3, 0.8), (0.4, 0.92), (0.42, 0.96), (0.38, 0.96), (0.34, 0.9), (0.08, 0.84), (0.05, 1.0), (0.08, 1.08), (0.0, 1.14)]
    lobes = lambda angle, y: 1 + 0.03 * np.cos(angle * 12) * (y > 0.78) * (y < 0.97)  # noqa: E731
    stone = join([lathe(rim, segments=_n(48, detail, 16), crease_deg=50, uv=(4, 1)),
                  lathe(foot, segments=_n(48, detail, 12), radius=lobes, uv=(2, 1))])  # fmt: skip
    water = lathe([(0.715, 0.40), (0.1, 0.40)], segments=_n(32, detail, 16))
    return [(stone, "marble"), (water, "water")]


def table(detail: float = 1.0, *, length: float = 2.4) -> Parts:
    """Return a wooden table with turned legs (long side along X), 0.78 m high."""
    top = box([length, 0.06, 0.85], bevel_m=0.012, uv_m=1.0).at(0, 0.72)
    leg_profile = [(0.035, 0), (0.03, 0.08), (0.045, 0.12), (0.03, 0.16), (0.042, 0.4), (0.03, 0.58), (0.05, 0.62), (0.045, 0.72)]
    leg = lathe(leg_profile, segments=_n(14, detail, 6), uv=(0.2, 0.7))
    legs = [leg.at(sx * (length / 2 - 0.12), 0, sz * 0.33) for sx in (1, -1) for sz in (1, -1)]
    rails = [box([length - 0.2, 0.1, 0.03]).at(0, 0.62, z) for z in (0.33, -0.33)]
    return [(join([top, *legs, *rails]), "wood")]


def scrolls(seed: int) -> Parts:
    """Return rolled and open scrolls and a small pot, about 0.9 m wide, lying on y = 0."""
    rng = np.random.default_rng(seed)
    roll = lathe([(0.0, -0.17), (0.028, -0.17), (0.03, 0), (0.028, 0.17), (0.0, 0.17)], segments=12, crease_deg=50)
    lying = roll.turned("z", 90)
    rolls = [lying.turned("y", rng.uniform(-30, 30)).at(x, y, z) for x, y, z in ((-0.3, 0.03, 0), (-0.28, 0.03, 0.08), (-0.29, 0.085, 0.04))]
    s = np.linspace(-1, 1, 11)
    sheet = np.stack([np.stack([0.15 + 0.0 * s + dx, 0.004 + 0.035 * np.abs(s) ** 6, 0.2 * s], axis=1) for dx in (0, 0.28)], axis=1)
    uvs = np.stack(np.broadcast_arrays(np.array([0.0, 0.25])[None], (s[:, None] + 1) * 0.2), axis=-1)
    paper = _sheet(sheet[::-1], uvs)
    return [(join(rolls).tinted([0.9, 0.8, 0.6]), "plaster"), (paper.tinted([1.0, 0.92, 0.75]), "paper")]


def bench(detail: float = 1.0, *, length: float = 1.8) -> Parts:
    """Return a stone bench on scrolled feet (long side along X)."""
    seat = box([length, 0.09, 0.45], bevel_m=0.015, uv_m=1.0).at(0, 0.38)
    foot = [(0.1, 0), (0.1, 0.04), (0.06, 0.08), (0.05, 0.2), (0.08, 0.3), (0.1, 0.38)]
    feet = [lathe(foot, segments=_n(20, detail, 8)).scaled(1, 1, 1.9).at(x, 0, 0) for x in (-length * 0.36, length * 0.36)]
    return [(join([seat, *feet]), "marble")]
