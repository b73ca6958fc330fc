"""What stands in the temple's rooms."""

from __future__ import annotations

import numpy as np

from . import furniture, lamps
from . import ornaments as o
from .mesh import Mesh, grid, join, numbers, smooth
from .ornaments import Parts, placed
from .shapes import ball, box, lathe, plane, tube
from .stage import Stage

COLUMNS_Z = (-8.0, -4.7, -1.6, 3.4, 6.6, 11.0)


BRAZIERS = ((15.0, 9.7), (23.4, 9.6), (23.5, -0.9), (15.2, -1.0))


def furnish_court(stage: Stage) -> None:
    """Place what stands in the bright court."""
    for side, x in (("w", -2.95), ("e", 2.95)):
        for index, z in enumerate(COLUMNS_Z):
            stage.add(
                f"column_{side}{index}", *(placed(o.column(d), x, 0, z) for d in (1.0, 0.4, 0.2))
            )
    on_plinth = [
        ("statue_north", lambda d: placed(o.statue(d), 0, 0.95, 0, 0, 1.12), (0, -8.1, 0), 0.9),
        ("amphora_west", lambda d: placed(o.amphora(d), 0, 0.95, 0), (-1.75, -2.75, 15), 0.5),
        ("urn_east", lambda d: placed(o.urn(d), 0, 0.95, 0), (1.8, -4.3, 40), 0.5),
        ("amphora_south", lambda d: placed(o.amphora(d), 0, 0.95, 0), (-2.0, 8.9, 0), 0.5),
        ("statue_alcove", lambda d: placed(o.statue(d), 0, 0.95, 0, 0, 0.8), (-7.15, 0.8, 90), 0.6),
    ]
    for name, make, (x, z, turn), width in on_plinth:
        stage.add(
            name,
            *(placed(o.pedestal(d, width=width) + make(d), x, 0, z, turn) for d in (1.0, 0.25)),
        )
    stage.add("obelisk_east", *(placed(o.obelisk(d), 1.95, 0, -1.7, 12) for d in (1.0, 0.3)))
    stage.add("obelisk_south", *(placed(o.obelisk(d), -1.6, 0, 10.9, 0) for d in (1.0, 0.3)))
    stage.add("basin", *(placed(o.basin(d), 1.35, 0, 5.0) for d in (1.0, 0.35)))
    for index, (x, z) in enumerate(
        numbers("-4.3 -8.3, 4.3 -8.3, -4.35 11.3, 4.3 6.4, -4.3 5, 4.3 -3")
    ):
        stage.add(
            f"palm_{index}",
            placed(lamps.potted_palm(30 + index), x, 0, z),
            placed(lamps.potted_palm(30 + index, leaves=5, reach=1.15), x, 0, z),
        )
    for index, z in enumerate((-6.3, -3.1, 5.1)):
        stage.add(
            f"bench_{index}",
            *(
                placed(furniture.bench(d), -4.65, 0, z + (3 if index == 2 else 0), 90)
                for d in (1.0, 0.5)
            ),
        )
    for index, z in enumerate((-6.3, -3.1, 5.2, 8.1)):
        stage.add(
            f"banner_{index}",
            *(placed(banner(1.3, 2.1, d), -4.93, 1.35, z, 90) for d in (1.0, 0.25)),
        )


def banner(width: float, height: float, detail: float) -> Parts:
    """Return a hanging cloth on a pole, before a wall at z = −0.07."""
    x = np.linspace(-0.5, 0.5, o.few(13, detail))[None, :]
    t = np.linspace(0, 1, o.few(9, detail, 3))[:, None]
    depth = 0.022 * np.sin(16 * x + 1.5 * t) * (0.25 + 0.75 * (1 - t)) + 0.03
    points = np.stack(
        np.broadcast_arrays(x * width * (1 - 0.03 * (1 - t)), t * height, depth), axis=-1
    )
    uvs = np.stack(np.broadcast_arrays(x + 0.5, 1 - t + 0 * x), axis=-1)
    pole = tube(
        [(-width * 0.56, height + 0.015, 0.03), (width * 0.56, height + 0.015, 0.03)],
        0.022,
        segments=8,
    )
    ends = [
        ball(0.045, segments=o.few(12, detail), rings=o.few(6, detail, 3)).at(
            s * width * 0.57, height + 0.015, 0.03
        )
        for s in (1, -1)
    ]
    return [(grid(points, uvs), "cloth"), (join([pole, *ends]), "gold")]


def stele(width: float, height: float, detail: float = 1.0) -> Parts:
    """Return an inscribed slab with a rounded head in a marble foot."""
    angle = np.linspace(0, np.pi, 12 if detail > 0.5 else 6)
    spring = height - width / 2
    outline = [
        (width / 2, 0.0),
        *((width / 2 * np.cos(a), spring + width / 2 * np.sin(a)) for a in angle),
        (-width / 2, 0.0),
    ]
    rim = np.array([[(x, y, d) for x, y in outline] for d in (-0.09, 0.09)])
    edge = smooth(grid(rim, rim[..., :2] / 1.2), 40)
    fan = np.array([[(x, y, 0.09) for x, y in outline], [(0.0, y * 0.5, 0.09) for _, y in outline]])
    front = grid(fan, fan[..., :2] * [1 / 1.2, -1 / 1.2])
    back = front.turned("y", 180)
    slab: list[Mesh] = [edge, front, back]
    foot = box([width * 1.25, 0.16, 0.42], bevel_m=0.02)
    return [(join(slab).at(0, 0.16), "inscription"), (foot, "marble")]


def furnish_hall(stage: Stage) -> None:
    """Place what stands in the hall with windows."""
    stage.add(
        "table",
        *(
            placed(
                furniture.table(d)
                + (
                    placed(furniture.scrolls(3), 0.2, 0.78, 0.05)
                    + placed(o.amphora(d, height=0.3), -0.75, 0.78, -0.1)
                    + placed(o.urn(d, height=0.24), 0.9, 0.78, 0.12, 20)
                    + placed(lamps.lamp_stand(d), -0.2, 0.78, -0.22, 0, 0.35)
                    if d > 0.5
                    else []
                ),
                11.3,
                0,
                -5.6,
                -90,
            )
            for d in (1.0, 0.25)
        ),
    )
    for index, z in enumerate((-3.1, -0.6)):
        make = o.amphora if index == 0 else o.urn
        stage.add(
            f"hall_vase_{index}",
            *(
                placed(o.pedestal(d) + placed(make(d), 0, 0.95, 0), 6.35, 0, z, 90)
                for d in (1.0, 0.25)
            ),
        )
    stage.add(
        "statue_hall",
        *(
            placed(o.pedestal(d, width=0.8) + placed(o.statue(d), 0, 0.95, 0), 9.9, 0, 7.4, -120)
            for d in (1.0, 0.25)
        ),
    )
    for index, (x, z, turn) in enumerate(
        (
            (12.55, 5.8, -90),
            (12.55, 7.6, -90),
            (12.55, 9.4, -90),
            (12.6, -1.7, -90),
            (5.95, 5.2, 90),
        )
    ):
        stage.add(
            f"stele_{index}", *(placed(stele(1.0, 2.1, d), x, 0, z, turn) for d in (1.0, 0.3))
        )
    for index, (x, z) in enumerate(((12.4, -8.4), (6.1, -8.4), (12.4, 11.3), (6.1, 11.4))):
        stage.add(
            f"hall_palm_{index}",
            placed(lamps.potted_palm(50 + index), x, 0, z),
            placed(lamps.potted_palm(50 + index, leaves=5, reach=1.15), x, 0, z),
        )
    stage.add("hall_bench", *(placed(furniture.bench(d), 9.2, 0, -8.5, 0) for d in (1.0, 0.5)))
    stage.add("hall_lamp", *(placed(lamps.lamp_stand(d), 8.6, 0, 10.9) for d in (1.0, 0.25)))


def furnish_crypt(stage: Stage) -> None:
    """Place what stands in the dark room."""
    for index, (x, z) in enumerate(BRAZIERS):
        stage.add(
            f"brazier_{index}",
            *(placed(lamps.brazier(d), x, 0, z, 40 * index) for d in (1.0, 0.25)),
        )
    stage.add("sarcophagus", *(placed(o.sarcophagus(d), 18.6, 0, 10.0, 180) for d in (1.0, 0.25)))
    stage.add(
        "sarcophagus_north", *(placed(o.sarcophagus(d), 19.0, 0, -1.2, 0) for d in (1.0, 0.25))
    )
    for index, z in enumerate((1.6, 7.2)):
        stage.add(
            f"guardian_{index}",
            *(
                placed(
                    o.pedestal(d, width=0.75, height=0.7) + placed(o.statue(d), 0, 0.7, 0),
                    23.9,
                    0,
                    z,
                    -90,
                )
                for d in (1.0, 0.25)
            ),
        )
    stage.add("altar", *(placed(altar(d), 23.85, 0, 4.4, -90) for d in (1.0, 0.25)))
    for index, (x, z, turn) in enumerate(((14.0, 6.6, 90), (14.0, 8.2, 90), (13.98, 0.6, 90))):
        stage.add(
            f"crypt_stele_{index}", *(placed(stele(0.9, 1.8, d), x, 0, z, turn) for d in (1.0, 0.3))
        )
    stage.add(
        "crypt_urn",
        *(
            placed(o.urn(d, height=0.7), 16.6, 0, 10.3)
            + placed(o.amphora(d, height=0.9), 20.7, 0, 10.3)
            for d in (1.0, 0.25)
        ),
    )


def altar(detail: float) -> Parts:
    """Return a stone altar with candles, a gold disc and bowls (long side along X)."""
    parts: Parts = [
        (box([1.7, 0.85, 0.6], bevel_m=0.02, uv_m=1.2), "inscription"),
        (box([1.9, 0.08, 0.75], bevel_m=0.02).at(0, 0.85), "marble"),
    ]
    rays = (lambda angle, y: 1 + 0.10 * np.abs(np.sin(angle * 8)) + 0 * y) if detail > 0.5 else None
    disc = lathe(
        numbers("0 -0.025, 0.3 -0.02, 0.31 0, 0.26 0.02, 0.24 0.015, 0.1 0.03, 0 0.05"),
        segments=64 if detail > 0.5 else 16,
        radius=rays,
    )
    parts += [
        (disc.turned("x", 90).at(0, 1.36, -0.12), "gold"),
        (box([0.12, 0.14, 0.12]).at(0, 0.93, -0.12), "bronze"),
    ]
    for index, x in enumerate((-0.8, -0.66, -0.5, 0.48, 0.63, 0.79)):
        parts += placed(lamps.candle(0.14 + 0.05 * (index % 3)), x, 0.93, 0.08 * (index % 2))
    bowl = numbers("0 0, 0.06 0, 0.05 0.02, 0.13 0.07, 0.15 0.12, 0.14 0.12, 0.1 0.06, 0 0.05")
    return [*parts, (lathe(bowl, segments=24 if detail > 0.5 else 12).at(0, 0.93, 0.2), "bronze")]


def outside(stage: Stage) -> None:
    """Lay the ground and plant what is seen through windows."""
    ground = plane([-45, -0.12, 45], [110, 0, 0], [0, 0, -90], step_m=12, uv_m=3.0)
    stage.add("ground", [(ground, "earth")])
    places = numbers("8 -12.5, 10.6 -12, 15.6 -6.5, 16.4 -4.4, 7.2 15, 9.4 15.6, 11.8 14.8")
    for index, (x, z) in enumerate(places):
        stage.add(
            f"garden_{index}",
            *(placed(lamps.potted_palm(70 + index, leaves=n), x, -0.5, z, 0, 2.1) for n in (9, 5)),
        )


def orrery_stand(d: float) -> Parts:
    """Return the orrery's pedestal, stem and sun."""
    stem = lathe(
        numbers(
            "0 0.95, 0.09 0.95, 0.08 0.98, 0.025 1.02, 0.015 1.2, 0.03 1.24, 0.012 1.3, 0.012 1.5"
        ),
        segments=16,
    )
    return [
        *o.pedestal(d, width=0.46),
        (stem, "bronze"),
        (ball(0.075, segments=24, rings=12).at(0, 1.55), "gold"),
    ]
