"""`low_pass_backward_euler`: the paper's discrete filter over metres (Hillaire et al. 2008, Eq. 4).

At its 70 Hz it is 3 dB down at 4.2 Hz, not at 5, and at other frame rates elsewhere: `low_pass` is
the filter that it stands for.
"""

from __future__ import annotations

import math

from vrcomfort.optics.refocus.law import RefocusLaw


def backward_euler_share(dt_s: float, cutoff_hz: float) -> float:
    """Return the share of the way to a target that focus moves in `dt_s`: Δt / (Δt + τ)."""
    return dt_s / (dt_s + 1 / (math.tau * cutoff_hz))


LAW = RefocusLaw(
    "low_pass_backward_euler", backward_euler_share, "refocus_share.glsl", ("cutoff_hz",)
)
