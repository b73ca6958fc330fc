"""Land to a 30 km horizon: a terrace to stand on, a lake in its valley, snowy ranges around.

The mesh is polar (its cells grow with distance), and so is the picture of the far land:
u is the azimuth, v the logarithm of the distance. Heights are metres above the terrace.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .contact import refined, triangulated
from .mesh import Array, Mesh, grid, unit
from .noise import cloud, fractal, gradient_noise, ridges
from .texture import Ramp, blurred, ramp_png, slopes_png

CENTER = (8.0, 1.5)
"""x and z of the middle of the terrace, and of the polar grid."""
LAKE_M = -338.0
NEAR_M, FAR_M = 120.0, 32_000.0
"""Where the polar picture begins and where the land ends."""
SNOW_M = 760.0
MARGIN = 0.008
"""Part of the polar picture that repeats its first and last row: mipmaps must not mix them."""

TURF_M = 2.4
"""Width of the turf's picture."""
TERRACE_RINGS = 14
"""How many of its inner rings the near mesh has not: the terrace is there."""

MEADOW, FOREST, ROCK, SNOW, SCREE = range(5)
RAMPS: list[Ramp] = [
    [(64, 72, 36), (100, 106, 56), (142, 136, 82)],
    [(18, 32, 18), (34, 52, 28), (54, 72, 38)],
    [(52, 49, 47), (96, 90, 84), (142, 134, 124)],
    [(190, 202, 222), (228, 234, 242), (250, 251, 252)],
    [(86, 80, 70), (124, 116, 102), (160, 150, 134)],
]


def smoothstep(low: float, high: float, x: Array) -> Array:
    """Return a smooth step from 0 at `low` to 1 at `high`."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return np.asarray(t * t * (3 - 2 * t))


def from_terrace(x: Array, z: Array) -> Array:
    """Return how far places are from the terrace: 1 on its rim."""
    return np.hypot((x - CENTER[0]) / 24.0, (z - CENTER[1]) / 12.5)


def height(x: Array, z: Array) -> Array:
    """Return the land's height above the terrace, before the lake is filled."""
    r = np.hypot(x - CENTER[0], z - CENTER[1])
    north, south = np.maximum(-z - 11, 0), np.maximum(z - 14, 0)
    aside = np.maximum(np.abs(x - CENTER[0]) - 24, 0)
    land = -355 * (1 - np.exp(-north / 640)) + 260 * (1 - np.exp(-south / 1500))
    land = land - 150 * (1 - np.exp(-aside / 900)) * smoothstep(400, -300, z)
    land = land + 75 * smoothstep(150, 1500, r) * fractal(x / 1100, z / 1100, 11, octaves=5)
    land = land + 3.2 * smoothstep(1.05, 4.0, from_terrace(x, z)) * fractal(
        x / 46, z / 46, 23, octaves=4
    )
    azimuth = np.arctan2(x - CENTER[0], -(z - CENTER[1]))
    valley = np.exp(-(((azimuth + 0.10) / 0.30) ** 2)) * smoothstep(17_000, 11_000, r)
    reach = 0.72 * smoothstep(3_000, 9_500, r) + 0.8 * smoothstep(11_000, 23_000, r)
    reach = reach * (1 - 0.9 * valley)
    crest = ridges(x / 6_100 + 3.3, z / 6_100 - 1.7, 41, octaves=8, gain=0.46)
    massif = 0.75 + 0.5 * gradient_noise(x / 11_000, z / 11_000, 77)
    land = land + reach * (2_350 * crest * massif + 130)
    basin = smoothstep(1.25, 0.75, np.hypot((x + 420) / 1_500, (z + 3_900) / 2_500))
    land = land * (1 - basin) + (LAKE_M - 25) * basin
    flat = smoothstep(1.0, 1.5, from_terrace(x, z))
    return np.asarray(land * flat)


def ground_height(x: float, z: float) -> float:
    """Return the height at one place."""
    return float(height(np.array([float(x)]), np.array([float(z)]))[0])


def rings() -> tuple[Array, Array]:
    """Return the radii of the near and of the far part of the mesh; they share one."""
    inner = np.arange(0, 19, 1.9)
    outer = np.geomspace(19, NEAR_M, 24)
    return np.concatenate([inner, outer]), np.geomspace(NEAR_M, FAR_M, 54)


def _places(radius: Array, azimuth: Array) -> tuple[Array, Array]:
    return CENTER[0] + radius * np.sin(azimuth), CENTER[1] - radius * np.cos(azimuth)


def sheet(radius: Array, azimuth: Array) -> Array:
    """Return (rings, azimuths, 3) points of the land; the lake's bed is cut off just below it."""
    x, z = _places(*np.broadcast_arrays(radius[:, None], azimuth[None]))
    return np.stack([x, np.maximum(height(x, z), LAKE_M - 12), z], axis=-1)


def near_tiles(around: Sequence[Array], wedges: int = 12, sectors: int = 72) -> list[Mesh]:
    """Return the land up to NEAR_M in tiles, coloured by its cover for a neutral texture.

    The terrace is finer around the outlines of what stands on it.
    """
    radius, _ = rings()
    points = sheet(radius, np.linspace(0, 2 * np.pi, sectors + 1))
    polar = grid(points, points[..., [0, 2]] / TURF_M)
    row = np.arange(len(polar.positions)).reshape(len(radius), -1)
    beyond = _part(polar, (polar.indices >= row[TERRACE_RINGS, 0]).all(axis=1))
    return [
        replace(tile, colors=cover_color(tile.positions[:, 0], tile.positions[:, 2]))
        for part in (_terrace(polar, row, around), beyond)
        for tile in _wedges(part, wedges)
    ]


def _terrace(polar: Mesh, row: NDArray[np.int64], around: Sequence[Array]) -> Mesh:
    """Return the land within a ring of the polar mesh: its points, but where land is level."""
    rim, within = row[TERRACE_RINGS, :-1], row[:TERRACE_RINGS, :-1].ravel()
    x, _, z = polar.positions[within].T
    kept = np.concatenate([rim, within[from_terrace(x, z) > 0.99]])
    grid_xz = np.stack(np.meshgrid(*(np.arange(-24.0, 24.1, 2.1),) * 2), -1).reshape(-1, 2) + CENTER
    level = grid_xz[from_terrace(*grid_xz.T) < 0.93]
    places = np.concatenate([polar.positions[kept][:, [0, 2]], level])
    places = refined(places, np.arange(len(places)) < len(kept), around)
    positions, normals = (np.zeros((len(places), 3)) for _ in range(2))
    positions[:, [0, 2]], normals[:, 1] = places, 1.0
    positions[: len(kept)], normals[: len(kept)] = polar.positions[kept], polar.normals[kept]
    return Mesh(positions, normals, places / TURF_M, triangulated(places))


def far_tiles(wedges: int = 30, bands: int = 9, sectors: int = 300) -> list[Mesh]:
    """Return the land from NEAR_M to FAR_M in tiles, mapped to the polar picture."""
    _, radius = rings()
    azimuth = np.linspace(0, 2 * np.pi, sectors + 1)
    points = sheet(radius, azimuth)
    points[0] = _on_chords(sectors)
    v = MARGIN + (1 - 2 * MARGIN) * (1 - np.log(radius / NEAR_M) / np.log(FAR_M / NEAR_M))
    uvs = np.stack(np.broadcast_arrays(azimuth[None] / (2 * np.pi), v[:, None]), axis=-1)
    whole = grid(points, uvs)
    edges = np.linspace(0, len(radius) - 1, bands + 1).astype(int)
    return _tiles(whole, sectors, edges, wedges)


def _tiles(mesh: Mesh, sectors: int, edges: NDArray[np.int64], wedges: int) -> list[Mesh]:
    """Cut a polar mesh at some of its rings, and into wedges: small boxes cull well."""
    row = (np.arange(len(mesh.positions)) // (sectors + 1))[mesh.indices]
    tiles = []
    for low, high in itertools.pairwise(edges):
        tiles += _wedges(_part(mesh, ((row >= low) & (row <= high)).all(axis=1)), wedges)
    return tiles


def _on_chords(sectors: int, near_sectors: int = 72) -> Array:
    """Put the far part's first ring on the near part's last edges, so that no gap shows."""
    radius = np.array([NEAR_M])
    coarse = sheet(radius, np.linspace(0, 2 * np.pi, near_sectors + 1))[0]
    at = np.linspace(0, near_sectors, sectors + 1)
    low = np.minimum(at.astype(int), near_sectors - 1)
    t = (at - low)[:, None]
    return np.asarray(coarse[low] * (1 - t) + coarse[low + 1] * t)


def _wedges(mesh: Mesh, count: int) -> list[Mesh]:
    """Cut a mesh into `count` equal sectors around the centre."""
    middle = mesh.positions[mesh.indices].mean(axis=1)
    turn = np.arctan2(middle[:, 0] - CENTER[0], -(middle[:, 2] - CENTER[1])) % (2 * np.pi)
    wedge = np.minimum((turn / (2 * np.pi) * count).astype(int), count - 1)
    return [_part(mesh, wedge == index) for index in range(count)]


def _part(mesh: Mesh, faces: NDArray[np.bool_]) -> Mesh:
    """Return some faces with only the vertices that they use; normals stay."""
    used, indices = np.unique(mesh.indices[faces], return_inverse=True)
    colors = None if mesh.colors is None else mesh.colors[used]
    return Mesh(
        mesh.positions[used], mesh.normals[used], mesh.uvs[used], indices.reshape(-1, 3), colors
    )


def cover(x: Array, z: Array, y: Array, slope: Array) -> tuple[NDArray[np.int64], Array]:
    """Return what grows (or lies) at places, and its tone in [0, 1].

    `slope` is rise over run.
    """
    broad = fractal(x / 700, z / 700, 61, octaves=4)
    fine = fractal(x / 90, z / 90, 67, octaves=3)
    kind = np.full(x.shape, MEADOW)
    wooded = (
        (broad + 0.6 * fine + smoothstep(60, -250, y) * 0.5 > 0.12)
        & (y < 420 + 160 * fine)
        & (slope < 0.75)
    )
    beyond = np.hypot(x - CENTER[0], z - CENTER[1]) > 140
    kind[wooded & beyond & (y > LAKE_M + 8)] = FOREST
    kind[(y > 520 + 160 * broad) | (y < LAKE_M + 5 + 3 * fine)] = SCREE
    kind[slope > 0.80 + 0.22 * fine] = ROCK
    snow_line = SNOW_M + 210 * broad + 130 * fine + 420 * np.maximum(slope - 0.55, 0)
    kind[(y > snow_line) & (slope < 1.25 + 0.3 * fine + (y - snow_line) / 2600)] = SNOW
    tone = 0.5 + 0.35 * fine + 0.2 * broad
    return kind, tone


def cover_color(x: Array, z: Array) -> Array:
    """Return (n, 4) vertex colours that turn a neutral ground texture into the land's cover."""
    step_m = 1.0
    y = height(x, z)
    slope = np.hypot(height(x + step_m, z) - y, height(x, z + step_m) - y) / step_m
    kind, tone = cover(x, z, y, slope * 0.8)
    ramps = np.array(RAMPS, dtype=np.float64)
    place = np.clip(tone, 0, 1)[:, None]
    chosen = ramps[kind]
    srgb = np.where(
        place < 0.5,
        chosen[:, 0] + (chosen[:, 1] - chosen[:, 0]) * 2 * place,
        chosen[:, 1] + (chosen[:, 2] - chosen[:, 1]) * (2 * place - 1),
    )
    linear = (srgb / 255) ** 2.2 / NEUTRAL
    return np.concatenate([np.clip(linear, 0, 1), np.ones((len(x), 1))], axis=1)


NEUTRAL = 0.42
"""Mean linear reflectance of the neutral ground texture."""


def polar_pictures(width: int = 3072, rows: int = 768) -> tuple[bytes, bytes]:
    """Return the albedo and the normal map of the land from NEAR_M to FAR_M.

    The normal map holds what the mesh's own smooth normals leave out.
    """
    azimuth = (np.arange(width) + 0.5) / width * 2 * np.pi
    v = np.clip(((np.arange(rows) + 0.5) / rows - MARGIN) / (1 - 2 * MARGIN), 0, 1)
    radius = NEAR_M * (FAR_M / NEAR_M) ** (1 - v)
    x, z = _places(*np.broadcast_arrays(radius[:, None], azimuth[None]))
    y = height(x, z)
    along_u = (np.roll(y, -1, 1) - np.roll(y, 1, 1)) / (4 * np.pi / width * radius[:, None])
    step_m = 0.004 * radius[:, None]
    beyond = _places(*np.broadcast_arrays(radius[:, None] + step_m, azimuth[None]))
    outward = (height(*beyond) - y) / step_m
    kind, tone = cover(x, z, y, np.hypot(along_u, outward))
    hollow = np.clip((blurred(y, 3) - y) / (0.012 * radius[:, None]), -1, 1)
    speckle = cloud(5, width, exponent=0.5, low=60)[:rows]
    tone = tone - 0.25 * hollow + np.where(kind == FOREST, 0.7, 0.22) * (speckle - 0.5)
    return ramp_png(tone, kind, RAMPS, levels=20), slopes_png(
        *_residual(along_u, outward, azimuth, v)
    )


def _residual(along_u: Array, outward: Array, azimuth: Array, v: Array) -> tuple[Array, Array]:
    """Return the slopes of the fine land over the coarse mesh, to the right and up the picture."""
    fine = unit(np.stack([-along_u, np.ones_like(along_u), -outward], axis=-1))
    _, radius = rings()
    sectors = 300
    points = sheet(radius, np.linspace(0, 2 * np.pi, sectors + 1))
    mesh = grid(points, points[..., :2])
    normals = mesh.normals.reshape(len(radius), sectors + 1, 3)
    ring = (1 - v) * (len(radius) - 1)
    at = azimuth / (2 * np.pi) * sectors
    i, j = np.minimum(ring.astype(int), len(radius) - 2), np.minimum(at.astype(int), sectors - 1)
    s, t = (ring - i)[:, None, None], (at - j)[None, :, None]
    rows_low = normals[i][:, j] * (1 - t) + normals[i][:, j + 1] * t
    rows_high = normals[i + 1][:, j] * (1 - t) + normals[i + 1][:, j + 1] * t
    world = unit(rows_low * (1 - s) + rows_high * s)
    # Into the axes (right, up, outward) of each azimuth.
    east, north = np.sin(azimuth)[None], -np.cos(azimuth)[None]
    right = world[..., 0] * np.cos(azimuth) + world[..., 2] * np.sin(azimuth)
    coarse = np.stack([right, world[..., 1], world[..., 0] * east + world[..., 2] * north], axis=-1)
    tangent = unit(np.array([1.0, 0, 0]) - coarse * coarse[..., :1])
    # (right, up, outward) is left-handed, so the cross product changes sign.
    bitangent = -np.cross(coarse, tangent)
    depth = np.maximum((fine * coarse).sum(-1), 0.2)
    return (fine * tangent).sum(-1) / depth, (fine * bitangent).sum(-1) / depth


def lake() -> Mesh:
    """Return the water: a flat disc; the land around hides its rim."""
    angle = np.linspace(0, 2 * np.pi, 49)
    radius = np.array([0.0, 0.55, 1.0])[:, None]
    x = -420 + radius * 2_300 * np.sin(angle)
    z = -3_900 + radius * 3_500 * np.cos(angle)
    points = np.stack([x, np.full_like(x, LAKE_M), z], axis=-1)[::-1]
    return grid(points, points[..., [0, 2]] / 400)
