"""Carved signs and painted ornament, drawn from a few strokes."""

from __future__ import annotations

import numpy as np

from .noise import Array
from .texture import coordinates


def glyph(rng: np.random.Generator, size: int) -> Array:
    """Return one (size, size) sign, 1 where the chisel went."""
    y, x = np.mgrid[0:size, 0:size] / (size - 1) * 2 - 1
    sign = np.zeros((size, size), bool)
    for _ in range(int(rng.integers(2, 4))):
        sign |= _stroke(rng, x, y)
    if rng.random() < 0.6:
        sign |= _stroke(rng, np.abs(x), y)
    inside = np.maximum(np.abs(x), np.abs(y)) < 0.82
    return (sign & inside).astype(np.float64)


def _stroke(rng: np.random.Generator, x: Array, y: Array) -> Array:
    """Return one stroke: a circle, an arc, a bar, a zigzag or an eye."""
    kind = int(rng.integers(6))
    a, b = rng.uniform(-0.35, 0.35, 2)
    size, width = rng.uniform(0.3, 0.6), 0.10
    radius = np.hypot(x - a, y - b)
    shapes = (
        np.abs(radius - size) < width,
        (np.abs(radius - size) < width) & (y > b),
        (np.abs(y - b) < width) & (np.abs(x) < 0.75),
        (np.abs(x - a) < width) & (np.abs(y) < 0.75),
        (np.abs(y - b - 0.22 * np.abs((x * 3 + 9) % 2 - 1)) < width) & (np.abs(x) < 0.8),
        (np.abs(np.hypot(x, (y - b) * 1.9) - 0.62) < width) | (radius < 0.17),
    )
    return np.asarray(shapes[kind])


def glyph_wall(seed: int, size: int, *, rows: int = 6, columns: int = 8) -> Array:
    """Return a (size, size) repeating wall of signs in ruled rows, 1 where it is carved."""
    rng = np.random.default_rng(seed)
    wall = np.zeros((size, size))
    height = size // rows
    cell = int(height * 0.74)
    for row in range(rows):
        for column in range(columns):
            top = row * height + (height - cell) // 2 + 2
            left = int((column + 0.5) * size / columns - cell / 2) % size
            sign = glyph(rng, cell)
            across = (np.arange(cell) + left) % size
            wall[top : top + cell, across] = np.maximum(wall[top : top + cell, across], sign)
        wall[row * height : row * height + 3] = 1
    return wall


def frieze(size: int) -> Array:
    """Return ingredient numbers of a painted wall band (v: 0 at its upper edge).

    0 plaster, 1 red, 2 blue, 3 ochre, 4 black.
    """
    u, v = coordinates(size)
    kind = np.zeros((size, size), np.int64)
    kind[(v < 0.03) | (v > 0.97)] = 1
    kind[(np.abs(v - 0.05) < 0.008) | (np.abs(v - 0.95) < 0.008)] = 4
    kind[_meander((u * 8) % 1, (v - 0.08) / 0.16) & (v > 0.08) & (v < 0.24)] = 2
    kind[(np.abs(v - 0.27) < 0.012) | (np.abs(v - 0.73) < 0.012)] = 3
    x, y = (u * 4) % 1 - 0.5, (v - 0.5) / 0.42 * 0.5
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    kind[(radius < 0.38) & (radius > 0.34)] = 4
    kind[radius < 0.30 + 0.03 * np.cos(12 * angle)] = 1
    kind[radius < 0.20 * np.abs(np.cos(4 * angle)) ** 0.6] = 3
    kind[radius < 0.05] = 2
    lotus_x, lotus_y = np.abs((u * 8) % 1 - 0.5), (0.93 - v) / 0.17
    petal = (lotus_x < 0.42 * np.sqrt(np.clip(lotus_y, 0, 1)) * (1.1 - lotus_y)) & (lotus_y > 0)
    kind[petal & (lotus_y < 1)] = 2
    kind[petal & (lotus_x < 0.10 * (1.1 - lotus_y)) & (lotus_y < 1)] = 3
    return kind


def _meander(x: Array, y: Array) -> Array:
    """Return the Greek key on a unit cell."""
    column, row = np.floor(x * 7), np.floor(y * 7)
    key = (row == 0) | (row == 6) & (column != 6)
    key |= (column == 0) & (row >= 0)
    key |= (column == 4) & (row >= 2) & (row <= 6) & (column != 6)
    key |= (row == 2) & (column >= 2) & (column <= 4)
    key |= (column == 2) & (row >= 2) & (row <= 4)
    return np.asarray(key)
