"""Light on surfaces and through air: NumPy twins of ``light.glsl`` and ``surface.glsl``.

Vectors are (..., 3); directions are unit vectors that point away from the surface.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from vrcomfort.geometry import Array, normalize


def lamp_falloff(distance_m: ArrayLike, range_m: ArrayLike, /) -> Array:
    """Return (...,) 1/m²: inverse square, and zero at the range without an edge.

    Notes
    -----
    Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013, eq. 9; not above 10⁴/m² (1 cm).
    """
    distance = np.asarray(distance_m, dtype=np.float64)
    window = np.clip(1 - (distance / np.asarray(range_m, dtype=np.float64)) ** 4, 0, 1)
    falloff: Array = window**2 / np.maximum(distance**2, 1e-4)
    return falloff


def cone(angle_rad: ArrayLike, /, *, inner_rad: float, outer_rad: float) -> Array:
    """Return (...,) the share of a spot light at an angle from its direction.

    Notes
    -----
    Khronos KHR_lights_punctual, "Inner and Outer Cone Angles".
    """
    inner, outer = np.cos([inner_rad, outer_rad])
    inside = (np.cos(np.asarray(angle_rad, dtype=np.float64)) - outer) / max(inner - outer, 1e-3)
    return np.asarray(np.clip(inside, 0, 1) ** 2)


def through_air(
    radiance: ArrayLike, distance_m: ArrayLike, /, *, fog: ArrayLike, density_per_m: float
) -> Array:
    """Return (..., 3) radiance after (...,) metres of air that scatters `fog` (3,) into the way."""
    left = np.exp(-density_per_m * np.asarray(distance_m, dtype=np.float64))[..., None]
    air = np.asarray(fog, dtype=np.float64)
    seen: Array = air + (np.asarray(radiance, dtype=np.float64) - air) * left
    return seen


def specular(
    n: ArrayLike, v: ArrayLike, to_light: ArrayLike, f0: ArrayLike, alpha: ArrayLike, /
) -> Array:
    """Return (..., 3) GGX reflection of light from `to_light` towards `v`, without the factor n·l.

    Parameters
    ----------
    f0, alpha
        (..., 3) reflectance at normal incidence; (...,) squared roughness.

    Notes
    -----
    D·V·F of Filament, section 4, with Hammon's approximation of the Smith term. n·v is at least
    10⁻³, so that grazing views stay finite.
    """
    n, v, light = (np.asarray(each, dtype=np.float64) for each in (n, v, to_light))
    alpha = np.asarray(alpha, dtype=np.float64)
    h = normalize(v + light)
    n_l, n_h = (np.maximum(np.sum(n * each, axis=-1), 0) for each in (light, h))
    n_v = np.maximum(np.sum(n * v, axis=-1), 1e-3)
    d = n_h**2 * (alpha**2 - 1) + 1
    distribution = alpha**2 / (np.pi * d**2)
    visibility = 0.5 / ((1 - alpha) * 2 * n_l * n_v + alpha * (n_l + n_v))
    grazing = (1 - np.clip(np.sum(v * h, axis=-1), 0, 1))[..., None] ** 5
    f0 = np.asarray(f0, dtype=np.float64)
    reflected: Array = (f0 + (1 - f0) * grazing) * (distribution * visibility)[..., None]
    return reflected


def ambient_reflectance(f0: ArrayLike, roughness: ArrayLike, n_v: ArrayLike, /) -> Array:
    """Return (..., 3) reflectance for light from everywhere; `roughness` and `n_v` are (...,).

    Notes
    -----
    Karis, "Physically based shading on mobile" (2014).
    """
    r = np.asarray(roughness, dtype=np.float64)[..., None] * [-1, -0.0275, -0.572, 0.022]
    r += [1, 0.0425, 1.04, -0.04]
    grazing = np.exp2(-9.28 * np.asarray(n_v, dtype=np.float64))
    a004 = np.minimum(r[..., 0] ** 2, grazing) * r[..., 0] + r[..., 1]
    scale, bias = -1.04 * a004 + r[..., 2], 1.04 * a004 + r[..., 3]
    reflectance: Array = np.asarray(f0, dtype=np.float64) * scale[..., None] + bias[..., None]
    return reflectance
