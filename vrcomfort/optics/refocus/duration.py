"""`duration`: every change of focus takes `duration_s`, near or far (Mantiuk et al. 2011, 370 ms).

The paper gives no shape; ours is linear in dioptres, the eye's own unit. A change begins when the
target is further than `refixation_dioptre` from the one for which the last change began, also on
the way: focus then goes from where it is, in `duration_s`, to the new target. A target that moves
less is followed: on the way the change ends at it on time, afterwards focus stays on it.
"""

from __future__ import annotations

from vrcomfort.optics.refocus.law import RefocusLaw


def step_s(dt_s: float) -> float:
    """Return the seconds of a change that have passed."""
    return dt_s


LAW = RefocusLaw(
    "duration",
    step_s,
    "refocus_duration.glsl",
    uniforms=("duration_s", "refixation_dioptre"),
    remembers=True,
)
