"""Fires, candles and the plants in pots."""

from __future__ import annotations

import numpy as np

from .mesh import Mesh, grid, join, numbers, unit
from .ornaments import Parts, few, placed
from .shapes import ball, lathe, ring, tube


def brazier(detail: float = 1.0) -> Parts:
    """Return a tripod with a bowl of embers and a flame, 1.35 m to the rim."""
    bowl = numbers(
        "0 1.02, 0.12 1.03, 0.26 1.12, 0.33 1.28, 0.35 1.34, 0.32 1.34, 0.29 1.27, 0 1.25"
    )
    parts: Parts = [(lathe(bowl, segments=few(36, detail, 12), crease_deg=60), "bronze")]
    leg = tube(
        [(0.26, 1.14, 0), (0.2, 0.8, 0), (0.17, 0.45, 0), (0.24, 0.14, 0), (0.36, 0.0, 0)],
        [0.02, 0.022, 0.02, 0.022, 0.03],
        segments=6,
    )
    parts.append(
        (
            join(
                [leg.turned("y", t) for t in (90, 210, 330)]
                + [ring(0.175, 0.012, segments=few(24, detail), sides=5).at(0, 0.5)]
            ),
            "bronze",
        )
    )
    rng = np.random.default_rng(5)
    coals = [
        ball(0.05, segments=6, rings=4)
        .scaled(1, 0.7, 1)
        .at(rng.uniform(-0.17, 0.17), 1.28, rng.uniform(-0.17, 0.17))
        for _ in range(few(14, detail))
    ]
    parts.append((join(coals), "ember"))
    parts.append((flame(detail).at(0, 1.28), "flame"))
    return parts


def flame(detail: float = 1.0) -> Mesh:
    """Return three licking tongues, 0.35 m."""
    y = np.linspace(0, 1, few(9, detail, 5))
    tongues = []
    for turn, height, lean in ((0, 0.36, 0.05), (130, 0.27, 0.09), (250, 0.22, 0.08)):
        path = np.stack(
            [0.05 + lean * np.sin(3.5 * y), y * height, 0.03 * np.sin(5 * y + turn)], axis=1
        )
        tongues.append(
            tube(
                path, 0.075 * (1 - y) ** 0.7 * (0.5 + 2.2 * y * (1 - y) + 0.25) + 0.001, segments=7
            ).turned("y", turn)
        )
    return join(tongues)


def candle(height: float = 0.16, detail: float = 1.0) -> Parts:
    """Return a candle with its flame."""
    wax = lathe(
        [(0, 0), (0.026, 0), (0.026, height), (0.018, height - 0.004), (0, height - 0.008)],
        segments=few(10, detail, 4),
        crease_deg=50,
    )
    tip = lathe(
        [(0, height), (0.009, height + 0.018), (0.006, height + 0.035), (0, height + 0.055)],
        segments=6,
    )
    return [(wax.tinted([0.95, 0.88, 0.72]), "plaster"), (tip, "flame")]


def lamp_stand(detail: float = 1.0) -> Parts:
    """Return a bronze stand with five candles."""
    stem = numbers(
        "0 0, 0.2 0, 0.19 0.03, 0.06 0.07, 0.03 0.14, 0.025 0.5, 0.045 0.54, "
        "0.025 0.58, 0.022 1.05, 0.06 1.1, 0 1.12"
    )
    parts: Parts = [(lathe(stem, segments=few(20, detail, 8), crease_deg=60), "bronze")]
    for index in range(5):
        angle = 2 * np.pi * index / 5
        x, z = 0.2 * np.cos(angle), 0.2 * np.sin(angle)
        branch = tube(
            [(0, 1.0, 0), (x * 0.6, 0.96, z * 0.6), (x, 1.04, z), (x, 1.14, z)],
            0.011,
            segments=few(5, detail, 3),
        )
        dish = lathe(
            [(0, 0), (0.02, 0), (0.045, 0.015), (0.04, 0.02), (0, 0.012)],
            segments=few(10, detail, 4),
        )
        parts += [
            (join([branch, dish.at(x, 1.13, z)]), "bronze"),
            *placed(candle(0.11 + 0.02 * (index % 3), detail), x, 1.145, z),
        ]
    return parts


def potted_palm(seed: int, *, leaves: int = 14, reach: float = 1.0) -> Parts:
    """Return a terracotta pot with arching fronds."""
    pot = lathe(
        numbers(
            "0 0, 0.2 0, 0.23 0.1, 0.29 0.42, 0.33 0.43, 0.33 0.5, 0.29 0.5, 0.28 0.44, 0 0.43"
        ),
        segments=24,
        crease_deg=50,
        uv=(2, 1),
    )
    rng = np.random.default_rng(seed)
    fronds = [
        _frond(reach * rng.uniform(0.75, 1.15), rng.uniform(0.7, 1.35)).turned(
            "y", 137.5 * i + rng.uniform(-15, 15)
        )
        for i in range(leaves)
    ]
    return [(pot.tinted([0.62, 0.30, 0.18]), "plaster"), (join(fronds).at(0, 0.44), "frond")]


def _frond(length: float, lift: float) -> Mesh:
    """Return one frond, folded along its stem, that rises along +X and falls."""
    t = np.linspace(0, 1, 6)
    angle = lift - 1.75 * t**1.3
    path = np.concatenate(
        [[[0, 0]], np.cumsum(np.stack([np.cos(angle), np.sin(angle)], 1)[:-1] * length / 5, axis=0)]
    )
    width = 0.2 * length * np.array([0.35, 0.9, 1, 0.9, 0.7, 0.25])
    points = np.stack(
        [
            np.stack(
                [path[:, 0], path[:, 1] + 0.28 * width * (1 - abs(s)) - 0.1 * width, s * width],
                axis=1,
            )
            for s in (1, 0, -1)
        ],
        axis=1,
    )
    uvs = np.stack(np.broadcast_arrays(np.array([1, 0.5, 0])[None], 1 - t[:, None]), axis=-1)
    sheet = grid(points, uvs)
    # Leaves scatter light: normals lean towards the sky.
    soft = unit(sheet.normals * 0.6 + [0, 0.8, 0])
    return Mesh(sheet.positions, soft, sheet.uvs, sheet.indices)
