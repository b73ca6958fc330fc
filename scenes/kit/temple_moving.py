"""What moves in the temple: the orrery of the court and the incense burner of the crypt."""

from __future__ import annotations

import numpy as np

from .mesh import Mesh, join, numbers
from .ornaments import Parts, few
from .shapes import ball, lathe, ring, tube
from .stage import Stage

BURNER = (18.3, 3.45, 4.8)
"""Where the incense burner hangs from."""
ORRERY = (-1.85, 1.55, -5.1)
"""The orrery's sun."""
ARMS = {
    # tilt in degrees, period in seconds, radius and planet in metres, planet's colour
    "inner": (24, 5.0, 0.2, 0.032, (0.85, 0.5, 0.35)),
    "middle": (-14, 9.0, 0.3, 0.045, (0.55, 0.7, 0.9)),
    "outer": (8, 16.0, 0.4, 0.055, (0.85, 0.5, 0.35)),
}


def orrery(stage: Stage) -> None:
    """Add the orrery's rings and planets: three nodes that turn at their own pace."""
    turn = np.linspace(0, 2 * np.pi, 9)
    keys = np.stack([0 * turn, np.sin(turn / 2), 0 * turn, np.cos(turn / 2)], axis=1)
    for name, (degrees, period_s, *shape) in ARMS.items():
        arm = _levels(stage, f"orrery_{name}", [_arm(d, *shape) for d in (1.0, 0.3)], ambient=0.6)
        half = np.radians(degrees) / 2
        tilt = (0, 0, np.sin(half), np.cos(half))
        stage.writer.node(f"orrery_{name}_tilt", at=ORRERY, rotation=tilt, children=[arm])
        times_s = np.linspace(0, period_s, len(turn))
        stage.writer.animate(f"orrery {name}", arm, "rotation", times_s, keys)


def _arm(detail: float, radius: float, size: float, color: tuple[float, float, float]) -> Parts:
    """Return a ring with one planet at +X."""
    band = ring(radius, 0.007, segments=few(48, detail), sides=few(5, detail, 3))
    planet = ball(size, segments=few(16, detail), rings=few(8, detail, 4)).at(radius, 0, 0)
    spoke = tube([(0.06, 0, 0), (radius, 0, 0)], 0.005, segments=4)
    return [(band, "gold"), (planet.tinted(color), "plaster"), (spoke, "bronze")]


def incense_burner(stage: Stage) -> None:
    """Add the burner: a pendulum of 2.4 m, so it swings once in 3.1 seconds."""
    levels = [_burner(d) for d in (1.0, 0.3)]
    node = _levels(stage, "incense_burner", levels, ambient=0.03, at=BURNER)
    t = np.linspace(0, 1, 33)
    angle = np.radians(13) * np.sin(2 * np.pi * t) / 2
    keys = np.stack([np.sin(angle) * 0.8, 0 * t, np.sin(angle) * 0.6, np.cos(angle)], axis=1)
    stage.writer.animate("incense burner swings", node, "rotation", t * 3.1, keys)


def _burner(detail: float) -> Parts:
    profile = numbers(
        "0 -2.42, 0.07 -2.42, 0.06 -2.38, 0.16 -2.32, 0.2 -2.22, 0.19 -2.14, 0.21 -2.12, "
        "0.2 -2.1, 0.17 -2.02, 0.1 -1.92, 0.05 -1.86, 0.06 -1.84, 0.02 -1.8, 0 -1.8"
    )
    body = lathe(
        profile,
        segments=few(48, detail, 12),
        radius=lambda angle, y: 1 + 0.05 * np.abs(np.sin(8 * angle)) * ((y > -2.36) & (y < -2.15)),
    )
    path = np.array([(0.2, -2.12, 0), (0.1, -1.6, 0), (0.01, -1.2, 0)])
    chain = tube(path, 0.007, segments=few(5, detail, 3))
    hanging = _links() if detail > 0.5 else tube([(0, -1.2, 0), (0, 0, 0)], 0.012, segments=4)
    embers = ring(0.195, 0.012, segments=few(24, detail, 10), sides=few(6, detail, 3)).at(0, -2.13)
    metal = join([body, hanging, *(chain.turned("y", turn) for turn in (0, 120, 240))])
    return [(metal, "gold"), (embers, "ember")]


def _links() -> Mesh:
    """Return the chain from the burner's three cords up to the ceiling."""
    link = ring(0.02, 0.005, segments=10, sides=4).turned("x", 90)
    return join([link.turned("y", 90 * (i % 2)).at(0, -1.18 + 0.034 * i) for i in range(35)])


def _levels(
    stage: Stage,
    name: str,
    levels: list[Parts],
    *,
    ambient: float,
    at: tuple[float, ...] | None = None,
) -> int:
    """Add a node (a root only if it has a place) and its coarser levels; return the node."""
    indices = []
    for level, parts in enumerate(levels):
        lit = [(mesh.tinted((1, 1, 1, ambient)), stage.materials[m]) for mesh, m in parts]
        mesh = stage.writer.mesh(f"{name}_lod{level}", lit)
        label = name if level == 0 else f"{name}_lod{level}"
        root = level == 0 and at is not None
        indices.append(stage.writer.node(label, mesh, at=at if level == 0 else None, root=root))
    return indices[0]
