"""Circle of confusion: how far a point spreads on the image, and the disc it spreads over.

NumPy twins, in float64, of ``shaders/include/coc.glsl``. Every amount is a **radius** in pixels of
image width. Signs: negative in front of the focus distance, positive behind it.
"""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array, Fov

Law: TypeAlias = Literal["linear", "dioptre"]


def max_radius_px(percent: float, width_px: int) -> float:
    """Return r_max, a percentage of one eye's image width, in pixels (Carnegie & Rhee 2015)."""
    return percent / 100 * width_px


def head_depth_slope(fov: Fov, head_forward_in_view: ArrayLike, uv: ArrayLike, /) -> Array:
    """Return (...,) metres along the head's forward axis per metre along the eye's own axis.

    Parameters
    ----------
    head_forward_in_view
        (3,) unit vector; (0, 0, −1) where displays are not canted, which gives exactly 1.
    uv
        (..., 2) image position, (0, 0) lower left, (1, 1) upper right.
    """
    forward = np.asarray(head_forward_in_view, dtype=np.float64)
    u, v = np.moveaxis(np.asarray(uv, dtype=np.float64), -1, 0)
    left, right, up, down = fov.tangents
    tangent_x = left + (right - left) * u
    tangent_y = down + (up - down) * v
    slope: Array = forward[0] * tangent_x + forward[1] * tangent_y - forward[2]
    return slope


def signed_radius_px(
    depth: ArrayLike,
    /,
    *,
    law: Law,
    focus_m: float,
    near_m: float,
    radius_limit_px: float,
    full_blur: float,
    slope: ArrayLike = 1.0,
    offset_m: float = 0.0,
    infinity_m: float = 30_000.0,
) -> Array:
    """Return (...,) signed radii of reverse-Z depths, limited to ±`radius_limit_px`.

    Parameters
    ----------
    depth
        (...,) ``near_m / distance`` along the eye's axis; 0 is the sky.
    focus_m
        Focus distance along the head's forward axis; `infinity_m` and beyond are all infinity.
    full_blur
        Defocus at which the radius reaches its limit: metres (`linear`; the focus distance where
        that is more) or dioptres (`dioptre`).
    slope
        (...,) of :func:`head_depth_slope`.
    offset_m
        How far the eye is in front of the head centre, along the head's forward axis.

    Notes
    -----
    With z = depth, n = near·slope and o = offset, the distance from the head is d = n/z + o. The
    defocus in metres is (n + (o − f)·z)/z and in dioptres the same over f·(n + o·z)/z, so no
    infinite distance is ever formed: in dioptres the radius is affine in z where o = 0.
    Carnegie & Rhee 2015, Algorithm 1, r_i ∝ |d_f − d_i|·r_max. The paper gives no constant: with
    1/d_max no room shows any blur, and with that of a room no landscape has anything sharp. So
    the constant is 1/full_blur up to a focus at that distance, and 1/d_f beyond.
    """
    n = near_m * np.asarray(slope, dtype=np.float64)
    focus = min(focus_m, infinity_m)
    farthest = np.maximum(n, 1e-6 * near_m) / (infinity_m - offset_m)
    z = np.maximum(np.asarray(depth, dtype=np.float64), farthest)
    defocus = n + (offset_m - focus) * z
    if law == "linear":
        defocus = defocus / z
        full_blur = max(full_blur, focus)
    else:
        defocus = defocus / (focus * np.maximum(n + offset_m * z, 1e-6 * near_m))
    return np.clip(defocus * (radius_limit_px / full_blur), -radius_limit_px, radius_limit_px)


def disc_weight(distance_px: ArrayLike, radius_px: ArrayLike, softness_px: float = 1.0, /) -> Array:
    """Return (...,) coverage of a point by a disc whose rim falls from 1 to 0 over `softness_px`.

    At radius 0.5 and softness 1 only the disc's own pixel is covered: the image is unchanged.
    """
    excess = np.asarray(radius_px, dtype=np.float64) - np.asarray(distance_px, dtype=np.float64)
    return np.clip(excess / softness_px + 0.5, 0.0, 1.0)


def disc_area_px(radius_px: ArrayLike, softness_px: float = 1.0, /) -> Array:
    """Return the (...,) integral of :func:`disc_weight` over the plane, in square pixels."""
    radius = np.asarray(radius_px, dtype=np.float64)
    half = softness_px / 2
    return np.where(
        radius >= half,
        np.pi * (radius**2 + softness_px**2 / 12),
        np.pi * (radius + half) ** 3 / (3 * softness_px),
    )


def grid_radius_px(radius_px: ArrayLike, /) -> Array:
    """Return the (...,) radius at which a small disc, summed over pixels, is as wide as it should.

    On the pixel grid, :func:`disc_weight` of softness 1 does not have the variance of a pixel that
    is spread over a disc, r²/4 + 1/12 (20 % more at 1 px); at the radius returned it does. For
    radii from 0.5 (nothing but the pixel itself) to 2 px.
    """
    radii = np.arange(0.5, 2.25, 0.25)
    at = [0.5, 0.703, 0.932, 1.11, 1.558, 1.772, 1.928]
    return np.interp(np.asarray(radius_px, dtype=np.float64), radii, at)


def ring_directions(rings: int) -> Array:
    """Return (4·rings·(rings + 1), 2) unit vectors: 8 taps for the first ring, 16 for the second.

    Rings of 8·k taps and one tap in the centre share a disc of radius (rings + 1/2)·spacing
    equally: each has :func:`tap_area_px`. Ring k lies at √(k² + 1/4)·spacing, where the mean square
    distance of its annulus is, so the pattern's second moment is the disc's. Every second ring is
    turned by half a step, so that taps do not line up in spokes.
    """
    angles = [2 * np.pi * (np.arange(8 * k) + 0.5 * (k % 2)) / (8 * k) for k in range(1, rings + 1)]
    angle = np.concatenate(angles)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def ring_radius_px(ring: int, spacing_px: float) -> float:
    """Return how far the taps of a ring (1, 2, …) are from the middle."""
    return spacing_px * math.sqrt(ring**2 + 0.25)


def tap_area_px(spacing_px: float) -> float:
    """Return the area that one tap of a ring pattern stands for."""
    return np.pi / 4 * spacing_px**2
