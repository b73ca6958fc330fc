"""Collects named nodes, bakes their light, and writes them with their levels of detail."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .glb import GlbWriter
from .light import Voxels, baked, voxelise
from .mesh import Array, Mesh, join
from .ornaments import Parts

NOT_SOLID = {"frond", "flame", "water", "needles", "grass", "earth"}
"""Materials that block no baked light and take none in their alpha."""


@dataclass
class Stage:
    """A scene under construction: world-space parts by node name."""

    writer: GlbWriter
    materials: dict[str, int]
    bounce: Callable[[Array], Array]
    """Share of the sky's light that walls around give back, at (n, 3) places."""
    nodes: dict[str, list[Parts]] = field(default_factory=dict)
    """Levels of detail of each node, finest first."""

    def add(self, name: str, *levels: Parts) -> None:
        """Add a node; the first level is the finest."""
        if name in self.nodes:
            raise ValueError(f"two nodes are called {name}")
        self.nodes[name] = list(levels)

    def solid(self) -> list[Mesh]:
        """Return what blocks the light, from the finest levels."""
        return [
            m for levels in self.nodes.values() for m, name in levels[0] if name not in NOT_SOLID
        ]

    def voxels(self, cell_m: float, *more: Mesh) -> Voxels:
        """Return the cubes that block the light, `more` meshes' among them."""
        return voxelise([*self.solid(), *more], cell_m)

    def write(self, voxels: Voxels) -> None:
        """Bake and write all nodes; coarser levels become nodes outside the scene graph."""
        for name, levels in self.nodes.items():
            for level, parts in enumerate(levels):
                mesh = self.writer.mesh(f"{name}_lod{level}", self.lit(voxels, parts))
                self.writer.node(
                    name if level == 0 else f"{name}_lod{level}", mesh, root=level == 0
                )

    def lit(self, voxels: Voxels, parts: Parts) -> list[tuple[Mesh, int]]:
        """Return baked meshes, one for each material."""
        by_material: dict[str, list[Mesh]] = {}
        for mesh, name in parts:
            by_material.setdefault(name, []).append(mesh)
        return [
            (self._lit(voxels, join(meshes), name), self.materials[name])
            for name, meshes in by_material.items()
        ]

    def _lit(self, voxels: Voxels, mesh: Mesh, name: str) -> Mesh:
        if name in NOT_SOLID:
            return mesh
        return baked(voxels, mesh, bounce=self.bounce(mesh.positions))


def triangles(parts: Parts) -> int:
    """Return how many triangles the parts have."""
    return int(np.sum([len(mesh.indices) for mesh, _ in parts]))
