"""Stone, tile, wood, leaf and paint: (albedo PNG, normal PNG) of each surface."""

from __future__ import annotations

import numpy as np

from .glyphs import frieze, glyph_wall
from .noise import Array, cloud
from .texture import (
    Ramp, blurred, coordinates, cutout_png, hollow, normal_png, ramp_png, rgb_png, step,
)  # fmt: skip

SAND: Ramp = [(92, 70, 48), (158, 128, 92), (196, 167, 126), (222, 198, 160)]
BASALT: Ramp = [(24, 23, 25), (52, 50, 52), (84, 80, 80), (112, 106, 102)]
GROUT: Ramp = [(60, 52, 44), (120, 106, 90)]


def blocks(
    seed: int, ramp: Ramp, *, rows: int = 4, columns: int = 2, size: int = 512
) -> tuple[bytes, bytes]:
    """Return coursed ashlar: `rows` × `columns` blocks in running bond."""
    u, v = coordinates(size)
    row = np.floor(v * rows)
    shifted = u * columns + 0.5 * (row % 2)
    column = np.floor(shifted) % columns
    along, down = shifted % 1, (v * rows) % 1
    gap = np.minimum(
        np.minimum(along, 1 - along) * rows / columns * 1.0, np.minimum(down, 1 - down)
    )
    grain, wear = cloud(seed, size, exponent=0.9, low=6), cloud(seed + 1, size, exponent=1.8, low=2)
    face = step(0.028 + 0.03 * (wear - 0.5), gap, 0.016)
    rng = np.random.default_rng(seed + 2)
    own = rng.uniform(-0.13, 0.13, (rows, columns))[row.astype(int), column.astype(int)]
    pits = step(0.68, cloud(seed + 3, size, exponent=0.7, low=20), 0.05)
    height = face * 2.2 + 0.5 * grain + 0.7 * wear - 0.5 * pits * face
    tone = 0.55 + own + 0.55 * (grain - 0.5) + 0.5 * (wear - 0.5) - 0.45 * (1 - face) - 0.18 * pits
    half = blurred(height, size / 700)[:: size // 512, :: size // 512]
    return ramp_png(tone, 0, [ramp]), normal_png(half, strength=1.5)


def marble(seed: int, *, size: int = 512) -> bytes:
    """Return polished pale stone with soft veins."""
    warp = cloud(seed, size, exponent=1.9)
    vein = np.abs(cloud(seed + 1, size, exponent=1.7, low=2) + 0.25 * (warp - 0.5) - 0.5)
    veins = np.exp(-vein * 42) * step(0.42, warp, 0.2)
    tone = 0.82 + 0.5 * (cloud(seed + 2, size, exponent=1.5) - 0.5) * 0.5 - 0.42 * veins
    return ramp_png(tone, 0, [[(120, 112, 108), (188, 180, 170), (226, 220, 208), (244, 240, 232)]])


def star_tiles(seed: int, *, size: int = 512) -> tuple[bytes, bytes]:
    """Return a floor of eight-pointed stars and crosses in three stones, 2 × 2 stars."""
    u, v = coordinates(size)
    x, y = (np.abs((c * 2) % 1 - 0.5) for c in (u, v))
    star = np.minimum(np.maximum(x, y) - 0.33, (x + y) - 0.33 * np.sqrt(2))
    heart = np.hypot(x, y) - 0.17
    petals = np.hypot(x, y) - 0.12 - 0.035 * np.cos(8 * np.arctan2(y, x))
    gap = np.minimum.reduce([np.abs(star), np.abs(heart), 0.5 - np.maximum(x, y) + 0 * x])
    stone = np.where(star > 0, 0, np.where(heart > 0, 1, np.where(petals > 0, 2, 0)))
    grain = cloud(seed, size, exponent=0.8, low=8)
    wear = cloud(seed + 1, size, exponent=1.7)
    face = step(0.011, gap, 0.006)
    tone = 0.58 + 0.4 * (grain - 0.5) + 0.55 * (wear - 0.5)
    tone = np.where(face > 0.5, tone, 0.2 + 0.4 * grain)
    ramps: list[Ramp] = [
        [(120, 98, 74), (190, 164, 128), (218, 198, 164)],
        [(40, 62, 74), (66, 98, 112), (104, 138, 146)],
        [(92, 38, 28), (146, 70, 50), (184, 110, 82)],
        GROUT,
    ]  # fmt: skip
    kind = np.where(face > 0.5, stone, 3)
    return ramp_png(tone, kind, ramps, levels=24), normal_png(face * 1.6 + 0.35 * wear, strength=1.1)


def mosaic(seed: int, *, size: int = 512, cells: int = 48) -> tuple[bytes, bytes]:
    """Return small tesserae that draw interlaced circles."""
    u, v = coordinates(size)
    a, b = np.floor(u * cells), np.floor(v * cells)
    cu, cv = (a + 0.5) / cells, (b + 0.5) / cells
    fu, fv = u * cells - a - 0.5, v * cells - b - 0.5
    rng = np.random.default_rng(seed)
    own = rng.uniform(-0.28, 0.28, (cells, cells))[b.astype(int), a.astype(int)]
    face = step(0.05, 0.46 - np.maximum(np.abs(fu), np.abs(fv)), 0.05)
    ring = np.zeros_like(u)
    for ox, oy in ((0, 0), (0.5, 0.5)):
        r = np.hypot((cu - ox + 0.5) % 1 - 0.5, (cv - oy + 0.5) % 1 - 0.5)
        ring = np.where(
            np.abs(r - 0.33) < 0.032,
            1,
            np.where(r < 0.09, 2, np.where(np.abs(r - 0.2) < 0.014, 3, ring)),
        )
    ramps: list[Ramp] = [
        [(150, 134, 108), (204, 190, 160), (228, 218, 194)],
        [(22, 40, 66), (44, 74, 106), (86, 120, 146)],
        [(120, 60, 30), (178, 104, 52), (206, 146, 84)],
        [(90, 30, 26), (138, 54, 44), (164, 88, 72)],
        GROUT,
    ]  # fmt: skip
    kind = np.where(face > 0.4, ring, 4).astype(np.int64)
    tone = 0.55 + own + 0.3 * (cloud(seed, size, exponent=1.2) - 0.5)
    return ramp_png(tone, kind, ramps), normal_png(face, strength=0.8)


def wood(
    seed: int, *, size: int = 512, planks: int = 4, ramp: Ramp | None = None
) -> tuple[bytes, bytes]:
    """Return planks that run along v."""
    u, _ = coordinates(size)
    plank = np.floor(u * planks).astype(int)
    rng = np.random.default_rng(seed)
    grain = cloud(seed, size, exponent=1.1, low=3, stretch=(14, 1))
    for index in range(planks):
        grain = np.where(plank == index, np.roll(grain, int(rng.integers(size)), axis=0), grain)
    edge = np.minimum((u * planks) % 1, 1 - (u * planks) % 1)
    face = step(0.03, edge, 0.02)
    rings = 0.5 + 0.5 * np.sin(34 * grain + 5 * cloud(seed + 1, size, exponent=1.8, stretch=(5, 1)))
    tone = (
        0.5
        + rng.uniform(-0.14, 0.14, planks)[plank]
        + 0.4 * (grain - 0.5) * 2
        + 0.16 * (rings - 0.5)
        - 0.5 * (1 - face)
    )
    brown: Ramp = [(38, 24, 14), (86, 56, 34), (126, 88, 56), (160, 120, 82)]
    return ramp_png(tone, 0, [ramp or brown]), normal_png(
        face * 2 + 1.2 * grain + 0.3 * rings, strength=0.8
    )


def inscription(seed: int, ramp: Ramp, *, size: int = 512) -> tuple[bytes, bytes]:
    """Return stone with rows of carved signs between ruled lines."""
    carved = blurred(glyph_wall(seed, size), 0.9)
    grain, wear = cloud(seed, size, exponent=1.0, low=4), cloud(seed + 1, size, exponent=1.7)
    height = -3.4 * carved + 0.5 * grain + 0.6 * wear
    tone = 0.62 + 0.5 * (grain - 0.5) + 0.5 * (wear - 0.5) - 0.42 * carved
    return ramp_png(tone, 0, [ramp]), normal_png(height, strength=1.0)


def painted_frieze(seed: int, *, size: int = 512) -> bytes:
    """Return worn paint on plaster: meander, lotus and rosette bands."""
    kind = frieze(size)
    wear = cloud(seed, size, exponent=1.3, low=2)
    grain = cloud(seed + 1, size, exponent=0.8, low=10)
    bare = wear + 0.25 * (grain - 0.5) > 0.72
    ramps: list[Ramp] = [
        [(168, 146, 112), (214, 196, 160), (234, 220, 190)],
        [(98, 32, 22), (152, 58, 40), (178, 92, 68)],
        [(20, 62, 78), (42, 98, 112), (92, 140, 146)],
        [(150, 104, 34), (200, 150, 62), (222, 184, 106)],
        [(28, 22, 20), (52, 44, 38)],
    ]  # fmt: skip
    tone = 0.55 + 0.5 * (wear - 0.5) + 0.4 * (grain - 0.5)
    return ramp_png(tone, np.where(bare, 0, kind), ramps, levels=20)


def vase_paint(seed: int, *, size: int = 512) -> bytes:
    """Return a black and red glaze for one turn of a vase (u around, v down)."""
    u, v = coordinates(size)
    clay, black = 0, 1
    kind = np.full(u.shape, black)
    band = (v > 0.30) & (v < 0.62)
    wave = np.abs(np.sin(np.pi * 6 * u)) ** 0.7
    kind = np.where(band, clay, kind)
    spiral = np.sin(
        2
        * np.pi
        * (
            12 * np.hypot((u * 6) % 1 - 0.5, (v - 0.46) * 5)
            - np.arctan2((v - 0.46) * 5, (u * 6) % 1 - 0.5) / (2 * np.pi)
        )
    )
    kind = np.where(
        band & (np.hypot((u * 6) % 1 - 0.5, (v - 0.46) * 5) < 0.46) & (spiral > 0.1), black, kind
    )
    kind = np.where(
        (np.abs(v - 0.305) < 0.007) | (np.abs(v - 0.615) < 0.007) | (np.abs(v - 0.64) < 0.004),
        2,
        kind,
    )
    kind = np.where((v > 0.70) & (v < 0.80) & ((v - 0.70) * 10 < wave), clay, kind)
    meander = (np.floor(u * 48) % 4 != 0) ^ (np.floor(v * 60) % 3 == 1)
    kind = np.where((v > 0.16) & (v < 0.21) & meander, clay, kind)
    kind = np.where((v > 0.88) & (v < 0.9), clay, kind)
    tone = (
        0.5
        + 0.6 * (cloud(seed, size, exponent=1.3) - 0.5)
        + 0.2 * (cloud(seed + 1, size, exponent=0.5, low=12) - 0.5)
    )
    ramps: list[Ramp] = [
        [(132, 62, 30), (186, 98, 52), (210, 130, 78)],
        [(14, 12, 12), (44, 34, 30)],
        [(190, 170, 130), (226, 210, 176)],
    ]
    return ramp_png(tone, kind, ramps)


def plaster(seed: int, *, size: int = 256) -> bytes:
    """Return neutral worn plaster: multiplied by a colour it is cloth, clay or metal too."""
    tone = (
        0.7
        + 0.6 * (cloud(seed, size, exponent=1.4) - 0.5)
        + 0.3 * (cloud(seed + 1, size, exponent=0.6, low=10) - 0.5)
    )
    return ramp_png(tone, 0, [[(120, 118, 114), (205, 202, 196), (248, 246, 240)]])


def cloth(seed: int, *, size: int = 512) -> tuple[bytes, bytes]:
    """Return a woven hanging: red field, gold border of diamonds (u across, v down, once)."""
    u, v = coordinates(size)
    weave = 0.5 + 0.25 * np.sin(2 * np.pi * 128 * u) + 0.25 * np.sin(2 * np.pi * 128 * v)
    diamond = (np.abs((u * 6) % 1 - 0.5) + np.abs((v * 9) % 1 - 0.5)) < 0.32
    small = (np.abs((u * 6) % 1 - 0.5) + np.abs((v * 9) % 1 - 0.5)) < 0.15
    border = np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v) * 1.5)
    kind = np.where(diamond, 1, 0)
    kind = np.where(small, 2, kind)
    kind = np.where(border < 0.11, 2, kind)
    kind = np.where((border < 0.09) & (np.floor(u * 24) % 2 == np.floor(v * 36) % 2), 1, kind)
    kind = np.where(border < 0.025, 0, kind)
    tone = 0.35 + 0.4 * weave + 0.4 * (cloud(seed, size, exponent=1.4) - 0.5)
    ramps: list[Ramp] = [
        [(72, 8, 12), (142, 24, 26), (170, 50, 42)],
        [(120, 78, 20), (196, 146, 58), (224, 186, 104)],
        [(18, 28, 58), (38, 56, 98), (70, 90, 130)],
    ]
    return ramp_png(tone, kind, ramps), normal_png(weave, strength=0.5)


def fronds(seed: int, *, size: int = 256) -> bytes:
    """Return a pinnate leaf on a transparent ground (stem along v, tip at v = 0)."""
    u, v = coordinates(size)
    x, along = np.abs(u - 0.5) * 2, 1 - v
    reach = 0.92 * np.sin(np.pi * np.clip(along, 0, 1) ** 0.75) ** 0.7
    blade = (along + 0.42 * x) * 15
    leaf = (x < reach) & (np.abs(blade % 1 - 0.5) < 0.40 * (1 - (x / np.maximum(reach, 0.01)) ** 3))
    alpha = np.where(leaf | (x < 0.035), 1.0, 0.0)
    tone = (
        0.5
        + 0.5 * (cloud(seed, size, exponent=1.2) - 0.5)
        + 0.25 * np.cos(2 * np.pi * blade)
        - 0.1 * x
    )
    green = np.stack([40 + 70 * tone, 74 + 78 * tone, 22 + 34 * tone], axis=-1)
    return cutout_png(green, blurred(alpha, 0.8))


__all__ = [
    "BASALT", "GROUT", "SAND", "blocks", "cloth", "fronds", "hollow", "inscription", "marble",
    "mosaic", "painted_frieze", "plaster", "rgb_png", "star_tiles", "vase_paint", "wood", "Array",
]  # fmt: skip
