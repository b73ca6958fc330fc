"""Three engines' ways of depth of field: NumPy twins, in float64.

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
from vrcomfort.render.display import mixed
from vrcomfort.render.effects.depth_of_field import engine_kernels


def separable_gaussian(points: ArrayLike, /, *, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3): rows, then columns."""
    image = np.asarray(points, dtype=np.float64)
    for axis in ((1.0, 0.0), (0.0, pixel_aspect)):
        image = _gaussian(image, axis)
    return image[..., :3]


def disc(points: ArrayLike, /, *, max_radius_px: float, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3): 43 samples as far as the widest disc goes, a tent, over the sharp image."""
    image = np.asarray(points, dtype=np.float64)
    half = halved(image, by_radius=True)
    behind, front = np.zeros_like(half), np.zeros_like(half)
    texel, margin = 2.0, 4.0
    reach_px = min(max_radius_px, np.abs(image[..., 3]).max())
    for offset in engine_kernels.disc_taps():
        away_px = reach_px * offset
        distance_px = np.hypot(*away_px)
        tap = _at(half, away_px * [1.0, pixel_aspect] / 2)
        far_px = np.maximum(np.minimum(half[..., 3], tap[..., 3]), 0)
        far = np.clip((far_px - distance_px + margin) / margin, 0, 1)
        near = np.clip((-tap[..., 3] - distance_px + margin) / margin, 0, 1)
        near = near * (-tap[..., 3] >= texel)
        behind += far[..., None] * _weighted(tap)
        front += near[..., None] * _weighted(tap)
    back = _mean(behind, half[..., :3])
    fore = _mean(front, back)
    opacity = np.clip(front[..., 3:] * np.pi / len(engine_kernels.disc_taps()), 0, 1)
    below = _smoothstep(texel, 2 * texel, half[..., 3])[..., None]
    colour = (1 - opacity) * below * back + opacity * fore
    found = np.concatenate([colour, 1 - (1 - opacity) * (1 - below)], axis=-1)
    steps = [np.array([x, y]) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    return _over(np.mean([_at(found, step) for step in steps], axis=0), image)


def rings(points: ArrayLike, /, *, max_radius_px: float, pixel_aspect: float = 1.0) -> Array:
    """Return (h, w, 3): rings behind and in front, a median, over the sharp image."""
    image = np.asarray(points, dtype=np.float64)
    half = halved(image, by_radius=False)
    levels = [half]
    for _ in range(engine_kernels.ring_levels(max_radius_px)):
        levels.append(_foremost(levels[-1]))
    tiles = _tiles(half[..., 3], engine_kernels.ring_dilations(max_radius_px))
    found = np.zeros_like(half)
    for row, column in np.ndindex(half.shape[:2]):
        pixel = _RingPixel(levels, (row, column), pixel_aspect)
        found[row, column] = pixel.seen(*tiles[row, column])
    calm = median_filter(found, (3, 3, 1), mode="nearest")
    return _over(np.where(_in_focus(tiles)[..., None], 0.0, calm), image)


class _RingPixel:
    """A texel of half resolution that looks around in rings."""

    def __init__(self, levels: list[Array], place: tuple[int, int], pixel_aspect: float) -> None:
        self._levels, self._aspect = levels, np.array([1.0, pixel_aspect])
        self._place = place
        self._middle = np.array([place[1], place[0]]) + 0.5
        row, column = (np.array([number], np.uint32) for number in place)
        one = mixed(column ^ mixed(row))
        turn, area = (float(number[0]) / 2**32 for number in (one, mixed(one)))
        angle = 2 * np.pi * turn
        self._noise = 0.5 / GAPS * np.sqrt(area) * np.array([np.cos(angle), np.sin(angle)])

    def seen(self, least_px: float, greatest_px: float) -> Array:
        """Return (4,) colour times opacity, and opacity."""
        if max(abs(least_px), abs(greatest_px)) < engine_kernels.IN_FOCUS_PX:
            return np.zeros(4)
        if greatest_px - least_px <= 0.05 * abs(greatest_px):
            return self._alike((abs(least_px) + abs(greatest_px)) / 2)
        front = self._front(-least_px) if least_px < 0 else np.zeros(4)
        own_px = abs(self._levels[0][(*self._place, 3)])
        back = self._back(own_px) if greatest_px > 0 else np.zeros(4)
        return front + (1 - front[3]) * back

    def _alike(self, kernel_px: float) -> Array:
        level = _level_of(self._levels, kernel_px)
        texels = self._levels[level][None]
        ways = [way for ring in range(engine_kernels.RINGS) for way in _ring(ring)]
        centre = self._middle + kernel_px * self._noise * self._aspect / 2
        places = centre + kernel_px * np.array(ways) * self._aspect / 2
        seen = np.array([_bilinear(texels[0], each[None, None] / 2**level) for each in places])
        opacity = np.clip(kernel_px - engine_kernels.IN_FOCUS_PX, 0, 1)
        return np.append(seen.mean(axis=0)[0, 0, :3], 1.0) * opacity

    def _tap(self, way: Array, kernel_px: float, level: int) -> Array:
        place = self._middle + kernel_px * (self._noise + way) * self._aspect / 2
        last = np.array(self._levels[0].shape[1::-1]) - 1
        column, row = np.clip(np.floor(place), 0, last).astype(int) >> level
        return self._levels[level][row, column]

    def _back(self, kernel_px: float) -> Array:
        if kernel_px <= engine_kernels.IN_FOCUS_PX:
            return np.zeros(4)
        level = _level_of(self._levels, kernel_px)
        total = np.zeros(5)  # colour, weight, weighted radius
        for ring in reversed(range(engine_kernels.RINGS)):
            ways = _ring(ring)
            distance_px = kernel_px * np.hypot(*(ways[0] + self._noise))
            border_px = kernel_px / GAPS * (ring + 0.5)
            here, wider = np.zeros(5), 0.0
            for way in ways:
                tap = self._tap(way, kernel_px, level)
                weight = _weight(tap[3], distance_px, level) if tap[3] > 0 else 0.0
                outside = float(np.clip(abs(tap[3]) - border_px + 0.5, 0, 1))
                if ring == engine_kernels.RINGS - 1:
                    outside = 1.0
                share = weight * np.array([*tap[:3], 1.0, tap[3]])
                total, here = total + outside * share, here + (1 - outside) * share
                wider += outside
            if here[3] > 0:
                keeps = 0.0
                if total[3] > 0:
                    step_px = np.clip(total[4] / total[3] - here[4] / here[3], 0, 1)
                    keeps = 1 - (1 - wider / len(ways)) * step_px
                total = keeps * total + here
        if total[3] == 0:
            return np.zeros(4)
        opacity = np.clip(total[4] - engine_kernels.IN_FOCUS_PX, 0, 1)
        opacity *= _smoothstep(engine_kernels.IN_FOCUS_PX, 2.0, np.asarray(kernel_px))
        return np.append(total[:3] / total[3], 1.0) * opacity

    def _front(self, kernel_px: float) -> Array:
        level = _level_of(self._levels, kernel_px)
        layers = np.zeros((2, 4))
        for ring in range(engine_kernels.RINGS):
            ways = _ring(ring)
            distance_px = kernel_px * np.hypot(*(ways[0] + self._noise)) if ring else 0.0
            for way in ways[: max(4 * ring, 1)]:
                pair = [
                    self._tap(each, kernel_px, level) for each in ([way, -way] if ring else [way])
                ]
                radius_px = min(tap[3] for tap in pair)
                weight = np.clip(-radius_px, 0, 1) * _weight(-radius_px, distance_px, level)
                behind = np.clip((radius_px + kernel_px - 2) / 2, 0, 1)
                colours = np.sum([[*tap[:3], 1.0] for tap in pair], axis=0)
                layers += weight * np.outer([1 - behind, behind], colours)
        count = engine_kernels.RINGS
        full = (2 * count - 1) ** 2 * _area_share(kernel_px * (count + 0.5) / count, level)
        front, back = np.clip(layers[:, 3] / full, 0, 1)
        colours = [part[:3] / part[3] if part[3] else np.zeros(3) for part in layers]
        colour = colours[0] * front + colours[1] * back * (1 - front)
        return np.append(colour, 1 - (1 - front) * (1 - back))


GAPS = engine_kernels.RINGS - 0.5


def _ring(ring: int) -> Array:
    """Return (n, 2) places on a ring of the unit disc."""
    if ring == 0:
        return np.zeros((1, 2))
    angle = 2 * np.pi * (np.arange(8 * ring) + 0.5 * (ring & 1)) / (8 * ring)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1) * ring / GAPS


def _level_of(levels: list[Array], kernel_px: float) -> int:
    gap = max(0.5 * kernel_px / GAPS, 1.0)
    return min(int(np.floor(np.log2(gap) + 0.5)), len(levels) - 1)


def _area_share(radius_px: float, level: int) -> float:
    return 1024 / max(radius_px**2, 2.0 * 2**level)


def _weight(radius_px: float, distance_px: float, level: int) -> float:
    reaches = np.clip((radius_px - distance_px) / 2**level + 0.5, 0, 1)
    return float(reaches) * _area_share(radius_px, level)


def _in_focus(tiles: Array) -> Array:
    return np.abs(tiles).max(axis=-1) < engine_kernels.IN_FOCUS_PX


def halved(image: Array, *, by_radius: bool) -> Array:
    """Return (⌈h/2⌉, ⌈w/2⌉, 4): means of 2 × 2 pixels, and a radius of each."""
    rows, columns = (range(0, size, 2) for size in image.shape[:2])
    return np.array(
        [[_block(image[y : y + 2, x : x + 2], by_radius) for x in columns] for y in rows]
    )


def _block(pixels: Array, by_radius: bool) -> Array:
    found = pixels.reshape(-1, 4)
    weight = 1 / (1 + found[:, :3].max(axis=-1))
    if by_radius and found[:, 3].any():
        weight = weight * np.abs(found[:, 3])
    colour = (weight[:, None] * found[:, :3]).sum(axis=0) / weight.sum()
    least = found[:, 3].min()
    foremost = 0.0 if abs(least) < engine_kernels.IN_FOCUS_PX else least
    return np.append(colour, found[:, 3].mean() if by_radius else foremost)


def _foremost(image: Array) -> Array:
    """Return (⌈h/2⌉, ⌈w/2⌉, 4): mean colours and least radii of 2 × 2 texels."""
    rows, columns = (range(0, size, 2) for size in image.shape[:2])
    blocks = [[image[y : y + 2, x : x + 2].reshape(-1, 4) for x in columns] for y in rows]
    return np.array(
        [[np.append(b[:, :3].mean(axis=0), b[:, 3].min()) for b in row] for row in blocks]
    )


def _gaussian(image: Array, axis: tuple[float, float]) -> Array:
    sigma = 0.5 * np.abs(image[..., 3]) * sum(axis)
    total = _weighted(image)
    pixels = np.ceil(engine_kernels.GAUSSIAN_REACH * sigma)
    for i in range(1, int(pixels.max(initial=0)) + 1, 2):
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = (np.exp(-0.5 * (j / sigma) ** 2) for j in (i, i + 1))
            away = i + np.where(first > 0, second / (first + second), 0)
        weight = np.where(i <= pixels, first + second, 0)[..., None]
        step = away[..., None] * np.sign(axis)
        total += weight * (_weighted(_at(image, step)) + _weighted(_at(image, -step)))
    return np.concatenate([_mean(total, image[..., :3]), image[..., 3:]], axis=-1)


def _tiles(radius_px: Array, dilations: int) -> Array:
    """Return (h, w, 2): least and greatest radius of each texel's tile and of tiles around it."""
    side = engine_kernels.RING_TILE
    rows, columns = (range(0, size, side) for size in radius_px.shape)
    height, width = radius_px.shape
    found = []
    for sign in (-1, 1):
        widest = np.array(
            [[(sign * radius_px[y : y + side, x : x + side]).max() for x in columns] for y in rows]
        )
        for dilation in range(dilations):
            reaching = np.where((widest > 2 * side * dilation) | (dilation == 0), widest, -65504)
            widest = np.maximum(widest, maximum_filter(reaching, 3, mode="nearest"))
        tiles = sign * widest
        found.append(tiles.repeat(side, axis=0).repeat(side, axis=1)[:height, :width])
    return np.stack(found, axis=-1)


def _over(half: Array, image: Array) -> Array:
    """Return (h, w, 3): half an image, colours times opacity and opacity, over the sharp one."""
    soft = pyramid.magnified(half, 1, image.shape[:2])
    colours: Array = soft[..., :3] + (1 - soft[..., 3:]) * image[..., :3]
    return colours


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


def _weighted(pixels: Array) -> Array:
    return np.concatenate([pixels[..., :3], np.ones((*pixels.shape[:2], 1))], axis=-1)


def _mean(total: Array, otherwise: Array) -> Array:
    weight = total[..., 3:]
    return np.where(weight > 0, total[..., :3] / np.where(weight > 0, weight, 1), otherwise)


def _smoothstep(low: float, high: float, value: Array) -> Array:
    part = np.clip((value - low) / (high - low), 0, 1)
    return part * part * (3 - 2 * part)
