"""Builds temple.glb: three connected rooms, bright, natural and dark, full of things to look at.

After the description of the first test scene in Carnegie & Rhee (2015), section "Stimuli".
Run ``python scenes/build_temple.py [OUT.glb]``; the same bytes come out every time.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from kit import ornaments as o
from kit import stone
from kit.glb import GlbWriter
from kit.mesh import Array, ball, box, join, lathe, plane, ring, tube
from kit.ornaments import Parts, placed
from kit.stage import Stage
from kit.temple_shell import ceilings, floors, friezes, walls

BURNER = (18.3, 3.45, 4.8)
"""Where the incense burner hangs from."""
COLUMNS_Z = (-8.0, -4.7, -1.6, 3.4, 6.6, 11.0)
BRAZIERS = ((15.0, 9.7), (23.4, 9.6), (23.5, -0.9), (15.2, -1.0))


def materials(w: GlbWriter) -> dict[str, int]:
    """Add all surfaces and return their indices by name."""

    def pair(name: str, maps: tuple[bytes, bytes], roughness: float, scale: float = 1.0) -> int:
        albedo, normal = w.texture(name, maps[0]), w.texture(f"{name} normal", maps[1])
        return w.material(name, texture=albedo, normal=normal, normal_scale=scale, roughness=roughness)

    plain = w.texture("plaster", stone.plaster(12))
    marble = w.texture("marble", stone.marble(2))
    leaf = w.texture("frond", stone.fronds(10))
    basalt = stone.blocks(11, stone.BASALT, rows=3, columns=3)
    return {
        "sandstone": pair("sandstone", stone.blocks(1, stone.SAND, size=1024), 0.92),
        "basalt": pair("basalt", basalt, 0.75),
        "slabs": pair("slabs", stone.blocks(21, stone.BASALT, rows=2, columns=2), 0.5),
        "star_tiles": pair("star tiles", stone.star_tiles(3, size=1024), 0.42),
        "mosaic": pair("mosaic", stone.mosaic(4, size=1024, cells=64), 0.5),
        "wood": pair("wood", stone.wood(5), 0.7),
        "inscription": pair("inscription", stone.inscription(6, stone.SAND), 0.85),
        "cloth": pair("cloth", stone.cloth(9), 0.95),
        "marble": w.material("marble", texture=marble, roughness=0.42),
        "frieze": w.material("frieze", texture=w.texture("frieze", stone.painted_frieze(7, size=1024)), roughness=0.85),
        "vase": w.material("vase", texture=w.texture("vase", stone.vase_paint(8)), roughness=0.3),
        "plaster": w.material("plaster", texture=plain, roughness=0.85),
        "paper": w.material("paper", texture=w.texture("paper", stone.inscription(16, [(84, 62, 40), (196, 172, 128), (226, 206, 164)], size=256)[0]), roughness=0.95, double_sided=True),
        "bronze": w.material("bronze", texture=plain, color=(0.46, 0.30, 0.15), metallic=1.0, roughness=0.38),
        "gold": w.material("gold", texture=plain, color=(1.0, 0.72, 0.30), metallic=1.0, roughness=0.28),
        "water": w.material("water", color=(0.02, 0.07, 0.075), roughness=0.06),
        "frond": w.material("frond", texture=leaf, roughness=0.6, mask=0.5, double_sided=True),
        "ember": w.material("ember", color=(0.08, 0.03, 0.02), emissive=(4.0, 0.9, 0.15), roughness=0.9),
        "flame": w.material("flame", color=(0, 0, 0), emissive=(14.0, 6.5, 1.6), roughness=1.0),
        "earth": w.material("earth", texture=plain, color=(0.42, 0.36, 0.22), roughness=1.0),
    }  # fmt: skip


def bounce(places: Array) -> Array:
    """Return the light that walls give back: much in the court, little in the crypt."""
    x, y, z = places.T
    crypt = (x > 13.45) & (x < 24.6) & (z > -2.1) & (z < 11.1) & (y < 4)
    hall = (x > 5.2) & (x < 13.3) & (y < 4.7) & (z > -9.1) & (z < 12.1)
    from_door = np.hypot(np.hypot(x - 13.4, z - 3.0), 0.4 * (y - 1.2))
    return np.where(crypt, 0.004 + 0.16 * np.exp(-from_door / 1.1), np.where(hall, 0.36, 0.5))


def with_levels(stage: Stage, name: str, make: o.Parts, coarse: o.Parts) -> None:
    """Add a node with one coarser level."""
    stage.add(name, make, coarse)


def furnish_court(stage: Stage) -> None:
    """Place what stands in the bright court."""
    for side, x in (("w", -2.95), ("e", 2.95)):
        for index, z in enumerate(COLUMNS_Z):
            stage.add(f"column_{side}{index}", *(placed(o.column(d), x, 0, z) for d in (1.0, 0.4)))
    on_plinth = [
        ("statue_north", lambda d: placed(o.statue(d), 0, 0.95, 0, 0, 1.12), (0, -8.1, 0), 0.9),
        ("amphora_west", lambda d: placed(o.amphora(d), 0, 0.95, 0), (-1.75, -2.75, 15), 0.5),
        ("urn_east", lambda d: placed(o.urn(d), 0, 0.95, 0), (1.8, -4.3, 40), 0.5),
        ("amphora_south", lambda d: placed(o.amphora(d), 0, 0.95, 0), (-2.0, 8.9, 0), 0.5),
        ("statue_alcove", lambda d: placed(o.statue(d), 0, 0.95, 0, 0, 0.8), (-7.15, 0.8, 90), 0.6),
    ]
    for name, make, (x, z, turn), width in on_plinth:
        stage.add(name, *(placed(o.pedestal(d, width=width) + make(d), x, 0, z, turn) for d in (1.0, 0.4)))
    stage.add("obelisk_east", *(placed(o.obelisk(d), 1.95, 0, -1.7, 12) for d in (1.0, 0.3)))
    stage.add("obelisk_south", *(placed(o.obelisk(d), -1.6, 0, 10.9, 0) for d in (1.0, 0.3)))
    stage.add("basin", *(placed(o.basin(d), 1.35, 0, 5.0) for d in (1.0, 0.35)))
    for index, (x, z) in enumerate(((-4.3, -8.3), (4.3, -8.3), (-4.35, 11.3), (4.3, 6.4), (-4.3, 5.0), (4.3, -3.0))):
        stage.add(f"palm_{index}", placed(o.potted_palm(30 + index), x, 0, z), placed(o.potted_palm(30 + index, leaves=7, reach=1.1), x, 0, z))
    for index, z in enumerate((-6.3, -3.1, 5.1)):
        stage.add(f"bench_{index}", *(placed(o.bench(d), -4.65, 0, z + (3 if index == 2 else 0), 90) for d in (1.0, 0.5)))
    for index, z in enumerate((-6.3, -3.1, 5.2, 8.1)):
        stage.add(f"banner_{index}", placed(banner(1.3, 2.1), -4.93, 1.35, z, 90))


def banner(width: float, height: float) -> Parts:
    """Return a hanging cloth on a pole, before a wall at z = −0.07."""
    x = np.linspace(-0.5, 0.5, 13)[None, :]
    t = np.linspace(0, 1, 9)[:, None]
    depth = 0.022 * np.sin(16 * x + 1.5 * t) * (0.25 + 0.75 * (1 - t)) + 0.03
    points = np.stack(np.broadcast_arrays(x * width * (1 - 0.03 * (1 - t)), t * height, depth), axis=-1)
    uvs = np.stack(np.broadcast_arrays(x + 0.5, 1 - t + 0 * x), axis=-1)
    from kit.mesh import grid  # noqa: PLC0415

    pole = tube([(-width * 0.56, height + 0.015, 0.03), (width * 0.56, height + 0.015, 0.03)], 0.022, segments=8)
    ends = [ball(0.045, segments=12, rings=6).at(s * width * 0.57, height + 0.015, 0.03) for s in (1, -1)]
    return [(grid(points, uvs), "cloth"), (join([pole, *ends]), "gold")]


def stele(width: float, height: float, detail: float = 1.0) -> Parts:
    """Return an inscribed slab with a rounded head in a marble foot."""
    angle = np.linspace(0, np.pi, 12 if detail > 0.5 else 6)
    spring = height - width / 2
    outline = [(width / 2, 0.0), *((width / 2 * np.cos(a), spring + width / 2 * np.sin(a)) for a in angle), (-width / 2, 0.0)]
    from kit.mesh import Mesh, grid, smooth  # noqa: PLC0415

    rim = np.array([[(x, y, d) for x, y in outline] for d in (-0.09, 0.09)])
    edge = smooth(grid(rim, rim[..., :2] / 1.2), 40)
    fan = np.array([[(x, y, 0.09) for x, y in outline], [(0.0, y * 0.5, 0.09) for _, y in outline]])
    front = grid(fan, fan[..., :2] * [1 / 1.2, -1 / 1.2])
    back = front.turned("y", 180)
    slab: list[Mesh] = [edge, front, back]
    foot = box([width * 1.25, 0.16, 0.42], bevel_m=0.02)
    return [(join(slab).at(0, 0.16), "inscription"), (foot, "marble")]


def furnish_hall(stage: Stage) -> None:
    """Place what stands in the hall with windows."""
    stage.add("table", *(placed(o.table(d) + (placed(o.scrolls(3), 0.2, 0.78, 0.05) + placed(o.amphora(d, height=0.3), -0.75, 0.78, -0.1) + placed(o.urn(d, height=0.24), 0.9, 0.78, 0.12, 20) + placed(o.lamp_stand(d), -0.2, 0.78, -0.22, 0, 0.35) if d > 0.5 else []), 11.3, 0, -5.6, -90) for d in (1.0, 0.4)))
    for index, z in enumerate((-3.1, -0.6)):
        make = o.amphora if index == 0 else o.urn
        stage.add(f"hall_vase_{index}", *(placed(o.pedestal(d) + placed(make(d), 0, 0.95, 0), 6.35, 0, z, 90) for d in (1.0, 0.4)))
    stage.add("statue_hall", *(placed(o.pedestal(d, width=0.8) + placed(o.statue(d), 0, 0.95, 0), 9.9, 0, 7.4, -120) for d in (1.0, 0.4)))
    for index, (x, z, turn) in enumerate(((12.55, 5.8, -90), (12.55, 7.6, -90), (12.55, 9.4, -90), (12.6, -1.7, -90), (5.95, 5.2, 90))):
        stage.add(f"stele_{index}", *(placed(stele(1.0, 2.1, d), x, 0, z, turn) for d in (1.0, 0.3)))
    for index, (x, z) in enumerate(((12.4, -8.4), (6.1, -8.4), (12.4, 11.3), (6.1, 11.4))):
        stage.add(f"hall_palm_{index}", placed(o.potted_palm(50 + index), x, 0, z), placed(o.potted_palm(50 + index, leaves=7, reach=1.1), x, 0, z))
    stage.add("hall_bench", *(placed(o.bench(d), 9.2, 0, -8.5, 0) for d in (1.0, 0.5)))
    stage.add("hall_lamp", *(placed(o.lamp_stand(d), 8.6, 0, 10.9) for d in (1.0, 0.5)))


def furnish_crypt(stage: Stage) -> None:
    """Place what stands in the dark room."""
    for index, (x, z) in enumerate(BRAZIERS):
        stage.add(f"brazier_{index}", *(placed(o.brazier(d), x, 0, z, 40 * index) for d in (1.0, 0.4)))
    stage.add("sarcophagus", *(placed(o.sarcophagus(d), 18.6, 0, 10.0, 180) for d in (1.0, 0.4)))
    stage.add("sarcophagus_north", *(placed(o.sarcophagus(d), 19.0, 0, -1.2, 0) for d in (1.0, 0.4)))
    for index, z in enumerate((1.6, 7.2)):
        stage.add(f"guardian_{index}", *(placed(o.pedestal(d, width=0.75, height=0.7) + placed(o.statue(d), 0, 0.7, 0), 23.9, 0, z, -90) for d in (1.0, 0.4)))
    stage.add("altar", *(placed(altar(d), 23.85, 0, 4.4, -90) for d in (1.0, 0.4)))
    for index, (x, z, turn) in enumerate(((14.0, 6.6, 90), (14.0, 8.2, 90), (13.98, 0.6, 90))):
        stage.add(f"crypt_stele_{index}", *(placed(stele(0.9, 1.8, d), x, 0, z, turn) for d in (1.0, 0.3)))
    stage.add("crypt_urn", *(placed(o.urn(d, height=0.7), 16.6, 0, 10.3) + placed(o.amphora(d, height=0.9), 20.7, 0, 10.3) for d in (1.0, 0.4)))


def altar(detail: float) -> Parts:
    """Return a stone altar with candles, a gold disc and bowls (long side along X)."""
    parts: Parts = [(box([1.7, 0.85, 0.6], bevel_m=0.02, uv_m=1.2), "inscription"), (box([1.9, 0.08, 0.75], bevel_m=0.02).at(0, 0.85), "marble")]
    rays = (lambda angle, y: 1 + 0.10 * np.abs(np.sin(angle * 8)) + 0 * y) if detail > 0.5 else None
    disc = lathe([(0.0, -0.025), (0.3, -0.02), (0.31, 0.0), (0.26, 0.02), (0.24, 0.015), (0.1, 0.03), (0.0, 0.05)], segments=64 if detail > 0.5 else 16, radius=rays)
    parts += [(disc.turned("x", 90).at(0, 1.36, -0.12), "gold"), (box([0.12, 0.14, 0.12]).at(0, 0.93, -0.12), "bronze")]
    for index, x in enumerate((-0.8, -0.66, -0.5, 0.48, 0.63, 0.79)):
        parts += placed(o.candle(0.14 + 0.05 * (index % 3)), x, 0.93, 0.08 * (index % 2))
    bowl = [(0.0, 0.0), (0.06, 0.0), (0.05, 0.02), (0.13, 0.07), (0.15, 0.12), (0.14, 0.12), (0.1, 0.06), (0, 0.05)]
    return [*parts, (lathe(bowl, segments=24 if detail > 0.5 else 12).at(0, 0.93, 0.2), "bronze")]


def outside(stage: Stage) -> None:
    """Lay the ground and plant what is seen through windows."""
    ground = plane([-45, -0.12, 45], [110, 0, 0], [0, 0, -90], step_m=12, uv_m=3.0)
    stage.add("ground", [(ground, "earth")])
    places = ((8.0, -12.5), (10.6, -12.0), (15.6, -6.5), (16.4, -4.4), (7.2, 15.0), (9.4, 15.6), (11.8, 14.8))
    for index, (x, z) in enumerate(places):
        stage.add(f"garden_{index}", placed(o.potted_palm(70 + index, leaves=9), x, -0.5, z, 0, 2.1))


def orrery(stage: Stage, voxels: object) -> None:
    """Add the turning orrery: a pedestal, and rings and planets on three moving nodes."""
    w, at = stage.writer, np.array([-1.85, 1.55, -5.1])
    tilt = {"inner": (24, 5.0, 0.2), "middle": (-14, 9.0, 0.3), "outer": (8, 16.0, 0.4)}
    for name, (degrees, period_s, radius) in tilt.items():
        size = {"inner": 0.032, "middle": 0.045, "outer": 0.055}[name]
        parts: Parts = [(ring(radius, 0.007, segments=64, sides=6), "gold"),
                        (ball(size, segments=20, rings=10).at(radius, 0, 0).tinted((0.55, 0.7, 0.9) if name == "middle" else (0.85, 0.5, 0.35)), "plaster"),
                        (tube([(0.06, 0, 0), (radius, 0, 0)], 0.005, segments=5), "bronze")]  # fmt: skip
        mesh = w.mesh(f"orrery_{name}", [(m.tinted((1, 1, 1, 0.6)), stage.materials[n]) for m, n in parts])
        arm = w.node(f"orrery_{name}", mesh, root=False)
        half = np.radians(degrees) / 2
        w.node(f"orrery_{name}_tilt", at=at, rotation=(0, 0, np.sin(half), np.cos(half)), children=[arm])
        turn = np.linspace(0, 2 * np.pi, 9)
        keys = np.stack([0 * turn, np.sin(turn / 2), 0 * turn, np.cos(turn / 2)], axis=1)
        w.animate(f"orrery {name}", arm, "rotation", np.linspace(0, period_s, 9), keys)


def orrery_stand(d: float) -> Parts:
    """Return the orrery's pedestal, stem and sun."""
    stem = lathe([(0, 0.95), (0.09, 0.95), (0.08, 0.98), (0.025, 1.02), (0.015, 1.2), (0.03, 1.24), (0.012, 1.3), (0.012, 1.5)], segments=16)
    return [*o.pedestal(d, width=0.46), (stem, "bronze"), (ball(0.075, segments=24, rings=12).at(0, 1.55), "gold")]


def burner(stage: Stage) -> None:
    """Add the swinging incense burner of the crypt."""
    w = stage.writer
    body = lathe([(0, -2.42), (0.07, -2.42), (0.06, -2.38), (0.16, -2.32), (0.2, -2.22), (0.19, -2.14), (0.21, -2.12), (0.2, -2.1), (0.17, -2.02), (0.1, -1.92), (0.05, -1.86), (0.06, -1.84), (0.02, -1.8), (0, -1.8)], segments=48,
                 radius=lambda angle, y: 1 + 0.05 * np.abs(np.sin(8 * angle)) * ((y > -2.36) & (y < -2.15)))  # fmt: skip
    chains = [tube([(0.2 * np.cos(a), -2.12, 0.2 * np.sin(a)), (0.1 * np.cos(a), -1.6, 0.1 * np.sin(a)), (0.01 * np.cos(a), -1.2, 0.01 * np.sin(a))], 0.007, segments=5) for a in (0, 2.094, 4.189)]
    links = [ring(0.02, 0.005, segments=10, sides=5).turned("x", 90).turned("y", 90 * (i % 2)).at(0, -1.18 + 0.034 * i) for i in range(35)]
    embers = ring(0.195, 0.012, segments=24, sides=6).at(0, -2.13)
    parts: Parts = [(join([body, *chains, *links]), "gold"), (embers, "ember")]
    mesh = w.mesh("incense_burner", [(m.tinted((1, 1, 1, 0.03)), stage.materials[n]) for m, n in parts])
    node = w.node("incense_burner", mesh, at=BURNER)
    t = np.linspace(0, 1, 33)
    angle = np.radians(13) * np.sin(2 * np.pi * t)
    keys = np.stack([np.sin(angle / 2) * 0.8, 0 * t, np.sin(angle / 2) * 0.6, np.cos(angle / 2)], axis=1)
    w.animate("incense burner swings", node, "rotation", t * 3.1, keys)


def build(out: Path) -> None:
    """Build the scene and write it."""
    writer = GlbWriter()
    stage = Stage(writer, materials(writer), bounce)
    for group in (walls(), floors(), ceilings(), friezes()):
        for name, parts in group.items():
            stage.add(name, parts)
    furnish_court(stage)
    furnish_hall(stage)
    furnish_crypt(stage)
    outside(stage)
    stage.add("orrery_stand", *(placed(orrery_stand(d), -1.85, 0, -5.1) for d in (1.0, 0.4)))
    voxels = stage.voxels(0.1)
    stage.write(voxels)
    orrery(stage, voxels)
    burner(stage)
    writer.save(out)


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("temple.glb"))
