"""Builds mountain.glb: a terrace above a lake valley, and snowy ranges to a 30 km horizon.

After the description of the second test scene in Carnegie & Rhee (2015), section "Stimuli":
mostly far, with few detailed things.
Run ``python scenes/build_mountain.py [OUT.glb]``; the same bytes come out every time.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from kit import alpine as a
from kit import alpine_maps as maps
from kit import buildings, stone, terrain
from kit import plants as grown
from kit.contact import outlines
from kit.glb import GlbWriter
from kit.light import Voxels, darkened
from kit.mesh import Array, Mesh, join, numbers
from kit.ornaments import Parts, placed
from kit.shapes import plane
from kit.stage import Stage

WHEEL_AT = (-6.6, 0.0, -8.6)
PATHS = (
    np.array(
        numbers(
            "0.6 14, 0.3 9, -0.2 4, 0 0, 0.1 -3.5, 0.9 -5.6, 3 -6.6, 7 -6.5, 11 -5.6, 14.5 -5.3"
        )
    ),
    np.array([(0.0, 1.0), (-1.6, -2.2), (-3.6, -4.8), (-5.6, -6.6)]),
    np.array(numbers("0 1.4, 5 1, 10 2.2, 16 3, 20.5 2, 24 4")),
)

PINES = numbers(
    "-10.5 -7, -13.5 -3, -15 2, -11 9.5, -6 13, 4.5 12.8, 9 14.5, 16 13.5, "
    "22 12, 28 6, 29.5 -1, 26.5 -7.5, 20.5 -10.5, -9 -13, -12.5 -16.5, 10.5 "
    "-15.5, 24.5 -13, 19 -14, 27 -13, -17 -9"
)


def materials(w: GlbWriter) -> dict[str, int]:
    """Add all surfaces and return their indices by name."""

    def pair(name: str, maps: tuple[bytes, bytes], roughness: float) -> int:
        albedo, normal = w.texture(name, maps[0]), w.texture(f"{name} normal", maps[1])
        return w.material(name, texture=albedo, normal=normal, roughness=roughness)

    timber = stone.wood(5, ramp=maps.WOOD)
    plain = w.texture("plain", stone.plaster(12))
    return {
        "land": pair("land", terrain.polar_pictures(), 0.95),
        "turf": pair("turf", maps.ground_maps(31), 1.0),
        "granite": pair("granite", maps.granite_maps(41), 0.9),
        "timber": pair("timber", timber, 0.85),
        "planks": pair("planks", stone.wood(15, planks=6), 0.8),
        "shingles": pair(
            "shingles",
            stone.blocks(51, [(40, 34, 30), (82, 70, 60), (122, 108, 94)], rows=6, columns=6),
            0.85,
        ),
        "carved_wood": pair(
            "carved wood",
            stone.inscription(6, [(44, 32, 22), (140, 112, 80), (176, 148, 112)], size=256),
            0.8,
        ),
        "path": w.material(
            "path", texture=w.texture("path", maps.path_png(61)), roughness=1.0, mask=0.5
        ),
        "needles": w.material(
            "needles",
            texture=w.texture("needles", maps.needles_png(71)),
            roughness=0.8,
            mask=0.35,
            double_sided=True,
        ),
        "grass": w.material(
            "grass",
            texture=w.texture("grass", maps.grass_png(81)),
            roughness=0.9,
            mask=0.3,
        ),
        "bark": w.material("bark", texture=plain, color=(0.16, 0.11, 0.08), roughness=0.95),
        "red_paint": w.material(
            "red paint", texture=plain, color=(0.45, 0.07, 0.045), roughness=0.6
        ),
        "blades": w.material(
            "blades", texture=plain, color=(0.75, 0.73, 0.68), roughness=0.45, double_sided=True
        ),
        "iron": w.material(
            "iron", texture=plain, color=(0.32, 0.31, 0.30), metallic=1.0, roughness=0.5
        ),
        "feather": w.material(
            "feather", texture=plain, color=(0.06, 0.05, 0.045), roughness=0.8, double_sided=True
        ),
        "water": w.material("water", color=(0.012, 0.05, 0.06), roughness=0.12),
    }


def land(stage: Stage, voxels: Voxels) -> None:
    """Add the terrain, the lake and the paths."""
    w, m = stage.writer, stage.materials
    for index, tile in enumerate(terrain.near_tiles(outlines(stage.solid()))):
        shaded = darkened(voxels, tile)
        w.node(f"ground_{index:02d}", w.mesh(f"ground_{index:02d}", [(shaded, m["turf"])]))
    for index, tile in enumerate(terrain.far_tiles()):
        w.node(f"land_{index:03d}", w.mesh(f"land_{index:03d}", [(tile, m["land"])]))
    w.node("lake", w.mesh("lake", [(terrain.lake(), m["water"])]))
    strips = [a.path_strip(_rounded(points), 1.5) for points in PATHS]
    w.node("paths", w.mesh("paths", [(join(strips), m["path"])]))


def _rounded(points: Array) -> Array:
    """Return a smooth line through a few points (Catmull and Rom)."""
    p = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
    t = np.linspace(0, 1, 7)[:-1, None]
    parts = [
        0.5
        * (
            2 * p[i]
            + (p[i + 1] - p[i - 1]) * t
            + (2 * p[i - 1] - 5 * p[i] + 4 * p[i + 1] - p[i + 2]) * t**2
            + (3 * p[i] - p[i - 1] - 3 * p[i + 1] + p[i + 2]) * t**3
        )
        for i in range(1, len(p) - 2)
    ]
    return np.concatenate([*parts, points[-1:]])


def furnish(stage: Stage) -> None:
    """Place what stands near the path."""
    stage.add("cairn", *(placed(a.cairn(d), 2.1, 0, -3.3, 20) for d in (1.0, 0.4)))
    stage.add("signpost", *(placed(a.signpost(d), -1.15, 0, -3.9, 15) for d in (1.0, 0.4)))
    stage.add("hut", *(placed(buildings.hut(d), 14.5, 0, -8.6, 0) for d in (1.0, 0.4)))
    stage.add(
        "wind_tower", *(placed(buildings.wind_wheel_tower(d), *WHEEL_AT, 25) for d in (1.0, 0.4))
    )
    stage.add("log_seat", *(placed(a.log_seat(d), 4.6, 0, -3.2, -8) for d in (1.0, 0.4)))
    rail = np.array(numbers("-4.4 -9.6, -2.2 -9.9, 0 -10, 2.2 -9.9, 4.4 -9.7, 6.6 -9.6, 8.8 -9.7"))
    stage.add("fence", a.fence(rail))
    rng = np.random.default_rng(17)
    places = numbers(
        "-3.4 -1.6 0.9, -2.6 3.6 0.5, 3.4 -8.2 0.7, -9.5 -4 1.6, 6.3 -1.6 "
        "0.45, 11.2 -3.2 0.8, -3.2 -7.6 0.5, 25 -4 2.2, -12 5 2, 4 5.5 "
        "0.8, 13 7.8 1.4, 1.9 -4.1 0.28"
    )
    for index, (x, z, size) in enumerate(places):
        shape = size * np.array(
            [rng.uniform(0.9, 1.3), rng.uniform(0.6, 0.8), rng.uniform(0.8, 1.1)]
        )
        stage.add(
            f"rock_{index:02d}",
            *(
                [
                    (
                        a.stone_block(300 + index, tuple(shape), detail=d).at(x, -0.12 * size, z),
                        "granite",
                    )
                ]
                for d in (14, 6)
            ),
        )


def plants(stage: Stage) -> None:
    """Add pines and grass; pines share three meshes."""
    w, m = stage.writer, stage.materials
    shapes = [_pine_meshes(stage, seed, height) for seed, height in ((1, 7.5), (2, 5.6), (3, 9.0))]
    for kind, (_, far) in enumerate(shapes):
        w.node(f"pine_{'abc'[kind]}_far", far, root=False)
    rng = np.random.default_rng(29)
    for index, (x, z) in enumerate([*PINES, *_slope_pines(rng, 44)]):
        kind, turn = index % 3, rng.uniform(0, np.pi)
        at = (x, terrain.ground_height(x, z) - 0.05, z)
        w.node(
            f"pine_{'abc'[kind]}_{index:02d}",
            shapes[kind][0],
            at=at,
            rotation=(0, np.sin(turn), 0, np.cos(turn)),
        )
    spots = rng.uniform((-14, -10.5), (28, 13), (420, 2))
    clear = [s for s in spots if _off_path(s) and 0.2 < terrain.from_terrace(*s) < 1.05]
    ordered = np.array(sorted(clear, key=lambda s: (s[0] // 7, s[1] // 6)))
    for index, chunk in enumerate(np.array_split(ordered, 12)):
        places = np.column_stack([chunk[:, 0], 0 * chunk[:, 0], chunk[:, 1]])
        clump = grown.tufts(places, terrain.cover_color(*chunk.T), 90 + index)
        w.node(f"grass_{index:02d}", w.mesh(f"grass_{index:02d}", [(clump, m["grass"])]))


def _pine_meshes(stage: Stage, seed: int, height: float) -> tuple[int, int]:
    near, far = (
        stage.writer.mesh(
            f"pine_{seed}_{name}",
            [
                (mesh, stage.materials[material])
                for mesh, material in grown.pine(seed, height=height, far=name == "far")
            ],
        )
        for name in ("near", "far")
    )
    return near, far


def _slope_pines(rng: np.random.Generator, count: int) -> list[tuple[float, float]]:
    """Return places of pines on the slopes around the terrace, in groves."""
    places: list[tuple[float, float]] = []
    while len(places) < count:
        x, z = rng.uniform((-55, -50), (75, 70))
        inside = 1.6 < terrain.from_terrace(x, z) < 4.0 and (z > 16 or abs(x - 8) > 30 or z < -22)
        if inside and np.sin(x / 9.0 + 1) + np.sin(z / 11.0) > 0.4:
            places.append((float(x), float(z)))
    return places


def _off_path(spot: Array) -> bool:
    return all(np.hypot(*(_rounded(points) - spot).T).min() > 0.75 for points in PATHS)


def moving(stage: Stage) -> None:
    """Add the wind wheel and two circling birds."""
    w, m = stage.writer, stage.materials

    def mesh(name: str, parts: Parts) -> int:
        return w.mesh(name, [(part, m[material]) for part, material in parts])

    heading = np.radians(25) / 2
    wheel = w.node("wind_wheel", mesh("wind_wheel", buildings.wind_wheel()), root=False)
    hub = np.array([0.42 * np.sin(2 * heading), 6.15, 0.42 * np.cos(2 * heading)])
    w.node(
        "wind_wheel_axle",
        at=np.array(WHEEL_AT) + hub,
        rotation=(0, np.sin(heading), 0, np.cos(heading)),
        children=[wheel],
    )
    turn = np.linspace(0, 2 * np.pi, 9)
    spin = np.stack([0 * turn, 0 * turn, np.sin(-turn / 2), np.cos(-turn / 2)], axis=1)
    w.animate("wind wheel turns", wheel, "rotation", np.linspace(0, 4.0, 9), spin)
    shape = mesh("bird", a.bird())
    for index, (center, radius, period_s) in enumerate(
        (((-4, 14, -42), 16, 14.0), ((14, 24, -70), 24, 19.0))
    ):
        bank = np.radians(-18) / 2
        flier = w.node(
            f"bird_{index}",
            shape,
            at=(0, 0, radius),
            rotation=(np.sin(bank), 0, 0, np.cos(bank)),
            root=False,
        )
        hub = w.node(f"bird_{index}_circle", at=center, children=[flier])
        keys = np.stack([0 * turn, np.sin(turn / 2), 0 * turn, np.cos(turn / 2)], axis=1)
        w.animate(f"bird {index} circles", hub, "rotation", np.linspace(0, period_s, 9), keys)


def bounce(places: Array) -> Array:
    """Return the light that meadow and stones give back."""
    return np.full(len(places), 0.3)


def _ground_below(stage: Stage) -> Mesh:
    """Return a level ground under all that stands: it takes light from what is low."""
    low, high = (
        f([f(mesh.positions, axis=0) for mesh in stage.solid()], axis=0) for f in (np.min, np.max)
    )
    size = high - low
    return plane([low[0], 0, high[2]], [size[0], 0, 0], [0, 0, -size[2]], step_m=0.5)


def build(out: Path) -> None:
    """Build the scene and write it."""
    writer = GlbWriter(position_step_m=1e-3)
    stage = Stage(writer, materials(writer), bounce)
    furnish(stage)
    voxels = stage.voxels(0.06, _ground_below(stage))
    stage.write(voxels)
    land(stage, voxels)
    plants(stage)
    moving(stage)
    writer.save(out)


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("mountain.glb"))
