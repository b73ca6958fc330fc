"""`instant`: focus is at its target at once."""

from __future__ import annotations

from vrcomfort.optics.refocus.law import AT_ONCE, RefocusLaw


def step_m(_: float) -> float:
    """Return more metres than there are."""
    return AT_ONCE


LAW = RefocusLaw("instant", step_m, "refocus_metres.glsl")
