"""Pines and grass of the mountain terrace."""

from __future__ import annotations

import numpy as np

from .mesh import Array, Mesh, grid, join, unit
from .ornaments import Parts
from .shapes import lathe


def pine(seed: int, *, height: float = 7.0, far: bool = False) -> Parts:
    """Return a conifer of masked branches around a trunk; `far` has a third of the triangles."""
    rng = np.random.default_rng(seed)
    tiers, cards = (10, 5) if far else (14, 6)
    trunk = lathe(
        [(0.17, -0.5), (0.14, 0.5), (0.09, height * 0.55), (0.015, height * 0.99)],
        segments=5 if far else 7,
        uv=(1, 5),
    )
    branches = []
    for tier in range(tiers):
        t = tier / (tiers - 1)
        reach = (1.75 * (1 - t) ** 0.8 + 0.2) * height / 7
        for index in range(cards if t < 0.8 else cards - 2):
            turn = 360 / cards * index + 43 * tier + rng.uniform(-16, 16)
            droop = rng.uniform(0.35, 0.6) * (1 - 1.5 * t) - 0.15 * t
            card = _branch(
                reach * rng.uniform(0.8, 1.12), droop, 0.5 * reach + 0.18, bends=1 if far else 2
            )
            branches.append(
                card.turned("y", turn).at(0, height * (0.14 + 0.8 * t) + rng.uniform(-0.1, 0.1))
            )
    tip = [
        _branch(0.6, -3.0, 0.10, bends=1)
        .scaled(0.35, 0.6, 1)
        .turned("y", 120 * k)
        .at(0, height * 0.9)
        for k in range(3)
    ]
    return [(trunk, "bark"), (join([*branches, *tip]), "needles")]


def _branch(length: float, droop: float, width: float, *, bends: int) -> Mesh:
    """Return one folded card along +X; its normals lean up and out, as a crown's do."""
    s = np.linspace(0, 1, bends + 1)
    path = np.stack([s * length, -droop * length * s**1.4], axis=1)
    across = [
        np.stack([path[:, 0], path[:, 1] - 0.3 * width * abs(k), k * width + 0 * s], axis=1)
        for k in (1, 0, -1)
    ]
    points = np.stack(across, axis=1)
    uvs = np.stack(np.broadcast_arrays(np.array([1, 0.5, 0])[None], 1 - s[:, None]), axis=-1)
    sheet = grid(points, uvs)
    normals = unit(sheet.normals * 0.5 + np.array([0.55, 0.75, 0]))
    shade = np.clip(0.5 + 0.5 * sheet.positions[:, :1] / length, 0, 1)
    colors = np.concatenate([np.repeat(shade, 3, axis=1), np.ones((len(shade), 1))], axis=1)
    return Mesh(sheet.positions, normals, sheet.uvs, sheet.indices, colors)


def tufts(places: Array, ground: Array, seed: int) -> Mesh:
    """Return grass at (n, 3) places: three crossed cards each, lit and coloured as the ground is.

    A card is a triangle whose lowest corner is below the ground: blades fan out from a root.
    `ground` holds the ground's (n, 4) colours there; roots are darker than it, tips lighter.
    """
    rng = np.random.default_rng(seed)
    # The picture stands on the ground; the corner below it repeats the picture's top.
    card = np.array([[-1.0, 1.0, 0.2], [0.0, -0.4, 0.0], [1.0, 1.0, 0.2]])
    uvs = np.array([[0.0, 0.0], [0.5, 1.4], [1.0, 0.0]])
    up = np.broadcast_to([0.0, 1.0, 0.0], card.shape)
    shade = np.array([1.3, 0.45, 1.3])[:, None] * [1.0, 1.0, 0.9]
    blades = []
    for place, color in zip(places, ground, strict=True):
        size, turn = rng.uniform(0.14, 0.3), rng.uniform(0, 180)
        colors = np.column_stack([np.clip(shade * color[:3], 0, 1), np.ones(3)])
        shape = card * [0.8 * size, size, size]
        for index in range(3):
            for corners in ([0, 1, 2], [2, 1, 0]):
                side = Mesh(shape, up, uvs, np.array([corners]), colors)
                blades.append(side.turned("y", turn + 60 * index).at(*place))
    return join(blades)
