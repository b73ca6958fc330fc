"""`linear_dioptre`: focus moves 1 D in `refocus_s`.

2 D/s, from the sky to 1 m in 500 ms, is what the physiology says that Carnegie & Rhee 2015 cite.
"""

from __future__ import annotations

from vrcomfort.optics.refocus.law import RefocusLaw


def step_dioptre(dt_s: float, *, refocus_s: float) -> float:
    """Return the dioptres that focus may move in `dt_s`."""
    return dt_s / refocus_s


LAW = RefocusLaw("linear_dioptre", step_dioptre, "refocus_dioptres.glsl", ("refocus_s",))
