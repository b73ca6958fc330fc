"""Builds the head traces that fit the scenes: a walk of somebody through each of them.

Run ``python scenes/build_traces.py [FOLDER]``; the same bytes come out every time.
"""

from __future__ import annotations

import sys
from pathlib import Path

from vrcomfort.traces.synthesis import Gait, Look, Point, Walk, synthesize, with_hands
from vrcomfort.traces.trace import Trace, write_trace

STATUE = (0.0, 2.0, -8.1)
AMPHORA = (-1.75, 1.4, -2.75)
ORRERY = (-1.85, 1.55, -5.1)
TABLE = (11.3, 0.85, -5.6)
BURNER = (18.3, 1.25, 4.8)
ALTAR = (23.85, 1.3, 4.4)

TEMPLE_START: Point = (0.0, 0.0, 0.0)
TEMPLE: list[Walk | Look] = [
    Look(STATUE, 1.0),
    Walk((-0.5, 0.0, -2.2), AMPHORA),
    Look(AMPHORA, 1.6),
    Walk((-0.7, 0.0, -4.7), ORRERY),
    Look(ORRERY, 2.5),
    Walk((0.0, 0.0, -6.3), STATUE),
    Look((0.0, 2.4, -8.1), 1.5),
    Walk((4.0, 0.0, -6.4)),
    Walk((8.6, 0.0, -6.2), TABLE),
    Look(TABLE, 1.8),
    Walk((8.6, 0.0, 2.9)),
    Walk((16.0, 0.0, 3.0)),
    Look(BURNER, 2.2),
    Walk((16.4, 0.0, 2.0), BURNER),
    Walk((20.6, 0.0, 2.0), BURNER),
    Walk((22.0, 0.0, 4.2), ALTAR),
    Look(ALTAR, 2.2),
]

RANGE = (-30.0, 22.0, -400.0)
SIGNPOST = (-1.15, 1.55, -3.9)
CAIRN = (2.1, 0.75, -3.3)
BIRDS = (-4.0, 12.0, -42.0)
WIND_WHEEL = (-6.4, 6.15, -8.2)
HUT = (14.5, 1.5, -8.6)
EAST = (400.0, 5.0, 60.0)

MOUNTAIN_START: Point = (0.0, 0.0, 0.0)
MOUNTAIN: list[Walk | Look] = [
    Look(RANGE, 1.2),
    Walk((-0.1, 0.0, -2.8), SIGNPOST),
    Look(SIGNPOST, 2.0),
    Walk((0.7, 0.0, -3.7), CAIRN),
    Look(CAIRN, 2.2),
    Walk((1.0, 0.0, -5.6)),
    Walk((3.0, 0.0, -6.6), RANGE),
    Look(BIRDS, 2.4),
    Look(WIND_WHEEL, 2.0),
    Walk((4.6, 0.0, -6.6), RANGE),
    Walk((8.8, 0.0, -6.4), HUT),
    Look(HUT, 1.6),
    Walk((8.7, 0.0, -1.5)),
    Walk((9.6, 0.0, 1.5)),
    Walk((16.0, 0.0, 3.2), EAST),
    Walk((20.0, 0.0, 2.4)),
    Look(EAST, 1.6),
    Look((29.0, 5.0, -14.0), 1.6),
]

NEAREST, FIFTH, FARTHEST = (-0.28, 1.5, -0.41), (0.6, 1.5, -2.46), (5.56, 1.5, -18.4)
CAROUSEL = (-3.4, 1.5, -4.2)

DEPTHS_START: Point = (0.0, 0.0, 0.0)
DEPTHS: list[Walk | Look] = [
    Look(NEAREST, 1.6),
    Look(FIFTH, 1.4),
    Look(FARTHEST, 1.4),
    Walk((4.3, 0.0, 0.9), FIFTH),
    Look(FARTHEST, 1.2),
    Walk((-4.9, 0.0, 1.2)),
    Look(CAROUSEL, 1.6),
    Walk((-4.9, 0.0, -9.0), CAROUSEL),
    Look(FARTHEST, 1.4),
    Walk((-4.9, 0.0, -23.2)),
    Walk((-1.0, 0.0, -23.0)),
    Look(NEAREST, 1.6),
    Look(FARTHEST, 1.4),
]


def temple() -> Trace:
    """Walk from the bright court through the hall into the dark crypt."""
    return synthesize(TEMPLE_START, TEMPLE, seed=2015, gait=Gait(eye_height_m=1.66))


def mountain() -> Trace:
    """Walk along the terrace: near things, then the valley, the birds and the far ranges."""
    return synthesize(MOUNTAIN_START, MOUNTAIN, seed=30_000, gait=Gait(eye_height_m=1.64))


def depths() -> Trace:
    """Walk before the targets and past them, with something in both hands."""
    walk = synthesize(DEPTHS_START, DEPTHS, seed=500, gait=Gait(eye_height_m=1.65))
    return with_hands(walk)


TRACES = {"temple_walk": temple, "mountain_walk": mountain, "depths_walk": depths}


def build(folder: Path) -> None:
    """Build all traces and write them."""
    for name, make in TRACES.items():
        write_trace(make(), folder / f"{name}.csv")


if __name__ == "__main__":
    build(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent)
