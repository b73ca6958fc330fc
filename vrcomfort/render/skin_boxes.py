"""Boxes around meshes that joints bend: each vertex is within the boxes that its joints move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.render import culling
from vrcomfort.scene.data import Scene
from vrcomfort.scene.skinning import Bending


@dataclass(frozen=True, eq=False)
class SkinBoxes:
    """The vertices of each joint of each drawn thing, boxed as they are in the file.

    Parameters
    ----------
    rows
        (k,) drawn things that have a skin.
    starts
        (k,) where the boxes of each begin; the arrays below are (boxes,) or (boxes, 3).
    node, joint
        Node of a box's thing, and joint in the list of all.
    """

    rows: NDArray[np.intp]
    starts: NDArray[np.intp]
    node: NDArray[np.intp]
    joint: NDArray[np.intp]
    centers: Array
    halves: Array

    @classmethod
    def of(cls, scene: Scene, items: Sequence[tuple[int, int]]) -> SkinBoxes:
        """Box the vertices of (node, primitive) items by joint."""
        rows, counts, node, joint = [], [], [], []
        corners = [np.zeros((0, 2, 3))]
        for row, (place, primitive) in enumerate(items):
            skin, bending = scene.nodes[place].skin, scene.primitives[primitive].bending
            if skin is not None and bending is not None:
                used, boxes = _boxes(scene.primitives[primitive].positions, bending)
                rows.append(row)
                counts.append(len(used))
                node += [place] * len(used)
                joint += (used + scene.all_skins.first[skin]).tolist()
                corners.append(boxes)
        lower, upper = np.concatenate(corners).swapaxes(0, 1)
        starts = np.cumsum([0, *counts])[:-1]
        return cls(
            rows=np.array(rows, dtype=np.intp),
            starts=starts,
            node=np.array(node, dtype=np.intp),
            joint=np.array(joint, dtype=np.intp),
            centers=(lower + upper) / 2,
            halves=(upper - lower) / 2,
        )

    def world_boxes(self, world_from_node: Array, place_from_bind: Array) -> tuple[Array, Array]:
        """Return (k, 3) centres and half extents of the world-space boxes of `rows`."""
        world_from_bind = world_from_node[self.node] @ place_from_bind[self.joint]
        centers, halves = culling.transformed_boxes(world_from_bind, self.centers, self.halves)
        lower = np.minimum.reduceat(centers - halves, self.starts)
        upper = np.maximum.reduceat(centers + halves, self.starts)
        return (lower + upper) / 2, (upper - lower) / 2


def _boxes(positions: NDArray[np.float32], bending: Bending) -> tuple[NDArray[np.intp], Array]:
    """Return the joints that bend a mesh, and (joints, 2, 3) corners of their vertices."""
    vertex, slot = np.nonzero(bending.weights > 0)
    joint = bending.joints[vertex, slot].astype(np.intp)
    order = np.argsort(joint, kind="stable")
    used, starts = np.unique(joint[order], return_index=True)
    places = positions[vertex[order]].astype(np.float64)
    corners = [extreme.reduceat(places, starts) for extreme in (np.minimum, np.maximum)]
    return used, np.stack(corners, axis=1)
