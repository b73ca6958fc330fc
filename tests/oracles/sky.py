"""Radiance of the sky by direction: NumPy twins of ``shaders/include/sky.glsl``.

Directions are (..., 3) unit vectors in world axes, +Y up.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vrcomfort.geometry import Array

SUN_COS = 0.99998892
"""Cosine of the sun's angular radius, 0.27°."""

SUN_SOLID_ANGLE = 6.96e-5
"""Steradians."""

BRIGHTEST = 60_000.0
"""Radiance that the sun's disc is limited to: half floats end at 65,504."""

_OCTAVE = np.array([[1.6, -1.2], [1.2, 1.6]])
"""Turns by 37° and doubles, so that the lattice of one octave does not show in the next."""


class SkyLight(Protocol):
    """What is needed of `scene.data.Environment`."""

    @property
    def sun_direction(self) -> Array:
        """Return (3,) unit vector to the sun."""

    @property
    def sun_irradiance(self) -> tuple[float, float, float]:
        """Return linear RGB on a surface that faces the sun."""

    @property
    def sky_zenith(self) -> tuple[float, float, float]:
        """Return linear RGB radiance overhead."""

    @property
    def sky_horizon(self) -> tuple[float, float, float]:
        """Return linear RGB radiance at the horizon."""

    @property
    def ground(self) -> tuple[float, float, float]:
        """Return linear RGB radiance of the ground."""

    @property
    def cloud_cover(self) -> float:
        """Return the share of the sky that clouds cover."""


def sky_radiance(direction: ArrayLike, light: SkyLight, /) -> Array:
    """Return (..., 3) radiance: gradient, glow around the sun, clouds if any, the sun's disc."""
    ray = np.asarray(direction, dtype=np.float64)
    sun = np.array(light.sun_irradiance)
    to_sun = np.maximum(ray @ light.sun_direction, 0)[..., None]
    radiance = sky_gradient(ray, light) + sun * (0.10 * to_sun**12 + 0.5 * to_sun**320) * 0.3
    disc = _smoothstep(SUN_COS, SUN_COS + 4e-6, to_sun)
    if light.cloud_cover > 0:
        up = np.maximum(ray[..., 1], 0)
        above = np.stack([ray[..., 0], up, ray[..., 2]], axis=-1)
        density = cloud_density(above, light.cloud_cover)[..., None]
        lit = sun * (0.22 + 0.25 * to_sun**6) + 0.6 * np.array(light.sky_zenith)
        opacity = density * _smoothstep(0.0, 0.25, up)[..., None] * 0.92
        radiance = _mix(radiance, _mix(lit, 0.55 * lit, density**2), opacity)
        disc = disc * (1 - opacity)
    brightest: Array = radiance + disc * np.minimum(sun / SUN_SOLID_ANGLE, BRIGHTEST)
    return brightest


def sky_gradient(direction: ArrayLike, light: SkyLight, /) -> Array:
    """Return (..., 3) radiance between zenith, horizon and ground, without sun and clouds."""
    up = np.asarray(direction, dtype=np.float64)[..., 1:2]
    thickness = (1 - np.maximum(up, 0)) ** 4
    above = _mix(np.array(light.sky_zenith), np.array(light.sky_horizon), thickness)
    return _mix(above, np.array(light.ground), _smoothstep(0.0, 0.12, -up))


def cloud_density(direction: ArrayLike, cover: float, /) -> Array:
    """Return (...,) share of light that clouds take at directions above the horizon."""
    ray = np.asarray(direction, dtype=np.float64)
    p = ray[..., [0, 2]] * (2.2 / (ray[..., 1:2] + 0.12)) + [3.7, 1.3]
    total = np.zeros(p.shape[:-1])
    for octave in range(5):
        total = total + 0.5 ** (octave + 1) * value_noise(p)
        p = p @ _OCTAVE.T
    return _smoothstep(1 - cover, 1.35 - cover, total * 1.1)


def value_noise(p: ArrayLike, /) -> Array:
    """Return (...,) noise in [0, 1] at (..., 2), smooth between the points of a lattice."""
    point = np.asarray(p, dtype=np.float64)
    cell = np.floor(point)
    f = point - cell
    f = f * f * (3 - 2 * f)
    near, far = ([_hash(cell + np.array([x, y])) for x in (0, 1)] for y in (0, 1))
    row = [_mix(a, b, f[..., 1]) for a, b in zip(near, far, strict=True)]
    return _mix(row[0], row[1], f[..., 0])


def _hash(cell: Array) -> Array:
    """Return (...,) values in [0, 1] of cells: pcg (Jarzynski & Olano, JCGT 2020), 32 bits."""
    x, y = np.moveaxis((cell.astype(np.int64) + 32768) & 0xFFFFFFFF, -1, 0).astype(np.uint64)
    state = _low(x * np.uint64(1664525) + y * np.uint64(22695477))
    state = _low(state * np.uint64(747796405) + np.uint64(2891336453))
    turned = (state >> ((state >> np.uint64(28)) + np.uint64(4))) ^ state
    state = _low(turned * np.uint64(277803737))
    return ((state >> np.uint64(22)) ^ state) / 2.0**32


def _low(value: NDArray[np.uint64]) -> NDArray[np.uint64]:
    low: NDArray[np.uint64] = value & np.uint64(0xFFFFFFFF)
    return low


def _mix(a: ArrayLike, b: ArrayLike, share: ArrayLike) -> Array:
    start = np.asarray(a, dtype=np.float64)
    return np.asarray(start + (np.asarray(b) - start) * np.asarray(share))


def _smoothstep(low: float, high: float, value: ArrayLike) -> Array:
    t = np.clip((np.asarray(value, dtype=np.float64) - low) / (high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
