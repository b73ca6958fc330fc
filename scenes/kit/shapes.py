"""Shapes that the scenes are made of. Metres, +Y up; front faces counter-clockwise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .mesh import Array, Mesh, grid, join, smooth, unit


def plane(
    origin: ArrayLike,
    along_u: ArrayLike,
    along_v: ArrayLike,
    *,
    step_m: float = 1.0,
    uv_m: float = 1.0,
) -> Mesh:
    """Return a rectangle cut into cells of about `step_m`, facing along_u × along_v.

    Texture coordinates count `uv_m` metres; v runs against `along_v` (images hang upright).
    """
    o, u, v = (np.asarray(x, dtype=np.float64) for x in (origin, along_u, along_v))
    width, height = np.linalg.norm(u), np.linalg.norm(v)
    s = np.linspace(0, 1, max(2, round(width / step_m) + 1))
    t = np.linspace(0, 1, max(2, round(height / step_m) + 1))
    points = o + t[:, None, None] * v + s[None, :, None] * u
    uvs = np.stack(np.broadcast_arrays(s[None] * width / uv_m, -t[:, None] * height / uv_m), -1)
    return grid(points, uvs)


def box(size: ArrayLike, *, bevel_m: float = 0.0, uv_m: float = 1.0, bottom: bool = True) -> Mesh:
    """Return a box that stands on the origin (y from 0), with bevelled edges if asked."""
    x, y, z = np.asarray(size, dtype=np.float64)
    if bevel_m > 0:
        return _bevelled_box(x, y, z, bevel_m, uv_m)
    h, k = x / 2, z / 2
    sides = [
        plane([-h, 0, k], [x, 0, 0], [0, y, 0], step_m=9e9, uv_m=uv_m),
        plane([h, 0, -k], [-x, 0, 0], [0, y, 0], step_m=9e9, uv_m=uv_m),
        plane([h, 0, k], [0, 0, -z], [0, y, 0], step_m=9e9, uv_m=uv_m),
        plane([-h, 0, -k], [0, 0, z], [0, y, 0], step_m=9e9, uv_m=uv_m),
        plane([-h, y, k], [x, 0, 0], [0, 0, -z], step_m=9e9, uv_m=uv_m),
    ]
    if bottom:
        sides.append(plane([-h, 0, -k], [x, 0, 0], [0, 0, z], step_m=9e9, uv_m=uv_m))
    return join(sides)


def _bevelled_box(x: float, y: float, z: float, bevel: float, uv_m: float) -> Mesh:
    """Stack rounded rectangles: wall, inset top, lid. The foot has no bevel: it meets the floor."""
    b = bevel
    rings = [(0, 0), (y - b, 0), (y, b)]
    outline = [rounded_rectangle(x - 2 * inset, z - 2 * inset, b) for _, inset in rings]
    points = np.stack(
        [
            np.column_stack([o[:, 0], np.full(len(o), h), o[:, 1]])
            for (h, _), o in zip(rings, outline, strict=True)
        ]
    )
    lid = np.concatenate([points[-1:], np.broadcast_to([0, y, 0], points[-1:].shape)])
    wall = grid(points, points[..., :2] * 0, flip=False)
    top = grid(lid, lid[..., :2] * 0, flip=False)
    return cube_mapped(smooth(join([wall, top]), 35.0), uv_m)


def rounded_rectangle(x: float, z: float, bevel: float) -> Array:
    """Return the closed outline (k, 2) of a rectangle with cut corners, seen from +Y."""
    h, k, b = x / 2, z / 2, bevel
    corners = [
        (h - b, k),
        (h, k - b),
        (h, -k + b),
        (h - b, -k),
        (-h + b, -k),
        (-h, -k + b),
        (-h, k - b),
        (-h + b, k),
        (h - b, k),
    ]
    return np.array(corners)[::1]


def cube_mapped(mesh: Mesh, uv_m: float = 1.0) -> Mesh:
    """Return the mesh with texture coordinates projected along each vertex's main axis."""
    p, main = mesh.positions / uv_m, np.argmax(np.abs(mesh.normals), axis=1)
    u = np.where(main == 0, -p[:, 2] * np.sign(mesh.normals[:, 0]), p[:, 0])
    v = np.where(main == 1, p[:, 2], -p[:, 1])
    return replace(mesh, uvs=np.stack([u, v], axis=1))


def lathe(
    profile: ArrayLike,
    *,
    segments: int = 32,
    radius: Callable[[Array, Array], Array] | None = None,
    uv: tuple[float, float] = (1.0, 1.0),
    crease_deg: float = 180.0,
) -> Mesh:
    """Return a surface of revolution about +Y.

    Parameters
    ----------
    profile
        (k, 2) radius and height, from the lower end to the upper end of the outside.
    radius
        Factor on the radius as a function of angle (radians) and height, e.g. for flutes.
    uv
        Repeats around and along.
    """
    p = np.asarray(profile, dtype=np.float64)
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    factor = np.ones((len(p), segments + 1))
    if radius is not None:
        factor = np.broadcast_to(radius(angle[None, :], p[:, 1:2]), factor.shape)
    r = p[:, :1] * factor
    points = np.stack(
        [r * np.sin(angle), np.broadcast_to(p[:, 1:2], r.shape), r * np.cos(angle)], -1
    )
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    v = 1 - length / length[-1]
    uvs = np.stack(np.broadcast_arrays(angle[None] / (2 * np.pi) * uv[0], v[:, None] * uv[1]), -1)
    mesh = grid(points, uvs)
    return mesh if crease_deg >= 180.0 else smooth(mesh, crease_deg)


def loft(rings: Array, *, uv: tuple[float, float] = (1.0, 1.0)) -> Mesh:
    """Return a skin over (k, n, 3) closed rings, from below, counter-clockwise from above."""
    closed = np.concatenate([rings, rings[:, :1]], axis=1)
    u = np.linspace(0, uv[0], closed.shape[1])
    v = np.linspace(uv[1], 0, closed.shape[0])
    return grid(closed, np.stack(np.broadcast_arrays(u[None], v[:, None]), -1))


def tube(
    path: ArrayLike, radius: ArrayLike, *, segments: int = 8, uv: tuple[float, float] = (1, 1)
) -> Mesh:
    """Return a tube along (k, 3) points, with a radius for each point."""
    p = np.asarray(path, dtype=np.float64)
    r = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(p),))
    tangent = unit(np.gradient(p, axis=0))
    side = np.array([1.0, 0, 0]) if abs(tangent[0, 0]) < 0.9 else np.array([0, 0, 1.0])
    rings = []
    for place, direction, reach in zip(p, tangent, r, strict=True):
        side = unit(side - direction * (side @ direction))
        other = np.cross(direction, side)
        angle = np.linspace(0, 2 * np.pi, segments, endpoint=False)[:, None]
        rings.append(place + reach * (np.cos(angle) * side + np.sin(angle) * other))
    return loft(np.array(rings), uv=uv)


def ring(radius: float, thickness: float, *, segments: int = 48, sides: int = 8) -> Mesh:
    """Return a torus about +Y."""
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    turn = np.linspace(0, 2 * np.pi, sides + 1)
    r = radius + thickness * np.cos(turn)[:, None]
    y = np.broadcast_to(thickness * np.sin(turn)[:, None], (sides + 1, segments + 1))
    points = np.stack([r * np.sin(angle), y, r * np.cos(angle)], -1)
    uvs = np.stack(np.broadcast_arrays(angle[None] / 0.6, turn[:, None] / 6), -1)
    return grid(points, uvs)


def ball(radius: float = 1.0, *, segments: int = 24, rings: int = 12) -> Mesh:
    """Return a sphere about the origin."""
    latitude = np.linspace(-np.pi / 2, np.pi / 2, rings + 1)
    return lathe(radius * np.stack([np.cos(latitude), np.sin(latitude)], 1), segments=segments)


def arch_wall(
    width: float,
    height: float,
    thickness: float,
    openings: Sequence[tuple[float, float, float]],
    *,
    uv_m: float = 1.0,
    segments: int = 12,
) -> Mesh:
    """Return a wall in the plane z = 0 (x from 0 to width) with round-arched openings.

    Parameters
    ----------
    openings
        (centre x, width, springing height): the arch is a half circle above the springing.
    """
    parts = []
    for side in (1, -1):
        parts += [_wall_face(width, height, thickness, openings, segments, uv_m, side)]
    for centre, gap, spring in openings:
        outline = arch_outline(centre, gap, spring, segments)
        depth = np.array([-thickness / 2, thickness / 2])
        points = np.stack(
            [np.column_stack([outline, np.full(len(outline), d)]) for d in depth], axis=0
        )
        length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(outline, axis=0), axis=1))])
        uvs = np.stack(np.broadcast_arrays(length[None] / uv_m, depth[:, None] / uv_m), -1)
        parts.append(smooth(grid(points, uvs, flip=False), 40.0))
    return join(parts)


def arch_outline(centre: float, gap: float, spring: float, segments: int) -> Array:
    """Return the (k, 2) outline of an arched opening from its left foot to its right foot."""
    angle = np.linspace(np.pi, 0, segments + 1)
    arc = np.stack([centre + gap / 2 * np.cos(angle), spring + gap / 2 * np.sin(angle)], 1)
    return np.concatenate([[[centre - gap / 2, 0]], arc, [[centre + gap / 2, 0]]])


def _wall_face(
    width: float,
    height: float,
    thickness: float,
    openings: Sequence[tuple[float, float, float]],
    segments: int,
    uv_m: float,
    side: int,
) -> Mesh:
    """One face of the wall: column strips from the opening's outline up to the top."""
    edge = 0.0
    strips: list[tuple[Array, Array]] = []
    for centre, gap, spring in sorted(openings):
        solid = np.linspace(
            edge, centre - gap / 2, max(2, round((centre - gap / 2 - edge) / 1.2) + 1)
        )
        strips.append((solid, np.zeros_like(solid)))
        arc = arch_outline(centre, gap, spring, segments)[1:-1]
        strips.append((arc[:, 0], arc[:, 1]))
        edge = centre + gap / 2
    solid = np.linspace(edge, width, max(2, round((width - edge) / 1.2) + 1))
    strips.append((solid, np.zeros_like(solid)))
    parts = [_strip(x, y, height, side * thickness / 2, uv_m, side) for x, y in strips]
    return join(parts)


def _strip(x: Array, low: Array, height: float, z: float, uv_m: float, side: int) -> Mesh:
    t = np.linspace(0, 1, max(2, round(height / 1.2) + 1))[:, None]
    y = low[None] * (1 - t) + height * t
    points = np.stack(np.broadcast_arrays(x[None] + 0 * y, y, np.full_like(y, z)), -1)
    uvs = np.stack([points[..., 0] * side / uv_m, -points[..., 1] / uv_m], -1)
    return grid(points, uvs, flip=side < 0)
