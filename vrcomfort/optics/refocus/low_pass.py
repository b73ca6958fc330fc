"""`low_pass`: a first-order low-pass over metres, in continuous time (Hillaire et al. 2008, Eq. 4).

The share of the way that is left falls by e in τ = 1/(2π·f_c), 31.8 ms for 5 Hz. The paper prints
τ = (π·f_c)/2, which is no time.
"""

from __future__ import annotations

import math

from vrcomfort.optics.refocus.law import RefocusLaw


def low_pass_share(dt_s: float, cutoff_hz: float) -> float:
    """Return the share of the way to a target that focus moves in `dt_s`: 1 − exp(−Δt/τ)."""
    return -math.expm1(-dt_s * math.tau * cutoff_hz)


LAW = RefocusLaw("low_pass", low_pass_share, "refocus_share.glsl", ("cutoff_hz",))
