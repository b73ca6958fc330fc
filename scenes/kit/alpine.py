"""Things of the mountain terrace: stones, wood, trees, a hut, a wind wheel, a bird."""

from __future__ import annotations

import itertools

import numpy as np

from .mesh import Array, Mesh, grid, join, smooth, unit
from .noise import gradient_noise
from .ornaments import Parts
from .shapes import ball, cube_mapped, lathe, tube


def stone_block(seed: int, size: tuple[float, float, float], *, detail: int = 12) -> Mesh:
    """Return a weathered boulder on the origin, about `size` wide, high and deep."""
    raw = ball(1.0, segments=detail + 4, rings=max(4, detail // 2 + 1))
    p = raw.positions
    shape = np.zeros(len(p))
    for axis, other in ((0, 1), (1, 2), (2, 0)):
        shape += gradient_noise(p[:, axis] * 1.3 + seed * 7.1, p[:, other] * 1.3 - seed * 3.7, seed)
    # Flattened sides: a stone has broken faces, not a skin.
    rng = np.random.default_rng(seed)
    q = p * (1 + 0.28 * shape[:, None])
    for normal in unit(rng.standard_normal((7, 3))):
        over = np.maximum(q @ normal - 0.72, 0)
        q = q - over[:, None] * normal * 0.85
    q = q * np.array(size) / 2
    q[:, 1] -= q[:, 1].min() + 0.06 * size[1]
    mesh = smooth(Mesh(q, raw.normals, raw.uvs, raw.indices), 38)
    return cube_mapped(mesh, 1.1)


def cairn(detail: float = 1.0) -> Parts:
    """Return a waymark of stacked stones, 1.35 m high."""
    rng = np.random.default_rng(3)
    stones, y, layer = [], -0.05, 0
    facets = 7 if detail > 0.5 else 4
    while y < 1.2:
        radius = 0.46 * (1 - y / 1.45)
        count = max(1, round(2 * np.pi * radius / 0.4))
        thick = rng.uniform(0.13, 0.19)
        for index in range(count):
            angle = 2 * np.pi * (index + 0.5 * (layer % 2)) / count + rng.uniform(-0.15, 0.15)
            r = radius * 0.72 if count > 1 else 0.0
            size = (rng.uniform(0.34, 0.46), thick * 1.35, rng.uniform(0.26, 0.34))
            stone = stone_block(100 + 10 * layer + index, size, detail=facets)
            stones.append(
                stone.turned("y", np.degrees(angle) + rng.uniform(-20, 20)).at(
                    r * np.sin(angle), y, r * np.cos(angle)
                )
            )
        y += thick
        layer += 1
    return [(join(stones), "granite")]


def signpost(detail: float = 1.0) -> Parts:
    """Return a post with three carved boards, 2.3 m high."""
    n = 12 if detail > 0.5 else 6
    post = lathe(
        [(0.075, 0), (0.065, 1.2), (0.06, 2.25), (0.0, 2.32)],
        segments=n,
        crease_deg=60,
        uv=(0.5, 2.3),
    )
    boards = []
    for y, turn, length in ((1.98, 10, 0.95), (1.74, 160, 0.8), (1.5, -55, 0.9)):
        outline = np.array(
            [(-0.12, 0), (length - 0.12, 0), (length, 0.095), (length - 0.12, 0.19), (-0.12, 0.19)]
        )
        boards.append(_board(outline, 0.035).at(0, y, 0.085).turned("y", turn))
    foot = [
        stone_block(60 + i, (0.26, 0.2, 0.22), detail=8).at(
            0.16 * np.cos(1.6 * i), 0, 0.16 * np.sin(1.6 * i)
        )
        for i in range(4)
    ]
    return [(post, "timber"), (join(boards), "carved_wood"), (join(foot), "granite")]


def _board(outline: Array, thickness: float) -> Mesh:
    """Return an extruded convex outline (counter-clockwise in x, y), carved side at +Z."""
    closed = np.concatenate([outline, outline[:1]])
    k = np.zeros((len(closed), 1))
    rim = grid(
        np.stack([np.hstack([closed, k]), np.hstack([closed, k + thickness])]),
        np.zeros((2, len(closed), 2)),
    )
    middle = np.broadcast_to(outline.mean(axis=0), closed.shape)
    face = np.stack([np.hstack([closed, k + thickness]), np.hstack([middle, k + thickness])])
    front = grid(face, np.stack([closed, middle]) * [1.15, -1.15])
    back = Mesh(
        front.positions - [0, 0, thickness], -front.normals, front.uvs, front.indices[:, ::-1]
    )
    return join([smooth(rim, 20), front, back])


def fence(places: Array) -> Parts:
    """Return posts at (n, 2) x, z places, joined by two rails."""
    rng = np.random.default_rng(8)
    posts = [
        lathe([(0.055, -0.2), (0.05, 0.95), (0.0, 1.02)], segments=8, crease_deg=60, uv=(0.3, 1))
        .turned("z", rng.uniform(-4, 4))
        .at(x, 0, z)
        for x, z in places
    ]
    rails = []
    for a, b in itertools.pairwise(places):
        for y in (0.42, 0.8):
            sag = rng.uniform(-0.05, 0.05)
            rails.append(
                tube(
                    [
                        (a[0], y, a[1]),
                        ((a[0] + b[0]) / 2, y + sag, (a[1] + b[1]) / 2 + 0.03),
                        (b[0], y + 0.02, b[1]),
                    ],
                    0.038,
                    segments=6,
                    uv=(0.3, 2),
                )
            )
    return [(join([*posts, *rails]), "timber")]


def log_seat(detail: float = 1.0) -> Parts:
    """Return a bench of a halved trunk on two stumps (long side along X)."""
    n = 14 if detail > 0.5 else 7
    seat = (
        lathe(
            [(0.0, -0.95), (0.2, -0.95), (0.21, 0), (0.2, 0.95), (0.0, 0.95)],
            segments=n,
            crease_deg=50,
            uv=(1, 1.9),
        )
        .turned("z", 90)
        .scaled(1, 0.55, 1)
        .at(0, 0.43)
    )
    stumps = [
        lathe([(0.17, 0), (0.15, 0.34), (0.0, 0.34)], segments=n, crease_deg=50, uv=(1, 0.4)).at(
            x, 0
        )
        for x in (-0.6, 0.6)
    ]
    return [(join([seat, *stumps]), "timber")]


def bird() -> Parts:
    """Return a soaring bird of 1.6 m span that flies towards +X."""
    body = ball(1.0, segments=10, rings=6).scaled(0.34, 0.08, 0.085)
    head = ball(0.07, segments=8, rings=5).at(0.36, 0.02)
    span = np.linspace(0, 1, 7)
    wings = []
    for side in (1, -1):
        chord = 0.26 * (1 - 0.55 * span**2)
        lead = 0.14 - 0.18 * span**2
        y = 0.02 + 0.16 * span - 0.06 * span**2
        points = np.stack(
            [
                np.stack([lead, y, side * span * 0.82], 1),
                np.stack([lead - chord, y - 0.01, side * span * 0.82], 1),
            ],
            axis=1,
        )
        wings.append(grid(points, points[..., [0, 2]], flip=side > 0))
    tail = np.array(
        [[[-0.28, 0.02, 0.03], [-0.28, 0.02, -0.03]], [[-0.56, 0.02, 0.13], [-0.56, 0.02, -0.13]]]
    )
    return [(join([body, head, *wings, grid(tail, tail[..., [0, 2]])]), "feather")]


def path_strip(places: Array, width: float) -> Mesh:
    """Return a ribbon along (n, 2) x, z places, 2 cm above the ground, u across."""
    p = np.asarray(places)
    along = unit(np.gradient(np.column_stack([p[:, 0], 0 * p[:, 0], p[:, 1]]), axis=0))
    side = np.cross(along, [0.0, 1.0, 0.0])
    middle = np.column_stack([p[:, 0], np.full(len(p), 0.02), p[:, 1]])
    points = np.stack([middle - side * width / 2, middle + side * width / 2], axis=1)
    length = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(p, axis=0).T))])
    uvs = np.stack(
        np.broadcast_arrays(np.array([0.0, 1.0])[None], -length[:, None] / width), axis=-1
    )
    return grid(points, uvs)
