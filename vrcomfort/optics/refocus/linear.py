"""`linear`: focus moves in metres, `infinity_m` in `refocus_s`.

60 km/s for 30 km in 500 ms, 16.7 µs per metre (Carnegie & Rhee 2015; the printed 1.7 µs is a slip).
Within a room that is instant.
"""

from __future__ import annotations

from vrcomfort.optics.refocus.law import RefocusLaw


def step_m(dt_s: float, *, infinity_m: float, refocus_s: float) -> float:
    """Return the metres that focus may move in `dt_s`."""
    return infinity_m / refocus_s * dt_s


LAW = RefocusLaw("linear", step_m, "refocus_metres.glsl", ("infinity_m", "refocus_s"))
