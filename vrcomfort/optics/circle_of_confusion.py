"""Circle of confusion: how far a point spreads on the image, and the disc it spreads over.

NumPy twins, in float64, of ``shaders/include/coc.glsl`` (the rest of them:
``tests/oracles``). Every amount is a **radius** in pixels of image width. Signs: negative
in front of the focus distance, positive behind it.

Laws of the radius: `linear` in metres of defocus; all others are proportional to |1/f − 1/d| and
differ in how many pixels a dioptre is worth (`px_per_dioptre`).
"""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array, Fov

Law: TypeAlias = Literal["linear", "dioptre"]

CLOSEST_FOCUS = 1.001
"""In focal lengths: no lens focuses at or inside its focal length."""


def radius_of_percent(percent: float, width_px: int) -> float:
    """Return r_max, a percentage of one eye's image width, in pixels (Carnegie & Rhee 2015)."""
    return percent / 100 * width_px


def limit_distances_m(focus_m: float, limit_dioptre: float) -> tuple[float, float]:
    """Return between which distances the defocus from `focus_m` is less than this.

    The second is infinite where not even the sky is so far out of focus.
    """
    behind = 1 / focus_m - limit_dioptre
    return 1 / (1 / focus_m + limit_dioptre), 1 / behind if behind > 0 else math.inf


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
    max_radius_px: float,
    full_blur: float,
    slope: ArrayLike = 1.0,
    offset_m: float = 0.0,
    infinity_m: float = 30_000.0,
) -> Array:
    """Return (...,) signed radii of reverse-Z depths, limited to ±`max_radius_px`.

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
    # A canted display may see more than 90° from the head's axis, where the slope is not positive.
    farthest = np.maximum(n, 1e-6 * near_m) / (infinity_m - offset_m)
    z = np.maximum(np.asarray(depth, dtype=np.float64), farthest)
    defocus = n + (offset_m - focus) * z
    if law == "linear":
        defocus = defocus / z
        full_blur = max(full_blur, focus)
    else:
        defocus = defocus / (focus * np.maximum(n + offset_m * z, 1e-6 * near_m))
    return np.clip(defocus * (max_radius_px / full_blur), -max_radius_px, max_radius_px)


def lens_focus_m(focus_m: float, focal_length_m: float) -> float:
    """Return the distance at which a lens of this focal length can be focused, from it.

    At f_d = f the image would lie at infinity and inside there is none, so that
    ``CLOSEST_FOCUS · focal_length_m`` is the nearest focus.
    """
    return max(focus_m, CLOSEST_FOCUS * focal_length_m)


def eye_px_per_dioptre(pupil_mm: float, focal_px: float) -> float:
    """Return the radius of an eye's circle of confusion per dioptre of defocus.

    The diameter is the pupil's angle at the distance of the defocus, pupil_m · |1/f − 1/d| rad.
    """
    return pupil_mm / 2000 * focal_px


def thin_lens_px_per_dioptre(
    aperture_m: float, focal_length_m: float, focal_px: float, focus_m: float
) -> float:
    """Return the radius of a camera lens's circle of confusion per dioptre of defocus.

    Parameters
    ----------
    aperture_m
        Diameter of the opening.
    focal_px
        Focal length of the image: the pixels of one `focal_length_m` on the sensor.
    focus_m
        From the lens.

    Notes
    -----
    On the sensor the diameter is a·f·|f_d − z| / (z·(f_d − f)): Potmesil & Chakravarty 1982;
    Hillaire et al. 2008, Eq. 1; Mantiuk et al. 2011, Eq. 1. With focal_px / f pixels per metre that
    is a·focal_px · f_d/(f_d − f) · |1/z − 1/f_d|.
    """
    focus = lens_focus_m(focus_m, focal_length_m)
    return aperture_m / 2 * focal_px / (1 - focal_length_m / focus)
