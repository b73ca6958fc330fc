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
from kit.contact import outlines
from kit.glb import GlbWriter
from kit.mesh import Array
from kit.ornaments import placed
from kit.stage import Stage
from kit.temple_moving import incense_burner, orrery
from kit.temple_rooms import furnish_court, furnish_crypt, furnish_hall, orrery_stand, outside
from kit.temple_shell import ceilings, floors, friezes, walls

BURNER = (18.3, 3.45, 4.8)


"""Where the incense burner hangs from."""


def materials(w: GlbWriter) -> dict[str, int]:
    """Add all surfaces and return their indices by name."""

    def pair(name: str, maps: tuple[bytes, bytes], roughness: float, scale: float = 1.0) -> int:
        albedo, normal = w.texture(name, maps[0]), w.texture(f"{name} normal", maps[1])
        return w.material(
            name, texture=albedo, normal=normal, normal_scale=scale, roughness=roughness
        )

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
        "frieze": w.material(
            "frieze",
            texture=w.texture("frieze", stone.painted_frieze(7, size=1024)),
            roughness=0.85,
        ),
        "vase": w.material("vase", texture=w.texture("vase", stone.vase_paint(8)), roughness=0.3),
        "plaster": w.material("plaster", texture=plain, roughness=0.85),
        "paper": w.material(
            "paper",
            texture=w.texture(
                "paper",
                stone.inscription(16, [(84, 62, 40), (196, 172, 128), (226, 206, 164)], size=256)[
                    0
                ],
            ),
            roughness=0.95,
            double_sided=True,
        ),
        "bronze": w.material(
            "bronze", texture=plain, color=(0.46, 0.30, 0.15), metallic=1.0, roughness=0.38
        ),
        "gold": w.material(
            "gold", texture=plain, color=(1.0, 0.72, 0.30), metallic=1.0, roughness=0.28
        ),
        "water": w.material("water", color=(0.02, 0.07, 0.075), roughness=0.06),
        "frond": w.material("frond", texture=leaf, roughness=0.6, mask=0.5, double_sided=True),
        "ember": w.material(
            "ember", color=(0.08, 0.03, 0.02), emissive=(4.0, 0.9, 0.15), roughness=0.9
        ),
        "flame": w.material("flame", color=(0, 0, 0), emissive=(14.0, 6.5, 1.6), roughness=1.0),
        "earth": w.material("earth", texture=plain, color=(0.42, 0.36, 0.22), roughness=1.0),
    }


def bounce(places: Array) -> Array:
    """Return the light that walls give back: much in the court, little in the crypt."""
    x, y, z = places.T
    crypt = (x > 13.45) & (x < 24.6) & (z > -2.1) & (z < 11.1) & (y < 4)
    hall = (x > 5.2) & (x < 13.3) & (y < 4.7) & (z > -9.1) & (z < 12.1)
    from_door = np.hypot(np.hypot(x - 13.4, z - 3.0), 0.4 * (y - 1.2))
    return np.where(crypt, 0.004 + 0.16 * np.exp(-from_door / 1.1), np.where(hall, 0.62, 0.66))


def with_levels(stage: Stage, name: str, make: o.Parts, coarse: o.Parts) -> None:
    """Add a node with one coarser level."""
    stage.add(name, make, coarse)


def build(out: Path) -> None:
    """Build the scene and write it."""
    writer = GlbWriter()
    stage = Stage(writer, materials(writer), bounce)
    furnish_court(stage)
    furnish_hall(stage)
    furnish_crypt(stage)
    stage.add("orrery_stand", *(placed(orrery_stand(d), -1.85, 0, -5.1) for d in (1.0, 0.4)))
    standing = outlines(stage.solid())
    for group in (walls(), floors(standing), ceilings(), friezes()):
        for name, parts in group.items():
            stage.add(name, parts)
    outside(stage)
    voxels = stage.voxels(0.06)
    stage.write(voxels)
    orrery(stage)
    incense_burner(stage)
    writer.save(out)


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("temple.glb"))
