"""Procedural surfaces: a tone picks a colour from a ramp, a height gives a normal map.

Pictures are square, repeat, and are stored with a palette (one ramp per ingredient), which keeps
the files small without any loss.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Array: TypeAlias = NDArray[np.float64]
Ramp: TypeAlias = Sequence[tuple[int, int, int]]
"""sRGB colours from tone 0 to tone 1."""


def ramp_png(
    tone: Array, ingredient: NDArray[np.int64] | int, ramps: Sequence[Ramp], *, levels: int = 28
) -> bytes:
    """Return a palette PNG: `ingredient` chooses the ramp, `tone` in [0, 1] the place on it, in `levels` steps."""
    levels = min(levels, 256 // len(ramps))
    step = np.round(np.clip(tone, 0, 1) * (levels - 1)).astype(np.int64)
    index = np.asarray(ingredient) * levels + step
    palette = np.concatenate([_spread(ramp, levels) for ramp in ramps]).astype(np.uint8)
    picture = Image.fromarray(index.astype(np.uint8), mode=None).convert("L")
    picture.putpalette(palette.tobytes(), "RGB")
    return _png(picture)


def _spread(ramp: Ramp, levels: int) -> Array:
    stops = np.linspace(0, 1, len(ramp))
    at = np.linspace(0, 1, levels)
    colors = np.array(ramp, dtype=np.float64)
    return np.stack([np.interp(at, stops, colors[:, c]) for c in range(3)], axis=1).round()


def _png(picture: Image.Image) -> bytes:
    out = io.BytesIO()
    picture.save(out, "PNG", compress_level=9)
    return out.getvalue()


def rgb_png(color: Array, *, levels: int = 64) -> bytes:
    """Return a PNG of (h, w, 3) sRGB in [0, 255], each channel rounded to `levels` steps."""
    step = 255 / (levels - 1)
    return _png(Image.fromarray((np.round(np.clip(color, 0, 255) / step) * step).astype(np.uint8)))


def cutout_png(color: Array, alpha: Array) -> bytes:
    """Return an RGBA PNG of (h, w, 3) sRGB in [0, 255] and (h, w) alpha in [0, 1]."""
    rgba = np.concatenate([np.round(color / 5) * 5, alpha[..., None] * 255], axis=2)
    return _png(Image.fromarray(np.clip(rgba, 0, 255).round().astype(np.uint8)))


def normal_png(height: Array, *, strength: float, levels: int = 31) -> bytes:
    """Return a tangent-space normal map of a periodic (h, w) height.

    `strength` is the slope of a rise of 1 over one texel.
    """
    slope_u = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2 * strength
    slope_v = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2 * strength
    return slopes_png(-slope_u, slope_v, levels=levels)


def slopes_png(right: Array, up: Array, *, levels: int = 31) -> bytes:
    """Return a normal map of normals (right, up, 1), both within ± 1.

    The map holds them before normalisation: slopes, which average rightly in mipmaps.
    """
    half = (levels - 1) / 2
    xy = np.clip(np.stack([right, up], axis=-1), -1, 1)
    stepped = np.round((np.round(xy * half) / half * 0.5 + 0.5) * 254)
    rgb = np.concatenate([stepped, np.full((*right.shape, 1), 255.0)], axis=2)
    return _png(Image.fromarray(rgb.astype(np.uint8)))


def coordinates(size: int) -> tuple[Array, Array]:
    """Return u (to the right) and v (down) of every texel centre, in [0, 1)."""
    axis = (np.arange(size) + 0.5) / size
    return np.broadcast_to(axis, (size, size)), np.broadcast_to(axis[:, None], (size, size))


def step(edge: float, x: Array, width: float) -> Array:
    """Return a smooth step from 0 to 1 as `x` passes `edge` within ± `width`."""
    t = np.clip((x - edge) / (2 * width) + 0.5, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))


def blurred(picture: Array, radius: float) -> Array:
    """Return a periodic picture convolved with a Gaussian of `radius` texels."""
    fy = np.fft.fftfreq(picture.shape[0])[:, None]
    fx = np.fft.rfftfreq(picture.shape[1])[None, :]
    gauss = np.exp(-2 * (np.pi * radius) ** 2 * (fx * fx + fy * fy))
    return np.fft.irfft2(np.fft.rfft2(picture) * gauss, s=picture.shape)


def hollow(height: Array, radius: float) -> Array:
    """Return how deep each texel lies below its surroundings: a cheap ambient occlusion."""
    return np.clip(blurred(height, radius) - height, 0, None)
