"""Which boxes a frustum can see: six dot products per box, all boxes at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array

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


def visible(planes: Array, centers: Array, halves: Array) -> NDArray[np.bool_]:
    """Return False for the axis-aligned boxes that lie wholly outside of one plane.

    Parameters
    ----------
    planes
        (k, 4) in the frame of the boxes, or (views, k, 4) for several frusta.
    centers, halves
        (n, 3) centres and half extents; centres may be (views, n, 3), each view's in its own
        frame. A box that only its corner planes would exclude is kept.

    Returns
    -------
    ndarray
        (n,), or (views, n) for several frusta.
    """
    normals = planes[..., :3]
    reach = normals @ centers.swapaxes(-1, -2)
    reach += np.abs(normals) @ halves.T
    return np.asarray((reach >= -planes[..., 3:]).all(axis=-2))


def lengths(vectors: Array) -> Array:
    """Return (...,) lengths of (..., 3) vectors."""
    return np.asarray(np.sqrt(np.einsum("...j,...j->...", vectors, vectors)))


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
