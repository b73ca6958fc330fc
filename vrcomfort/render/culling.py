"""Which boxes a frustum can see: six dot products per box, all boxes at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array


def planes(clip_from_source: Array, *, near: bool = True) -> Array:
    """Return (5, 4) planes of a frustum; a point is inside where ``plane · (x, y, z, 1) >= 0``.

    Left, right, bottom, top, near: reverse-Z with infinite far plane has no sixth.
    `near=False` leaves the near plane out, for targets that clamp depth instead of clipping.

    Notes
    -----
    Gribb & Hartmann, "Fast extraction of viewing frustum planes" (2001): −w ≤ x ≤ w becomes
    (row_w ± row_x) · p ≥ 0. Near is z ≤ w here.
    """
    x, y, z, w = clip_from_source
    return np.stack([w + x, w - x, w + y, w - y, *([w - z] if near else [])])


def visible(planes: Array, centers: Array, halves: Array) -> NDArray[np.bool_]:
    """Return (n,) False for the axis-aligned boxes that lie wholly outside of one plane.

    Parameters
    ----------
    planes
        (k, 4) in the frame of the boxes.
    centers, halves
        (n, 3) centres and half extents. A box that only its corner planes would exclude is kept.
    """
    normals = planes[:, :3]
    reach = centers @ normals.T + halves @ np.abs(normals).T + planes[:, 3]
    inside: NDArray[np.bool_] = np.all(reach >= 0, axis=1)
    return inside


def visible_in_views(clips_from_source: Array, centers: Array, halves: Array) -> NDArray[np.bool_]:
    """Return (views, n): `visible` for each of (views, 4, 4) projections, near planes included."""
    x, y, z, w = np.moveaxis(clips_from_source, 1, 0)
    sides = np.stack([w + x, w - x, w + y, w - y, w - z], axis=1)
    normals = sides[..., :3]
    reach = centers @ normals.swapaxes(1, 2) + halves @ np.abs(normals).swapaxes(1, 2)
    return np.asarray(np.all(reach + sides[:, None, :, 3] >= 0, axis=2))


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
    moved = np.einsum("nij,nj->ni", linear, centers) + target_from_source[:, :3, 3]
    return moved, np.einsum("nij,nj->ni", np.abs(linear), halves)
