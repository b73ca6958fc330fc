"""Frustum culling of boxes, all at once, and boxes around skinned meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array
from vrcomfort.scene.animation import Bending
from vrcomfort.scene.data import Scene

_SIDES = np.array(
    [[1, 0, 0, 1], [-1, 0, 0, 1], [0, 1, 0, 1], [0, -1, 0, 1], [0, 0, -1, 1]], dtype=np.float64
)
"""Planes from the rows x, y, z, w of a projection: left, right, bottom, top, near."""


def planes(clip_from_source: Array, *, near: bool = True) -> Array:
    """Return (..., 5, 4) planes of (..., 4, 4) projections.

    A point is inside where ``plane · (x, y, z, 1) >= 0``.
    Left, right, bottom, top, near: reverse-Z with infinite far plane has no sixth.
    `near=False` leaves the near plane out, for targets that clamp depth instead of clipping.

    Notes
    -----
    Gribb & Hartmann, "Fast extraction of viewing frustum planes" (2001): −w ≤ x ≤ w becomes
    (row_w ± row_x) · p ≥ 0. Near is z ≤ w here.
    """
    return np.asarray((_SIDES if near else _SIDES[:4]) @ clip_from_source)


def from_origins(planes: Array, origins: Array) -> Array:
    """Return (views, k, 4) planes around (views or 1, 3) origins for boxes in one frame for all."""
    moved = planes.copy()
    moved[..., 3] -= (planes[..., :3] @ origins[:, :, None])[..., 0]
    return moved


def boxes(centers: Array, halves: Array) -> Array:
    """Return (7, n) axis-aligned boxes as `visible` takes them: centres, half extents, ones."""
    return np.concatenate([centers.T, halves.T, np.ones((1, len(centers)))])


def visible(planes: Array, boxes: Array) -> NDArray[np.bool_]:
    """Return False for the axis-aligned boxes that lie wholly outside of one plane.

    Parameters
    ----------
    planes
        (k, 4) in the frame of the boxes, or (views, k, 4) for several frusta.
    boxes
        (7, n), see :func:`boxes`. A box that only its corner planes would exclude is kept.

    Returns
    -------
    ndarray
        (n,), or (views, n) for several frusta.
    """
    flat = planes.reshape(-1, 4)
    weights = np.empty((len(flat), 7))
    weights[:, :3], weights[:, 6] = flat[:, :3], flat[:, 3]
    np.abs(flat[:, :3], out=weights[:, 3:6])
    # How far the corner that is furthest inside of a plane lies inside of it.
    reach = weights @ boxes
    inside = reach.reshape(*planes.shape[:-1], -1) >= 0
    return np.asarray(np.logical_and.reduce(inside, axis=-2))


def lengths(vectors: Array) -> Array:
    """Return (n,) lengths of (3, n) vectors."""
    squares = vectors * vectors
    return np.asarray(np.sqrt(squares[0] + squares[1] + squares[2]))


def transformed_boxes(
    target_from_source: Array, centers: Array, halves: Array
) -> tuple[Array, Array]:
    """Return centres and half extents of the boxes around transformed boxes.

    Parameters
    ----------
    target_from_source
        (n, 4, 4) affine transforms.
    centers, halves
        (n, 3) in the source frames.

    Notes
    -----
    Arvo, "Transforming axis-aligned bounding boxes", Graphics Gems (1990).
    """
    linear = target_from_source[:, :3, :3]
    moved = (linear @ centers[:, :, None])[..., 0] + target_from_source[:, :3, 3]
    return moved, (np.abs(linear) @ halves[:, :, None])[..., 0]


# Boxes around meshes that joints bend: each vertex is within the boxes that its joints move.


@dataclass(frozen=True, eq=False)
class SkinBoxes:
    """The vertices of each joint of each instance, boxed as they are in the file.

    Parameters
    ----------
    rows
        (k,) instances that have a skin.
    starts
        (k,) where the boxes of each begin; the arrays below are (boxes,) or (boxes, 3).
    node, joint
        Node of a box's instance, and joint in the list of all.
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
        centers, halves = transformed_boxes(world_from_bind, self.centers, self.halves)
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
