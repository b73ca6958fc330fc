"""Three engines' ways of depth of field at half resolution: NumPy twins, in float64.

Of ``half_resolution*.frag``, ``separable_gaussian.frag``, ``tent.frag`` and ``median.frag`` in
``shaders/depth_of_field``. Images are (h, w, 4) points: colour and signed radius in pixels of image
width, negative in front of the focus.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import maximum_filter, median_filter

from tests.oracles import pyramid
from vrcomfort.geometry import Array
from vrcomfort.render.effects.depth_of_field import kernels


def separable_gaussian(points: ArrayLike, /, *, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3): rows, then columns, of half the image, over the sharp one."""
    image = np.asarray(points, dtype=np.float64)
    half = halved(image, firefly=False)
    for axis in ((1.0, 0.0), (0.0, pixel_aspect)):
        half = _gaussian(half, axis)
    alpha = _smoothstep(*kernels.GAUSSIAN_FADE_PX, np.abs(image[..., 3]))[..., None]
    colours: Array = (1 - alpha) * image[..., :3] + alpha * _upsampled(half, image)[..., :3]
    return colours


def disc(points: ArrayLike, /, *, max_radius_px: float, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3): 43 samples as far as the widest disc goes, a tent, over the sharp image."""
    image = np.asarray(points, dtype=np.float64)
    half = halved(image, firefly=True)
    behind, front = np.zeros_like(half), np.zeros_like(half)
    margin = 2.0
    for offset in kernels.disc_taps():
        away_px = max_radius_px * offset
        distance_px = np.hypot(*away_px)
        tap = _at(half, away_px * [1.0, pixel_aspect] / 2)
        far_px = np.maximum(np.minimum(half[..., 3], tap[..., 3]), 0)
        far = np.clip((far_px - distance_px + margin) / margin, 0, 1)
        near = np.clip((-tap[..., 3] - distance_px + margin) / margin, 0, 1)
        near = near * (-tap[..., 3] >= margin)
        behind += far[..., None] * _weighted(tap)
        front += near[..., None] * _weighted(tap)
    back = _mean(behind, half[..., :3])
    fore = _mean(front, back)
    opacity = np.clip(front[..., 3:] * np.pi / len(kernels.disc_taps()), 0, 1)
    found = np.concatenate([(1 - opacity) * back + opacity * fore, opacity], axis=-1)
    steps = [np.array([x, y]) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    soft = _upsampled(np.mean([_at(found, step) for step in steps], axis=0), image)
    far = _smoothstep(*kernels.DISC_FADE_PX, image[..., 3])[..., None]
    alpha = far + soft[..., 3:] - far * soft[..., 3:]
    colours: Array = (1 - alpha) * image[..., :3] + alpha * soft[..., :3]
    return colours


def rings(points: ArrayLike, /, *, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3): rings behind and in front, a median of each, over the sharp image."""
    image = np.asarray(points, dtype=np.float64)
    half = halved(image, firefly=True)
    levels = [half[..., :3]]
    levels += [pyramid.mean_level(half[..., :3], k) for k in range(1, kernels.RING_MIPS + 1)]
    front_px = _tiles(np.maximum(-half[..., 3], 0))
    reach = np.maximum(half[..., 3], 0), front_px
    behind, front = _weighted(half), np.zeros_like(half)
    taps = 1 + 4 * kernels.RINGS * (kernels.RINGS - 1)
    for side, ring in np.ndindex(2, kernels.RINGS):
        for i in range(max(8 * ring, 1)):
            if side == 0 and ring == 0:
                continue
            angle = 2 * np.pi * (i + 0.5 * (ring & 1)) / max(8 * ring, 1)
            distance_px = reach[side] * ring / (kernels.RINGS - 1)
            way = np.array([np.cos(angle), np.sin(angle) * pixel_aspect])
            away = distance_px[..., None] * way / 2
            tap_px = _at(half, away)[..., 3]
            own_px = tap_px if side == 0 else -tap_px
            covers = np.clip(own_px - distance_px + 1, 0, 1) * (own_px >= 0.5) * (reach[side] >= 1)
            share = covers[..., None] * _weighted(_at_levels(levels, reach[side], away))
            if side == 0:
                behind += share
            else:
                front += share * (front_px**2 / taps / np.maximum(tap_px**2, 1))[..., None]
    background = _mean(behind, half[..., :3])
    foreground = np.concatenate([_mean(front, background), np.clip(front[..., 3:], 0, 1)], axis=-1)
    soft, over = (
        _upsampled(median_filter(each, (3, 3, 1), mode="nearest"), image)
        for each in (background, foreground)
    )
    far = _smoothstep(*kernels.RINGS_FADE_PX, image[..., 3])[..., None]
    colours = (1 - far) * image[..., :3] + far * soft
    shown: Array = (1 - over[..., 3:]) * colours + over[..., 3:] * over[..., :3]
    return shown


def halved(image: Array, *, firefly: bool) -> Array:
    """Return (⌈h/2⌉, ⌈w/2⌉, 4): means of 2 × 2 pixels, and the radius of greatest magnitude."""
    rows, columns = (range(0, size, 2) for size in image.shape[:2])
    return np.array([[_block(image[y : y + 2, x : x + 2], firefly) for x in columns] for y in rows])


def _block(pixels: Array, firefly: bool) -> Array:
    found = pixels.reshape(-1, 4)
    weight = 1 / (1 + found[:, :3].max(axis=-1)) if firefly else np.ones(len(found))
    colour = (weight[:, None] * found[:, :3]).sum(axis=0) / weight.sum()
    return np.append(colour, found[np.argmax(np.abs(found[:, 3])), 3])


def _gaussian(half: Array, axis: tuple[float, float]) -> Array:
    sigma = 0.25 * np.abs(half[..., 3]) * sum(axis)
    total = _weighted(half)
    texels = np.ceil(3 * sigma)
    for i in range(1, int(texels.max(initial=0)) + 1, 2):
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (np.exp(-0.5 * (j / sigma) ** 2) for j in (i, i + 1))
            away = i + np.where(first > 0, second / (first + second), 0)
        weight = np.where(i <= texels, first + second, 0)[..., None]
        step = away[..., None] * np.sign(axis)
        total += weight * (_weighted(_at(half, step)) + _weighted(_at(half, -step)))
    return np.concatenate([_mean(total, half[..., :3]), half[..., 3:]], axis=-1)


def _tiles(near_px: Array) -> Array:
    """Return (h, w): the largest of each texel's tile and, twice over, of the tiles around it."""
    side = kernels.RING_TILE
    rows, columns = (range(0, size, side) for size in near_px.shape)
    tiles = np.array([[near_px[y : y + side, x : x + side].max() for x in columns] for y in rows])
    for _ in range(kernels.RING_DILATIONS):
        tiles = maximum_filter(tiles, 3, mode="nearest")
    height, width = near_px.shape
    return tiles.repeat(side, axis=0).repeat(side, axis=1)[:height, :width]


def _at_levels(levels: list[Array], reach_px: Array, away: Array) -> Array:
    """Return (h, w, 3): what each pixel reads of the level that its reach asks for."""
    gap = np.maximum(0.5 * reach_px / (kernels.RINGS - 1), 1)
    level = np.clip(np.rint(np.log2(gap)), 0, kernels.RING_MIPS)[..., None]
    height, width = reach_px.shape
    middles = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)
    found = np.zeros((height, width, 3))
    for k, texels in enumerate(levels):
        found = np.where(level == k, _bilinear(texels, (middles + away) / 2**k), found)
    return found


def _at(image: Array, away: ArrayLike) -> Array:
    """Return the (h, w, n) image bilinearly read at an offset in texels from each middle."""
    height, width = image.shape[:2]
    middles = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)
    return _bilinear(image, middles + away)


def _bilinear(image: Array, place: Array) -> Array:
    height, width = image.shape[:2]
    corner = np.floor(place - 0.5)
    part = place - 0.5 - corner
    found = np.zeros((*place.shape[:2], image.shape[2]))
    for step in np.ndindex(2, 2):
        share = np.where(step, part, 1 - part).prod(axis=-1)
        column = np.clip(corner[..., 0] + step[0], 0, width - 1).astype(int)
        row = np.clip(corner[..., 1] + step[1], 0, height - 1).astype(int)
        found += share[..., None] * image[row, column]
    return found


def _upsampled(half: Array, image: Array) -> Array:
    return pyramid.magnified(half, 1, image.shape[:2])


def _weighted(pixels: Array) -> Array:
    return np.concatenate([pixels[..., :3], np.ones((*pixels.shape[:2], 1))], axis=-1)


def _mean(total: Array, otherwise: Array) -> Array:
    weight = total[..., 3:]
    return np.where(weight > 0, total[..., :3] / np.where(weight > 0, weight, 1), otherwise)


def _smoothstep(low: float, high: float, value: Array) -> Array:
    part = np.clip((value - low) / (high - low), 0, 1)
    return part * part * (3 - 2 * part)
