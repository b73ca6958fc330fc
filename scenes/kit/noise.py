"""Seeded noise: periodic pictures, and gradient noise at any place."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


def cloud(
    seed: int,
    size: int,
    *,
    exponent: float = 1.6,
    low: float = 1,
    high: float | None = None,
    stretch: tuple[float, float] = (1.0, 1.0),
) -> Array:
    """Return a (size, size) picture that repeats, with a 1/f^exponent spectrum, in [0, 1].

    `low` and `high` bound the frequencies (cycles per picture); `stretch` divides the
    (vertical, horizontal) frequency, for grain.
    """
    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    fy = np.fft.fftfreq(size, 1 / size)[:, None] * stretch[0]
    fx = np.fft.rfftfreq(size, 1 / size)[None, :] * stretch[1]
    frequency = np.hypot(fy, fx)
    keep = (frequency >= low) & (frequency <= (high or size / 3))
    shaped = spectrum * np.where(keep, np.maximum(frequency, 1e-9) ** -exponent, 0)
    picture = np.fft.irfft2(shaped, s=(size, size))
    spread = picture.std() or 1.0
    return np.clip(0.5 + picture / spread / 6, 0, 1)


def _hash(x: NDArray[np.int64], z: NDArray[np.int64], seed: int) -> NDArray[np.uint64]:
    """Mix integer coordinates to 64 random bits (after splitmix64)."""
    with np.errstate(over="ignore"):
        h = x.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        h ^= z.astype(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F)
        h += np.uint64(seed * 0x165667B1 + 0x27D4EB2F)
        h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return h ^ (h >> np.uint64(31))


def _gradients(x: Array, z: Array, seed: int) -> tuple[Array, Array]:
    """Return the unit gradients at whole coordinates of any shape."""
    h = _hash(x.astype(np.int64), z.astype(np.int64), seed)
    angle = (h >> np.uint64(40)).astype(np.float64) * (2 * np.pi / 2**24)
    return np.cos(angle), np.sin(angle)


def gradient_noise(x: Array, z: Array, seed: int) -> Array:
    """Return Perlin's gradient noise, about −0.7 to 0.7, at places of any shape."""
    x0, z0 = np.floor(x), np.floor(z)
    fx, fz = x - x0, z - z0
    ux, uz = (f * f * f * (f * (f * 6 - 15) + 10) for f in (fx, fz))
    total = np.zeros_like(fx)
    corner = _corners(x0, z0, seed)
    for dx in (0, 1):
        for dz in (0, 1):
            cos, sin = corner(dx, dz)
            dot = cos * (fx - dx) + sin * (fz - dz)
            total += dot * (ux if dx else 1 - ux) * (uz if dz else 1 - uz)
    return total


def _corners(x0: Array, z0: Array, seed: int) -> Callable[[int, int], tuple[Array, Array]]:
    """Return the gradients at a corner of each place's cell; made once where cells are shared."""
    low, high = ((int(x0.min()), int(z0.min())), (int(x0.max()), int(z0.max())))
    columns, rows = high[0] - low[0] + 2, high[1] - low[1] + 2
    if columns * rows > x0.size:
        return lambda dx, dz: _gradients(x0 + dx, z0 + dz, seed)
    along, across = np.arange(columns) + low[0], np.arange(rows)[:, None] + low[1]
    cos, sin = _gradients(*np.broadcast_arrays(along, across), seed)
    cell = (z0 - low[1]).astype(np.intp) * columns + (x0 - low[0]).astype(np.intp)

    def shared(dx: int, dz: int) -> tuple[Array, Array]:
        at = cell + (dz * columns + dx)
        return cos.ravel()[at], sin.ravel()[at]

    return shared


def fractal(x: Array, z: Array, seed: int, *, octaves: int, gain: float = 0.5) -> Array:
    """Return summed octaves of gradient noise, about −1 to 1."""
    total, strength = np.zeros_like(x), 1.0
    for octave in range(octaves):
        total += strength * gradient_noise(
            x * 2**octave + 17.3 * octave, z * 2**octave, seed + octave
        )
        strength *= gain
    return total * 1.4


def ridges(x: Array, z: Array, seed: int, *, octaves: int, gain: float = 0.5) -> Array:
    """Return ridged multifractal noise in about 0 to 1.6: sharp crests, detail gathers on them."""
    total, strength, weight = np.zeros_like(x), 1.0, np.ones_like(x)
    for octave in range(octaves):
        shift = 31.7 * octave
        crest = (
            1
            - np.abs(gradient_noise(x * 2**octave + shift, z * 2**octave - shift, seed + octave))
            * 1.8
        )
        crest = np.maximum(crest, 0) ** 2 * weight
        total += crest * strength
        weight = np.clip(crest * 1.6, 0, 1)
        strength *= gain
    return total * 0.75
