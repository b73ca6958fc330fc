"""Things of the mountain terrace: stones, wood, trees, a hut, a wind wheel, a bird."""

from __future__ import annotations

import numpy as np

from .mesh import Array, Mesh, ball, box, cube_mapped, grid, join, lathe, plane, smooth, tube, unit
from .noise import gradient_noise
from .ornaments import Parts, placed
from .stone import Ramp
from .texture import blurred, coordinates, cutout_png, normal_png, ramp_png
from .noise import cloud

WOOD: Ramp = [(48, 40, 34), (98, 86, 74), (140, 128, 112), (170, 158, 142)]


def stone_block(seed: int, size: tuple[float, float, float], *, detail: int = 12) -> Mesh:
    """Return a weathered boulder on the origin, about `size` wide, high and deep."""
    raw = ball(1.0, segments=detail + 4, rings=max(4, detail // 2 + 1))
    p = raw.positions
    shape = np.zeros(len(p))
    for axis, other in ((0, 1), (1, 2), (2, 0)):
        shape += gradient_noise(p[:, axis] * 1.3 + seed * 7.1, p[:, other] * 1.3 - seed * 3.7, seed)
    # Flattened sides: a stone has broken faces, not a skin.
    rng = np.random.default_rng(seed)
    q = p * (1 + 0.28 * shape[:, None])
    for normal in unit(rng.standard_normal((7, 3))):
        over = np.maximum(q @ normal - 0.72, 0)
        q = q - over[:, None] * normal * 0.85
    q = q * np.array(size) / 2
    q[:, 1] -= q[:, 1].min() + 0.06 * size[1]
    mesh = smooth(Mesh(q, raw.normals, raw.uvs, raw.indices), 38)
    return cube_mapped(mesh, 1.1)


def cairn(detail: float = 1.0) -> Parts:
    """Return a waymark of stacked stones, 1.35 m high."""
    rng = np.random.default_rng(3)
    stones, y, layer = [], 0.0, 0
    facets = 8 if detail > 0.5 else 4
    while y < 1.2:
        radius = 0.46 * (1 - y / 1.45)
        count = max(1, round(2 * np.pi * radius / 0.4))
        thick = rng.uniform(0.13, 0.19)
        for index in range(count):
            angle = 2 * np.pi * (index + 0.5 * (layer % 2)) / count + rng.uniform(-0.15, 0.15)
            r = radius * 0.72 if count > 1 else 0.0
            size = (rng.uniform(0.34, 0.46), thick * 1.35, rng.uniform(0.26, 0.34))
            stone = stone_block(100 + 10 * layer + index, size, detail=facets)
            stones.append(stone.turned("y", np.degrees(angle) + rng.uniform(-20, 20)).at(r * np.sin(angle), y, r * np.cos(angle)))
        y += thick
        layer += 1
    return [(join(stones), "granite")]


def signpost(detail: float = 1.0) -> Parts:
    """Return a post with three carved boards, 2.3 m high."""
    n = 12 if detail > 0.5 else 6
    post = lathe([(0.075, 0), (0.065, 1.2), (0.06, 2.25), (0.0, 2.32)], segments=n, crease_deg=60, uv=(0.5, 2.3))
    boards = []
    for y, turn, length in ((1.98, 10, 0.95), (1.74, 160, 0.8), (1.5, -55, 0.9)):
        outline = np.array([(-0.12, 0), (length - 0.12, 0), (length, 0.095), (length - 0.12, 0.19), (-0.12, 0.19)])
        boards.append(_board(outline, 0.035).at(0, y, 0.085).turned("y", turn))
    foot = [stone_block(60 + i, (0.26, 0.2, 0.22), detail=8).at(0.16 * np.cos(1.6 * i), 0, 0.16 * np.sin(1.6 * i)) for i in range(4)]
    return [(post, "timber"), (join(boards), "carved_wood"), (join(foot), "granite")]


def _board(outline: Array, thickness: float) -> Mesh:
    """Return an extruded convex outline (counter-clockwise in x, y), carved side at +Z."""
    closed = np.concatenate([outline, outline[:1]])
    k = np.zeros((len(closed), 1))
    rim = grid(np.stack([np.hstack([closed, k]), np.hstack([closed, k + thickness])]), np.zeros((2, len(closed), 2)))
    middle = np.broadcast_to(outline.mean(axis=0), closed.shape)
    face = np.stack([np.hstack([closed, k + thickness]), np.hstack([middle, k + thickness])])
    front = grid(face, np.stack([closed, middle]) * [1.15, -1.15])
    back = front.turned("y", 180).at(2 * 0, 0, thickness)
    return join([smooth(rim, 20), front, back])


def hut(detail: float = 1.0) -> Parts:
    """Return a log hut, 4.4 × 3.4 m, on a stone base; its door faces +Z."""
    w, d, wall = 4.4, 3.4, 2.2
    n = 8 if detail > 0.5 else 4
    base = [stone_block(200 + i, (0.62, 0.42, 0.4), detail=6 if detail > 0.5 else 3).at(x, -0.05, z) for i, (x, z) in enumerate(_around(w, d, 0.56))]
    logs = []
    for row in range(11):
        y = 0.36 + row * 0.2
        for z in (d / 2, -d / 2):
            logs += [_log(w + 0.5, n).at(0, y, z)] if z < 0 or row > 8 else [_log(1.55, n).at(-1.65 + 0.03, y, z), _log(1.55, n).at(1.65 - 0.03, y, z)]
        logs += [_log(d + 0.5, n).turned("y", 90).at(x, y + 0.1, 0) for x in (w / 2, -w / 2)]
    gables = [_gable(d, 1.1).at(s * (w / 2 - 0.02), wall + 0.28, 0) for s in (1, -1)]
    inner = box([w - 0.1, wall + 0.2, d - 0.1], uv_m=1.0).at(0, 0.2)
    roof_parts = _roof(w + 1.1, d + 0.9, wall + 0.25, 1.45)
    door = [box([1.15, 1.95, 0.06], uv_m=1.2).at(0, 0.3, d / 2 + 0.02), box([1.4, 0.1, 0.16]).at(0, 2.25, d / 2 + 0.03),
            *(box([0.12, 2.0, 0.16]).at(s * 0.65, 0.28, d / 2 + 0.03) for s in (1, -1)), box([0.04, 0.16, 0.05]).at(0.42, 1.15, d / 2 + 0.07)]  # fmt: skip
    step = box([1.5, 0.18, 0.7], bevel_m=0.03).at(0, 0, d / 2 + 0.5)
    chimney = box([0.55, 1.6, 0.55], bevel_m=0.03, uv_m=1.0).at(-1.2, wall + 0.9, -0.5)
    return [(join([*base, step, chimney]), "granite"), (join([*logs, *gables]), "timber"), (join([inner, *door]), "planks"), (roof_parts, "shingles")]


def _around(w: float, d: float, step: float) -> list[tuple[float, float]]:
    across, along = np.arange(-w / 2, w / 2 + 0.01, step), np.arange(-d / 2, d / 2 + 0.01, step)
    return [(x, s * d / 2) for x in across for s in (1, -1)] + [(s * w / 2, z) for z in along for s in (1, -1)]


def _log(length: float, segments: int) -> Mesh:
    """Return a log along X."""
    section = [(0.0, -length / 2), (0.098, -length / 2), (0.1, 0), (0.098, length / 2), (0.0, length / 2)]
    return lathe(section, segments=segments, crease_deg=50, uv=(0.6, length)).turned("z", 90)


def _gable(width: float, rise: float) -> Mesh:
    """Return both sides of a triangle in the plane x = 0."""
    corners = np.array([[[0, 0, width / 2], [0, 0, -width / 2]], [[0, rise, 0.001], [0, rise, -0.001]]])
    sheet = grid(corners, corners[..., [2, 1]])
    return join([sheet, sheet.turned("y", 180)])


def _roof(width: float, depth: float, y: float, rise: float) -> Mesh:
    """Return two shingled slopes with a thickness of 12 cm (ridge along X)."""
    half = depth / 2
    length = float(np.hypot(half, rise))
    slopes = []
    for turn in (0, 180):
        top = plane([-width / 2, 0, half], [width, 0, 0], [0, rise, -half], step_m=9, uv_m=1.6)
        under = plane([-width / 2, -0.12, half], [0, rise, -half], [width, 0, 0], step_m=9, uv_m=1.6)
        eave = plane([-width / 2, -0.12, half], [width, 0, 0], [0, 0.12, 0], step_m=9, uv_m=1.6)
        verge = [plane([s * width / 2, -0.12, half if s > 0 else 0], [0, rise * (1 if s > 0 else -1) * 0, 0], [0, 0.12, 0], step_m=9) for s in ()]
        slopes.append(join([top, under, eave, *verge]).turned("y", turn))
        for s in (1, -1):
            edge = np.array([[[s * width / 2, -0.12, half], [s * width / 2, rise - 0.12, 0]], [[s * width / 2, 0, half], [s * width / 2, rise, 0]]])
            slopes.append(grid(edge, edge[..., [2, 1]], flip=s < 0).turned("y", turn if True else 0))
    del length
    return join(slopes).at(0, y)


def wind_wheel_tower(detail: float = 1.0) -> Parts:
    """Return the lattice tower of a wind pump, 6 m, without its wheel."""
    n = 6 if detail > 0.5 else 4
    legs, braces = [], []
    levels = [(0.0, 0.85), (1.7, 0.66), (3.3, 0.48), (4.8, 0.31), (6.0, 0.18)]
    for turn in range(4):
        path = [(h, y, h) for y, h in levels]
        legs.append(tube(path, 0.045, segments=n).turned("y", 90 * turn))
        for (y0, h0), (y1, h1) in zip(levels[:-1], levels[1:], strict=True):
            braces.append(tube([(-h0, y0, h0), (h1, y1, h1)], 0.02, segments=4).turned("y", 90 * turn))
            braces.append(tube([(-h1, y1, h1), (h1, y1, h1)], 0.022, segments=4).turned("y", 90 * turn))
    head = box([0.3, 0.3, 0.55], bevel_m=0.03).at(0, 6.0, 0.05)
    vane = box([0.03, 0.6, 0.9]).at(0, 5.95, -1.45)
    boom = tube([(0, 6.15, -0.2), (0, 6.22, -1.5)], 0.03, segments=6)
    return [(join([*legs, *braces, head]), "timber"), (join([vane, boom]), "red_paint")]


def wind_wheel() -> Parts:
    """Return the wheel about its hub, facing +Z, 2.6 m wide."""
    blades = []
    for index in range(14):
        turn = 360 / 14 * index
        points = np.array([[(x, r, 0.16 * x / 0.2 * (1.1 - 0.4 * r)) for x in (-w / 2, 0, w / 2)] for r, w in ((0.38, 0.1), (0.85, 0.2), (1.28, 0.29))])
        uvs = points[..., :2]
        blade = grid(points, uvs)
        blades.append(blade.turned("z", turn))
    rods = [tube([(0, 0, 0), (0, 1.15, 0)], 0.012, segments=4).turned("z", 360 / 7 * i) for i in range(7)]
    from .mesh import ring  # noqa: PLC0415

    rims = [ring(r, 0.014, segments=40, sides=4).turned("x", 90) for r in (0.6, 1.08)]
    hub = lathe([(0, -0.1), (0.1, -0.1), (0.1, 0.1), (0.0, 0.18)], segments=12, crease_deg=40).turned("x", 90)
    return [(join(blades), "blades"), (join([*rods, *rims, hub]), "iron")]


def pine(seed: int, *, height: float = 7.0, far: bool = False) -> Parts:
    """Return a conifer of masked branches around a trunk; `far` has a third of the triangles."""
    rng = np.random.default_rng(seed)
    tiers, cards = (10, 5) if far else (14, 6)
    trunk = lathe([(0.17, -0.5), (0.14, 0.5), (0.09, height * 0.55), (0.015, height * 0.99)], segments=5 if far else 7, uv=(1, 5))
    branches = []
    for tier in range(tiers):
        t = tier / (tiers - 1)
        reach = (1.75 * (1 - t) ** 0.8 + 0.2) * height / 7
        for index in range(cards if t < 0.8 else cards - 2):
            turn = 360 / cards * index + 43 * tier + rng.uniform(-16, 16)
            droop = rng.uniform(0.35, 0.6) * (1 - 1.5 * t) - 0.15 * t
            card = _branch(reach * rng.uniform(0.8, 1.12), droop, 0.5 * reach + 0.18, bends=1 if far else 2)
            branches.append(card.turned("y", turn).at(0, height * (0.14 + 0.8 * t) + rng.uniform(-0.1, 0.1)))
    tip = [_branch(0.6, -3.0, 0.10, bends=1).scaled(0.35, 0.6, 1).turned("y", 120 * k).at(0, height * 0.9) for k in range(3)]
    return [(trunk, "bark"), (join([*branches, *tip]), "needles")]


def _branch(length: float, droop: float, width: float, *, bends: int) -> Mesh:
    """Return one folded card along +X; its normals lean up and out, as a crown's do."""
    s = np.linspace(0, 1, bends + 1)
    path = np.stack([s * length, -droop * length * s**1.4], axis=1)
    across = [np.stack([path[:, 0], path[:, 1] - 0.3 * width * abs(k), k * width + 0 * s], axis=1) for k in (1, 0, -1)]
    points = np.stack(across, axis=1)
    uvs = np.stack(np.broadcast_arrays(np.array([1, 0.5, 0])[None], 1 - s[:, None]), axis=-1)
    sheet = grid(points, uvs)
    normals = unit(sheet.normals * 0.5 + np.array([0.55, 0.75, 0]))
    shade = np.clip(0.5 + 0.5 * sheet.positions[:, :1] / length, 0, 1)
    colors = np.concatenate([np.repeat(shade, 3, axis=1), np.ones((len(shade), 1))], axis=1)
    return Mesh(sheet.positions, normals, sheet.uvs, sheet.indices, colors)


def tufts(places: Array, seed: int) -> Mesh:
    """Return grass at (n, 3) places: three crossed cards each, both sides lit from above."""
    rng = np.random.default_rng(seed)
    blades = []
    for place in places:
        size, turn = rng.uniform(0.22, 0.42), rng.uniform(0, 180)
        for index in range(3):
            w = size * 0.75
            card = plane([-w, -0.02, 0], [2 * w, 0, 0], [0, size, 0.2 * size], step_m=9, uv_m=1.0)
            uvs = np.array([[0, 1], [1, 1], [0, 0], [1, 0]], dtype=np.float64)
            up = np.broadcast_to(unit(np.array([0.1, 1, 0.2])), card.positions.shape)
            front = Mesh(card.positions, up, uvs, card.indices)
            back = Mesh(card.positions, up, uvs, card.indices[:, ::-1])
            blades += [side.turned("y", turn + 60 * index).at(*place) for side in (front, back)]
    return join(blades)


def fence(places: Array) -> Parts:
    """Return posts at (n, 2) x, z places, joined by two rails."""
    rng = np.random.default_rng(8)
    posts = [lathe([(0.055, -0.2), (0.05, 0.95), (0.0, 1.02)], segments=8, crease_deg=60, uv=(0.3, 1)).turned("z", rng.uniform(-4, 4)).at(x, 0, z) for x, z in places]
    rails = []
    for a, b in zip(places[:-1], places[1:], strict=True):
        for y in (0.42, 0.8):
            sag = rng.uniform(-0.05, 0.05)
            rails.append(tube([(a[0], y, a[1]), ((a[0] + b[0]) / 2, y + sag, (a[1] + b[1]) / 2 + 0.03), (b[0], y + 0.02, b[1])], 0.038, segments=6, uv=(0.3, 2)))
    return [(join([*posts, *rails]), "timber")]


def log_seat(detail: float = 1.0) -> Parts:
    """Return a bench of a halved trunk on two stumps (long side along X)."""
    n = 14 if detail > 0.5 else 7
    seat = lathe([(0.0, -0.95), (0.2, -0.95), (0.21, 0), (0.2, 0.95), (0.0, 0.95)], segments=n, crease_deg=50, uv=(1, 1.9)).turned("z", 90).scaled(1, 0.55, 1).at(0, 0.43)
    stumps = [lathe([(0.17, 0), (0.15, 0.34), (0.0, 0.34)], segments=n, crease_deg=50, uv=(1, 0.4)).at(x, 0) for x in (-0.6, 0.6)]
    return [(join([seat, *stumps]), "timber")]


def bird() -> Parts:
    """Return a soaring bird of 1.6 m span that flies towards +X."""
    body = ball(1.0, segments=10, rings=6).scaled(0.34, 0.08, 0.085)
    head = ball(0.07, segments=8, rings=5).at(0.36, 0.02)
    span = np.linspace(0, 1, 7)
    wings = []
    for side in (1, -1):
        chord = 0.26 * (1 - 0.55 * span**2)
        lead = 0.14 - 0.18 * span**2
        y = 0.02 + 0.16 * span - 0.06 * span**2
        points = np.stack([np.stack([lead, y, side * span * 0.82], 1), np.stack([lead - chord, y - 0.01, side * span * 0.82], 1)], axis=1)
        wings.append(grid(points, points[..., [0, 2]], flip=side > 0))
    tail = np.array([[[-0.28, 0.02, 0.03], [-0.28, 0.02, -0.03]], [[-0.56, 0.02, 0.13], [-0.56, 0.02, -0.13]]])
    return [(join([body, head, *wings, grid(tail, tail[..., [0, 2]])]), "feather")]


def path_strip(places: Array, width: float) -> Mesh:
    """Return a ribbon along (n, 2) x, z places, 2 cm above the ground, u across."""
    p = np.asarray(places)
    along = unit(np.gradient(np.column_stack([p[:, 0], 0 * p[:, 0], p[:, 1]]), axis=0))
    side = np.cross(along, [0.0, 1.0, 0.0])
    middle = np.column_stack([p[:, 0], np.full(len(p), 0.02), p[:, 1]])
    points = np.stack([middle - side * width / 2, middle + side * width / 2], axis=1)
    length = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(p, axis=0).T))])
    uvs = np.stack(np.broadcast_arrays(np.array([0.0, 1.0])[None], -length[:, None] / width), axis=-1)
    return grid(points, uvs)


def needles_png(seed: int, size: int = 256) -> bytes:
    """Return a conifer branch on a transparent ground (stem along v, tip at v = 0)."""
    u, v = coordinates(size)
    x, along = (u - 0.5) * 2, 1 - v
    twig = 7
    alpha = np.abs(x) < 0.03
    for side in (1, -1):
        for index in range(twig):
            root = 0.03 + 0.93 * index / twig
            reach = 0.95 * (1 - root) ** 0.7 + 0.1
            t = side * x / reach
            line = along - root - 0.42 * t * reach
            comb = 0.5 + 0.5 * np.cos(2 * np.pi * 30 * (t + 0.4 * np.abs(line) * 8))
            alpha |= (t > 0) & (t < 1) & (np.abs(line) < (0.052 + 0.03 * (1 - t)) * (0.55 + 0.45 * comb))
    soft = blurred(alpha.astype(np.float64), 0.9)
    tone = 0.5 + 0.7 * (cloud(seed, size, exponent=1.0, low=4) - 0.5) + 0.2 * np.abs(x)
    color = np.stack([44 + 56 * tone, 66 + 64 * tone, 38 + 40 * tone], axis=-1)
    return cutout_png(color, np.clip(soft * 1.25, 0, 1))


def grass_png(seed: int, size: int = 256) -> bytes:
    """Return blades of grass on a transparent ground (root at v = 1)."""
    rng = np.random.default_rng(seed)
    u, v = coordinates(size)
    alpha, tone = np.zeros((size, size)), np.zeros((size, size))
    for _ in range(46):
        root, lean, tall = rng.uniform(0.18, 0.82), rng.uniform(-0.55, 0.55), rng.uniform(0.45, 0.98)
        t = (1 - v) / tall
        blade = (np.abs(u - root - lean * 0.5 * t**1.8) < 0.017 * (1 - t) + 0.003) & (t < 1)
        alpha = np.where(blade, 1.0, alpha)
        tone = np.where(blade, rng.uniform(0, 1) * 0.5 + 0.5 * t, tone)
    color = np.stack([92 + 84 * tone, 104 + 68 * tone, 52 + 50 * tone], axis=-1)
    solid = blurred(alpha, 0.6) > 0.02
    ground = np.array([120.0, 128.0, 70.0])
    return cutout_png(np.where(solid[..., None] & (alpha[..., None] > 0), color, ground), blurred(alpha, 0.5))


def path_png(seed: int, size: int = 512) -> bytes:
    """Return trodden gravel with ragged, transparent edges at u = 0 and 1."""
    u, _ = coordinates(size)
    pebbles = cloud(seed, size, exponent=0.35, low=20)
    broad = cloud(seed + 1, size, exponent=1.5, low=2)
    tone = 0.5 + 0.9 * (pebbles - 0.5) + 0.5 * (broad - 0.5)
    edge = np.minimum(u, 1 - u) + 0.55 * (broad - 0.5) + 0.18 * (pebbles - 0.5)
    color = np.stack([98 + 70 * tone, 86 + 64 * tone, 68 + 54 * tone], axis=-1)
    return cutout_png(color, np.clip((edge - 0.12) * 9 + 0.5, 0, 1))


def ground_maps(seed: int, size: int = 512) -> tuple[bytes, bytes]:
    """Return neutral turf: (albedo of mean NEUTRAL, normal map)."""
    fine = cloud(seed, size, exponent=0.55, low=12)
    broad = cloud(seed + 1, size, exponent=1.3, low=3)
    tone = 0.5 + 1.0 * (fine - 0.5) + 0.4 * (broad - 0.5)
    ramp: Ramp = [(110, 106, 96), (172, 174, 164), (222, 224, 210)]
    return ramp_png(tone, 0, [ramp]), normal_png(2.5 * fine + broad, strength=0.9)


def granite_maps(seed: int, size: int = 512) -> tuple[bytes, bytes]:
    """Return grey stone with lichen."""
    fine = cloud(seed, size, exponent=0.6, low=10)
    broad = cloud(seed + 1, size, exponent=1.5, low=2)
    lichen = broad + 0.35 * (cloud(seed + 2, size, exponent=1.0, low=8) - 0.5) > 0.68
    tone = 0.5 + 0.7 * (fine - 0.5) + 0.5 * (broad - 0.5)
    ramps: list[Ramp] = [[(66, 64, 62), (124, 120, 114), (178, 172, 164)], [(92, 96, 58), (146, 148, 96), (182, 182, 130)]]
    return ramp_png(tone, lichen.astype(np.int64), ramps), normal_png(1.6 * fine + 2 * broad, strength=1.4)


__all__ = ["placed"]
