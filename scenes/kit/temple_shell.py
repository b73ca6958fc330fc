"""The temple's rooms: a bright court (x −5 to 5), a hall with windows (5.5 to 13), a dark crypt.

Walls are half a metre thick. North is −Z. A visitor starts at the origin, looking north.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .contact import floor
from .mesh import Array, Mesh, join
from .ornaments import Parts
from .shapes import arch_wall, box, plane

COURT, HALL, CRYPT = 5.4, 4.6, 3.8
"""Ceiling heights, metres."""
OPENING = (-2.65, 2.65, -7.2, 10.8)
"""The hole in the court's roof: x from, to, z from, to."""


def _along_z(wall: Mesh, x: float, z: float) -> Mesh:
    """Turn a wall that runs along +X to run along +Z from (x, z)."""
    return wall.turned("y", -90).at(x, 0, z)


def _windowed(
    width: float,
    height: float,
    windows: list[tuple[float, float, float]],
    doors: list[tuple[float, float, float]],
    sill: float = 1.1,
) -> Mesh:
    """Return a wall whose windows are arches closed up to their sill."""
    wall = arch_wall(width, height, 0.5, windows + doors, uv_m=2.4)
    sills = [box([gap, sill, 0.5], uv_m=2.4, bottom=False).at(centre) for centre, gap, _ in windows]
    return join([wall, *sills])


def walls() -> dict[str, Parts]:
    """Return every wall as a node of its own."""
    stone = {name: [(mesh, "sandstone")] for name, mesh in (_court() | _hall()).items()}
    return stone | {name: [(mesh, "basalt")] for name, mesh in _crypt().items()}


def _court() -> dict[str, Mesh]:
    arches = [(2.85, 2.2, 2.2), (10.45, 2.4, 2.2), (19.1, 2.4, 2.2)]
    west = arch_wall(21.5, COURT, 0.5, [(10.05, 3.4, 2.3)], uv_m=2.4)
    end = arch_wall(10.5, COURT, 0.5, [], uv_m=2.4)
    side = arch_wall(2.4, 4.4, 0.3, [], uv_m=2.4)
    back = _along_z(arch_wall(4.9, 4.4, 0.3, [], uv_m=2.4), -7.65, -1.65)
    return {
        "court_west": _along_z(west, -5.25, -9.25),
        "court_east": _along_z(arch_wall(21.5, COURT, 0.5, arches, uv_m=2.4), 5.25, -9.25),
        "court_north": end.at(-5.25, 0, -9.25),
        "court_south": end.at(-5.25, 0, 12.25),
        "alcove_walls": join([back, side.at(-7.7, 0, -1.5), side.at(-7.7, 0, 3.1)]),
    }


def _hall() -> dict[str, Mesh]:
    north = [(2.2, 1.2, 2.6), (5.6, 1.2, 2.6)]
    south = [(1.6, 1.2, 2.6), (4.0, 1.2, 2.6), (6.4, 1.2, 2.6)]
    east = _windowed(21.5, HALL, [(1.9, 1.1, 2.5), (4.4, 1.1, 2.5)], [(12.25, 2.0, 2.0)])
    return {
        "hall_east": _along_z(east, 13.25, -9.25),
        "hall_north": _windowed(8.0, HALL, north, []).at(5.25, 0, -9.25),
        "hall_south": _windowed(8.0, HALL, south, []).at(5.25, 0, 12.25),
    }


def _crypt() -> dict[str, Mesh]:
    end = arch_wall(11.5, CRYPT, 0.5, [], uv_m=1.8)
    # Its side of the wall it shares with the hall is dark stone: a lining 3 cm before it.
    lining = arch_wall(13.0, CRYPT, 0.06, [(5.0, 2.0, 2.0)], uv_m=1.8)
    return {
        "crypt_north": end.at(13.25, 0, -2.25),
        "crypt_south": end.at(13.25, 0, 11.25),
        "crypt_east": _along_z(arch_wall(13.5, CRYPT, 0.5, [], uv_m=1.8), 24.75, -2.25),
        "crypt_west": _along_z(lining, 13.52, -2.0),
    }


def floors(around: Sequence[Array]) -> dict[str, Parts]:
    """Return the floors, in tiles of a size that culling can use, finer `around` outlines."""

    def tile(x0: float, x1: float, z0: float, z1: float, uv_m: float) -> Mesh:
        x, z = (
            np.linspace(a, b, max(2, round((b - a) / 0.9) + 1)) for a, b in ((x0, x1), (z0, z1))
        )
        return floor(x, z, around, uv_m=uv_m)

    nodes: dict[str, Parts] = {}
    for index, (z0, z1) in enumerate(((-9, -2), (-2, 5), (5, 12))):
        nodes[f"court_floor_{index}"] = [(tile(-5, 5, z0, z1, 1.6), "star_tiles")]
        nodes[f"hall_floor_{index}"] = [(tile(5.5, 13, z0, z1, 1.5), "mosaic")]
    nodes["crypt_floor_0"] = [(tile(13.5, 24.5, -2, 4.5, 1.8), "slabs")]
    nodes["crypt_floor_1"] = [(tile(13.5, 24.5, 4.5, 11, 1.8), "slabs")]
    sills = [
        (5, 5.5, -7.5, -5.3),
        (5, 5.5, 0, 2.4),
        (5, 5.5, 8.65, 11.05),
        (13, 13.5, 2, 4),
        (-5.5, -5, -0.9, 2.5),
    ]
    nodes["thresholds"] = [(join([tile(*sill, 1.0) for sill in sills]), "marble")]
    nodes["alcove_floor"] = [(tile(-7.5, -5.5, -1.35, 2.95, 1.6), "star_tiles")]
    return nodes


def _ceiling(x0: float, x1: float, z0: float, z1: float, y: float, uv_m: float = 2.0) -> Mesh:
    return plane([x0, y, z0], [x1 - x0, 0, 0], [0, 0, z1 - z0], step_m=1.1, uv_m=uv_m)


def ceilings() -> dict[str, Parts]:
    """Return ceilings, beams and the roof above them (which casts the shadows)."""
    x0, x1, z0, z1 = OPENING
    ring = [(-5, x0, -9, 12), (x1, 5, -9, 12), (x0, x1, -9, z0), (x0, x1, z1, 12)]
    nodes: dict[str, Parts] = {
        "court_ceiling": [(join([_ceiling(*part, COURT) for part in ring]), "wood")],
        "court_beams_west": [(_beams(-5, x0, -8.4, 11.4, COURT), "wood")],
        "court_beams_east": [(_beams(x1, 5, -8.4, 11.4, COURT), "wood")],
        "hall_ceiling": [
            (
                join(
                    [_ceiling(5.5, 13, a, b, HALL) for a, b in ((-9, -5.2), (-3.8, 6.2), (7.8, 12))]
                    + [
                        _ceiling(x, w, a, b, HALL)
                        for a, b in ((-5.2, -3.8), (6.2, 7.8))
                        for x, w in ((5.5, 7.8), (10.8, 13))
                    ]
                ),
                "wood",
            )
        ],
        "hall_beams": [(_beams(5.5, 13, -8.2, 11.8, HALL, every=2.0), "wood")],
        "crypt_ceiling": [(_ceiling(13.5, 24.5, -2, 11, CRYPT), "basalt")],
        "crypt_beams": [(_vaults(), "basalt")],
        "alcove_ceiling": [(_ceiling(-7.5, -5.5, -1.35, 2.95, 4.4), "wood")],
    }
    top = 0.3
    hall = [(5.2, 13.5, -9.5, -5.2), (5.2, 13.5, -3.8, 6.2), (5.2, 13.5, 7.8, 12.5)]
    hall += [(5.2, 7.8, a, b) for a, b in ((-5.2, -3.8), (6.2, 7.8))] + [
        (10.8, 13.5, a, b) for a, b in ((-5.2, -3.8), (6.2, 7.8))
    ]
    outer = [(-5.5, x0, -9.5, 12.5), (x1, 5.5, -9.5, 12.5), (x0, x1, -9.5, z0), (x0, x1, z1, 12.5)]
    roofs = [_slab(*part, COURT, COURT + top) for part in outer]
    roofs += [_slab(*part, HALL, HALL + top) for part in hall]
    roofs += [
        _slab(13.2, 25.0, -2.5, 11.5, CRYPT, CRYPT + top),
        _slab(-7.8, -5.2, -1.65, 3.25, 4.4, 4.7),
    ]
    nodes["roofs"] = [(join(roofs), "sandstone")]
    return nodes


def _slab(x0: float, x1: float, z0: float, z1: float, y0: float, y1: float) -> Mesh:
    """Return a roof slab: sides and top."""
    return box([x1 - x0, y1 - y0 + 0.01, z1 - z0], uv_m=2.4, bottom=False).at(
        (x0 + x1) / 2, y0 - 0.01, (z0 + z1) / 2
    )


def _beams(x0: float, x1: float, z0: float, z1: float, y: float, every: float = 1.5) -> Mesh:
    spans = np.arange(z0, z1 + 0.01, every)
    openings = ((-5.2, -3.8), (6.2, 7.8)) if x0 > 5 else ()
    clear = [z for z in spans if not any(a - 0.1 < z < b + 0.1 for a, b in openings)]
    return join(
        [box([x1 - x0, 0.22, 0.18], uv_m=1.0).at((x0 + x1) / 2, y - 0.22, z) for z in clear]
    )


def _vaults() -> Mesh:
    """Return the crypt's heavy stone ribs."""
    across = [box([11, 0.35, 0.5], uv_m=1.8).at(19, CRYPT - 0.35, z) for z in (0.4, 8.6)]
    along = [box([0.5, 0.35, 13], uv_m=1.8).at(x, CRYPT - 0.35, 4.5) for x in (15.6, 21.6)]
    return join(across + along)


def friezes() -> dict[str, Parts]:
    """Return painted bands high on the walls and on the beams above the columns."""
    nodes: dict[str, Parts] = {}
    for side, x in (("west", -2.95), ("east", 2.95)):
        beam = box([0.56, 0.56, 20.6], uv_m=1.87).at(x, 4.6, 1.4)
        inward = 1 if x < 0 else -1
        faces = []
        for s in (inward, -inward):
            origin, along = (
                ([x + s * 0.285, 4.62, 11.7], [0, 0, -20.6])
                if s > 0
                else ([x + s * 0.285, 4.62, -8.9], [0, 0, 20.6])
            )
            faces.append(_band(origin, along, 0.52, 1.75))
        nodes[f"architrave_{side}"] = [(beam, "sandstone"), (join(faces), "frieze")]
    band = [
        ([5.51, 3.55, 12.0], [0, 0, -21.0]),
        ([12.99, 3.55, -9.0], [0, 0, 21.0]),
        ([5.5, 3.55, -8.99], [7.5, 0, 0]),
        ([13.0, 3.55, 11.99], [-7.5, 0, 0]),
    ]
    nodes["hall_frieze"] = [
        (join([_band(origin, along, 0.85, 2.85) for origin, along in band]), "frieze")
    ]
    court = [([-4.5, 4.0, -8.99], [9.0, 0, 0]), ([4.5, 4.0, 11.99], [-9.0, 0, 0])]
    nodes["court_frieze"] = [
        (join([_band(origin, along, 1.0, 3.36) for origin, along in court]), "frieze")
    ]
    return nodes


def _band(origin: list[float], along: list[float], height: float, repeat_m: float) -> Mesh:
    """Return an upright strip that shows the frieze's picture once over its height."""
    mesh = plane(origin, along, [0, height, 0], step_m=1.0, uv_m=1.0)
    return mesh.mapped(1 / repeat_m, 1 / height, v=1.0)
