"""Tables, benches and what lies on them."""

from __future__ import annotations

import numpy as np

from .mesh import grid, join, numbers
from .ornaments import Parts, few
from .shapes import box, lathe


def table(detail: float = 1.0, *, length: float = 2.4) -> Parts:
    """Return a wooden table with turned legs (long side along X), 0.78 m high."""
    top = box([length, 0.06, 0.85], bevel_m=0.012, uv_m=1.0).at(0, 0.72)
    leg_profile = numbers(
        "0.035 0, 0.03 0.08, 0.045 0.12, 0.03 0.16, 0.042 0.4, 0.03 0.58, 0.05 0.62, 0.045 0.72"
    )
    leg = lathe(leg_profile, segments=few(14, detail, 6), uv=(0.2, 0.7))
    legs = [leg.at(sx * (length / 2 - 0.12), 0, sz * 0.33) for sx in (1, -1) for sz in (1, -1)]
    rails = [box([length - 0.2, 0.1, 0.03]).at(0, 0.62, z) for z in (0.33, -0.33)]
    return [(join([top, *legs, *rails]), "wood")]


def scrolls(seed: int) -> Parts:
    """Return rolled and open scrolls and a small pot, about 0.9 m wide, lying on y = 0."""
    rng = np.random.default_rng(seed)
    roll = lathe(
        [(0.0, -0.17), (0.028, -0.17), (0.03, 0), (0.028, 0.17), (0.0, 0.17)],
        segments=12,
        crease_deg=50,
    )
    lying = roll.turned("z", 90)
    rolls = [
        lying.turned("y", rng.uniform(-30, 30)).at(x, y, z)
        for x, y, z in ((-0.3, 0.03, 0), (-0.28, 0.03, 0.08), (-0.29, 0.085, 0.04))
    ]
    s = np.linspace(-1, 1, 11)
    sheet = np.stack(
        [
            np.stack([0.15 + 0.0 * s + dx, 0.004 + 0.035 * np.abs(s) ** 6, 0.2 * s], axis=1)
            for dx in (0, 0.28)
        ],
        axis=1,
    )
    uvs = np.stack(
        np.broadcast_arrays(np.array([0.0, 0.25])[None], (s[:, None] + 1) * 0.2), axis=-1
    )
    paper = grid(sheet[::-1], uvs)
    return [
        (join(rolls).tinted([0.9, 0.8, 0.6]), "plaster"),
        (paper.tinted([1.0, 0.92, 0.75]), "paper"),
    ]


def bench(detail: float = 1.0, *, length: float = 1.8) -> Parts:
    """Return a stone bench on scrolled feet (long side along X)."""
    seat = box([length, 0.09, 0.45], bevel_m=0.015, uv_m=1.0).at(0, 0.38)
    foot = numbers("0.1 0, 0.1 0.04, 0.06 0.08, 0.05 0.2, 0.08 0.3, 0.1 0.38")
    feet = [
        lathe(foot, segments=few(20, detail, 8)).scaled(1, 1, 1.9).at(x, 0, 0)
        for x in (-length * 0.36, length * 0.36)
    ]
    return [(join([seat, *feet]), "marble")]
