"""Circle of confusion: what only the shaders compute of it, and tests need besides.

NumPy twins, in float64, of ``shaders/include/coc.glsl``, ``coc_of_depth.glsl`` and ``gather.glsl``,
as `vrcomfort.optics.circle_of_confusion` is. Every amount is a **radius** in pixels of image
width, negative in front of the focus distance, positive behind it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array, Fov, Pose, rotate
from vrcomfort.optics.circle_of_confusion import lens_focus_m, signed_radius_px

LEAST_COSINE = 1e-3
"""Stands for 90° and beyond in peripheral blur, which diverges there."""


def lens_radius_px(
    depth: ArrayLike,
    /,
    *,
    px_per_dioptre: float,
    focus_m: float,
    near_m: float,
    max_radius_px: float,
    slope: ArrayLike = 1.0,
    offset_m: float = 0.0,
    infinity_m: float = 30_000.0,
    focal_length_m: float = 0.0,
    distance_offset_m: float = 0.0,
) -> Array:
    """Return (...,) signed radii of `eye` (without the last two) and `thin_lens`, limited.

    Parameters
    ----------
    px_per_dioptre
        For `thin_lens` that of the lens focused at infinity: ``aperture_m / 2 · focal_px``.
    distance_offset_m
        Added to the distances of focus and point alike: how far the lens is behind the head
        centre (Mantiuk et al. 2011: 60 cm between eyes and screen).

    The other parameters are those of :func:`signed_radius_px`.
    """
    focus = lens_focus_m(min(focus_m, infinity_m) + distance_offset_m, focal_length_m)
    px = px_per_dioptre / (1 - focal_length_m / focus)
    if px == 0.0 or max_radius_px == 0.0:
        return np.zeros(np.broadcast(np.asarray(depth), np.asarray(slope)).shape)
    return signed_radius_px(
        depth,
        law="dioptre",
        focus_m=focus,
        near_m=near_m,
        max_radius_px=max_radius_px,
        full_blur=max_radius_px / px,
        slope=slope,
        offset_m=offset_m + distance_offset_m,
        infinity_m=infinity_m + distance_offset_m,
    )


def distance_from_head_m(
    depth: ArrayLike, /, *, fov: Fov, near_m: float, head_from_eye: Pose, uv: ArrayLike
) -> Array:
    """Return the (...,) distances from the head centre of what an eye sees, inf for the sky.

    Parameters
    ----------
    depth
        (...,) reverse-Z of the eye.
    uv
        (..., 2) image position, (0, 0) lower left, (1, 1) upper right.
    """
    z = np.asarray(depth, dtype=np.float64)[..., None]
    left, right, up, down = fov.tangents
    low, high = np.array([left, down]), np.array([right, up])
    tangents = low + (high - low) * np.asarray(uv, dtype=np.float64)
    ray = np.concatenate([tangents, np.full((*tangents.shape[:-1], 1), -1.0)], axis=-1)
    in_view = ray * (near_m / np.where(z > 0, z, 1.0))
    in_head = rotate(head_from_eye.orientation, in_view) + head_from_eye.position
    found: Array = np.where(z[..., 0] > 0, np.linalg.norm(in_head, axis=-1), np.inf)
    return found


def with_peripheral_px(
    radius_px: ArrayLike,
    cos_angle: ArrayLike,
    /,
    *,
    unit_px: float,
    exponent: float,
    max_radius_px: float,
) -> Array:
    """Return (...,) signed radii with peripheral blur on top; signs and their order stay.

    Parameters
    ----------
    cos_angle
        (...,) cosine of the angle between the pixel and the head's forward axis.
    unit_px
        Radius where 1/cos − 1 is 1, at 60°.

    Notes
    -----
    Hillaire et al. 2008, Eq. 5 and 6: min(D_max, DoF + (1/(z·p) − 1)^n). It diverges at 90°, where
    the cosine is taken as `LEAST_COSINE`.
    """
    radius = np.asarray(radius_px, dtype=np.float64)
    cosine = np.clip(np.asarray(cos_angle, dtype=np.float64), LEAST_COSINE, 1.0)
    total = np.minimum(np.abs(radius) + unit_px * (1 / cosine - 1) ** exponent, max_radius_px)
    return np.where(radius < 0, -total, total)


def disc_weight(
    distance_px: ArrayLike, radius_px: ArrayLike, softness_px: ArrayLike = 1.0, /
) -> Array:
    """Return (...,) coverage of a point by a disc whose rim falls from 1 to 0 over `softness_px`.

    At radius 0.5 and softness 1 only the disc's own pixel is covered: the image is unchanged.
    """
    excess = np.asarray(radius_px, dtype=np.float64) - np.asarray(distance_px, dtype=np.float64)
    return np.clip(excess / np.asarray(softness_px, dtype=np.float64) + 0.5, 0.0, 1.0)


def disc_area_px(radius_px: ArrayLike, softness_px: ArrayLike = 1.0, /) -> Array:
    """Return the (...,) integral of :func:`disc_weight` over the plane, in square pixels."""
    radius = np.asarray(radius_px, dtype=np.float64)
    softness = np.asarray(softness_px, dtype=np.float64)
    half = softness / 2
    return np.where(
        radius >= half,
        np.pi * (radius**2 + softness**2 / 12),
        np.pi * (radius + half) ** 3 / (3 * softness),
    )
