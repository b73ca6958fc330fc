"""Builds depths.glb: identical things at staggered distances, and a stair to look at them from.

Ten equal targets stand from 0.5 m to 19.2 m before the start, each half as far again as the one
before, and none hides another: what is sharp, and how fast blur grows, is seen at a glance.
The stair is there because speed on stairs is a setting of locomotion (Carnegie & Rhee 2015).
Where hands are tracked, each holds a paddle: things that go with the head blur falsely where only
the head's rotation is left out of motion blur (Chapman 2020).
Run ``python scenes/build_depths.py [OUT.glb]``; the same bytes come out every time.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from kit import stone
from kit.contact import floor, outlines
from kit.glb import GlbWriter
from kit.mesh import Array, Mesh, join
from kit.ornaments import Parts, few, placed
from kit.shapes import ball, box, lathe, plane, ring, tube
from kit.stage import Stage
from kit.texture import rgb_png

DISTANCES_M = tuple(0.5 * 1.5**k for k in range(10))
"""From the start, along the floor."""
AZIMUTHS_DEG = (-34.0, -15.0, -2.5, 6.0, 13.8, 18.9, 22.7, 10.6, 21.1, 16.8)
"""To the right of straight ahead: each target is seen beside all others, by both eyes."""
HALL = (-6.0, 6.0, -26.0, 3.0)
"""x and z of the walls."""
WALL_M = 4.0
STEPS, RISE_M, RUN_M = 10, 0.17, 0.3
STAIR = (3.2, 5.2, -1.0, -7.0)
"""x from and to, z of the lowest riser, z of the landing's far end."""
CAROUSEL = (-3.4, 1.5, -4.2)
"""What turns."""


def materials(w: GlbWriter) -> dict[str, int]:
    """Add all surfaces and return their indices by name."""

    def pair(name: str, maps: tuple[bytes, bytes], roughness: float) -> int:
        albedo, normal = w.texture(name, maps[0]), w.texture(f"{name} normal", maps[1])
        return w.material(name, texture=albedo, normal=normal, roughness=roughness)

    plain = w.texture("plaster", stone.plaster(12))
    return {
        "sandstone": pair("sandstone", stone.blocks(1, stone.SAND), 0.92),
        "star_tiles": pair("star tiles", stone.star_tiles(3), 0.42),
        "slabs": pair("slabs", stone.blocks(21, stone.BASALT, rows=2, columns=2), 0.5),
        "checks": w.material("checks", texture=w.texture("checks", checks()), roughness=0.6),
        "plaster": w.material("plaster", texture=plain, roughness=0.85),
        "bronze": w.material(
            "bronze", texture=plain, color=(0.46, 0.30, 0.15), metallic=1.0, roughness=0.38
        ),
        "earth": w.material("earth", texture=plain, color=(0.42, 0.36, 0.22), roughness=1.0),
    }


def checks(size: int = 512) -> bytes:
    """Return a PNG of checks that get finer from left to right: 8, 16 and 32 in a row."""
    v, u = np.indices((size // 2, size)) / (size / 2)
    count = np.select([u < 2 / 3, u < 4 / 3], [8, 16], 32)
    light = (np.floor(u * count) + np.floor(v * count)) % 2
    return rgb_png(np.where(light[..., None] > 0, [236, 232, 222], [34, 40, 58]).astype(float))


def target(detail: float = 1.0) -> Parts:
    """Return a ball with checks on a thin post, its centre 1.5 m high."""
    foot = lathe([(0.12, 0.0), (0.12, 0.015), (0.02, 0.03), (0.0, 0.03)], segments=few(24, detail))
    post = tube([(0, 0.025, 0), (0, 1.42, 0)], 0.012, segments=few(8, detail, 4))
    body = ball(0.09, segments=few(48, detail), rings=few(24, detail, 5)).at(0, 1.5, 0)
    return [(join([foot, post]), "bronze"), (body, "checks")]


def target_places() -> list[tuple[float, float]]:
    """Return x and z of the targets, nearest first."""
    turn = np.radians(AZIMUTHS_DEG)
    return [
        (float(d * np.sin(a)), float(-d * np.cos(a)))
        for d, a in zip(DISTANCES_M, turn, strict=True)
    ]


def stair() -> dict[str, Parts]:
    """Return the steps, the landing, and the rail at their open side."""
    x0, x1, z0, z1 = STAIR
    middle, width = (x0 + x1) / 2, x1 - x0
    steps = [
        box([width, RISE_M * (k + 1), RUN_M], uv_m=1.2, bottom=False).at(
            middle, 0, z0 - RUN_M * (k + 0.5)
        )
        for k in range(STEPS - 1)
    ]
    top_m, begins = RISE_M * STEPS, z0 - RUN_M * (STEPS - 1)
    landing = box([width, top_m, begins - z1], uv_m=1.2, bottom=False)
    return {
        "stair": [(join(steps), "slabs")],
        "landing": [(landing.at(middle, 0, (begins + z1) / 2), "slabs")],
        "rail": [(_rail(x0 + 0.06, z0, begins, z1, top_m), "bronze")],
    }


def _rail(x: float, low: float, begins: float, end: float, top_m: float) -> Mesh:
    """Return posts and a handrail of 0.95 m along the open sides."""
    corners = [(x, 0.95 + RISE_M, low - 0.15), (x, top_m + 0.95, begins), (x, top_m + 0.95, end)]
    far = (STAIR[1] - 0.06, top_m + 0.95, end + 0.06)
    hand = tube([*corners[:2], (x, top_m + 0.95, end + 0.06), far], 0.025, segments=8)
    feet = [(x, RISE_M, low - 0.15), (x, top_m, begins), (x, top_m, end + 0.06)]
    feet += [(STAIR[1] - 0.06, top_m, end + 0.06), ((x + far[0]) / 2, top_m, end + 0.06)]
    posts = [tube([(a, y, b), (a, y + 0.95, b)], 0.018, segments=6) for a, y, b in feet]
    return join([hand, *posts])


def walls() -> dict[str, Parts]:
    """Return the hall's four walls, each with a coping."""
    x0, x1, z0, z1 = HALL
    sides = {
        "wall_west": plane([x0, 0, z1], [0, 0, z0 - z1], [0, WALL_M, 0], uv_m=2.4),
        "wall_east": plane([x1, 0, z0], [0, 0, z1 - z0], [0, WALL_M, 0], uv_m=2.4),
        "wall_north": plane([x0, 0, z0], [x1 - x0, 0, 0], [0, WALL_M, 0], uv_m=2.4),
        "wall_south": plane([x1, 0, z1], [x0 - x1, 0, 0], [0, WALL_M, 0], uv_m=2.4),
    }
    return {name: [(mesh, "sandstone")] for name, mesh in sides.items()}


def copings() -> Parts:
    """Return what lies on the walls and closes them from above."""
    x0, x1, z0, z1 = HALL
    long = box([0.5, 0.25, z1 - z0 + 1.0], uv_m=1.0)
    across = box([x1 - x0, 0.25, 0.5], uv_m=1.0)
    middle = (z0 + z1) / 2
    places = [long.at(x, WALL_M, middle) for x in (x0 - 0.2, x1 + 0.2)]
    places += [across.at(0, WALL_M, z) for z in (z0 - 0.2, z1 + 0.2)]
    return [(join(places), "slabs")]


def floors(stage: Stage) -> None:
    """Add the floor in tiles, finer around what stands on it."""
    x0, x1, z0, z1 = HALL
    around = outlines(stage.solid())
    cuts = np.linspace(z0, z1, 5)
    for index, (a, b) in enumerate(pairwise(cuts)):
        x, z = (np.linspace(s, e, max(2, round((e - s) / 0.9) + 1)) for s, e in ((x0, x1), (a, b)))
        stage.add(f"floor_{index}", [(floor(x, z, around, uv_m=1.6), "star_tiles")])
    ground = plane([-60, -0.05, 60], [120, 0, 0], [0, 0, -120], step_m=20, uv_m=4)
    stage.add("ground", [(ground, "earth")])


def carousel(stage: Stage) -> None:
    """Add a ring with one ball on a stand: at one turn a second the ball is at 2.5 m/s.

    A thing that is fast by itself, for motion blur.
    """
    band = ring(0.4, 0.012, segments=48, sides=6)
    body = ball(0.06, segments=24, rings=12).at(0.4, 0, 0)
    spoke = tube([(-0.4, 0, 0), (0.4, 0, 0)], 0.008, segments=5)
    parts = [(join([band, spoke]), "bronze"), (body, "checks")]
    lit = [(mesh.tinted((1, 1, 1, 0.9)), stage.materials[name]) for mesh, name in parts]
    node = stage.writer.node("carousel", stage.writer.mesh("carousel", lit), at=CAROUSEL)
    turn = np.linspace(0, 2 * np.pi, 17)
    keys = np.stack([0 * turn, np.sin(turn / 2), 0 * turn, np.cos(turn / 2)], axis=1)
    stage.writer.animate("carousel turns", node, "rotation", turn / (2 * np.pi), keys)


def paddles(stage: Stage) -> None:
    """Add what each hand holds; a hand points along -Z."""
    grip = tube([(0, 0, 0.06), (0, 0, -0.12)], 0.013, segments=12)
    blade = box([0.16, 0.012, 0.2], bevel_m=0.004, uv_m=0.32).turned("x", 55).at(0, -0.01, -0.12)
    for hand in ("left", "right"):
        parts = [(grip, "bronze"), (blade, "checks")]
        lit = [(mesh.tinted((1, 1, 1, 0.9)), stage.materials[name]) for mesh, name in parts]
        name = f"paddle_{hand}"
        stage.writer.node(name, stage.writer.mesh(name, lit))


def bounce(places: Array) -> Array:
    """Return the light that walls give back: the hall is open to the sky."""
    return np.full(len(places), 0.6)


def build(out: Path) -> None:
    """Build the scene and write it."""
    writer = GlbWriter()
    stage = Stage(writer, materials(writer), bounce)
    for distance_m, (x, z) in zip(DISTANCES_M, target_places(), strict=True):
        levels = [placed(target(detail), x, 0, z) for detail in (1.0, 0.4)]
        stage.add(f"target_{round(distance_m * 100):04d}_cm", *levels)
    for name, parts in stair().items():
        stage.add(name, parts)
    x, y, z = CAROUSEL
    stage.add("carousel_stand", [(tube([(x, 0, z), (x, y, z)], 0.03, segments=10), "bronze")])
    floors(stage)
    for name, parts in walls().items():
        stage.add(name, parts)
    stage.add("copings", copings())
    stage.write(stage.voxels(0.06))
    carousel(stage)
    paddles(stage)
    writer.save(out)


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("depths.glb"))
