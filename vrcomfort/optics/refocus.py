"""How focus follows what is looked at: the laws of accommodation.

Each law moves focus by the time since the frame before, whatever that was
(``shaders/include/refocus.glsl``). All but `low_pass_backward_euler` are exact: two steps are the
same as one of their summed length, so neither frame rate nor dropped frames change how fast focus
moves.

`instant` is at the target at once.
`linear` moves in metres, `infinity_m` in `refocus_s`: 60 km/s for 30 km in 500 ms, 16.7 µs per
metre (Carnegie & Rhee 2015; the printed 1.7 µs is a slip). Within a room that is instant.
`linear_dioptre` moves 1 D in `refocus_s`: 2 D/s, from the sky to 1 m in 500 ms, which is what
the physiology that the paper cites says.
`low_pass` and `low_pass_backward_euler` filter metres (Hillaire et al. 2008, Eq. 4).
`duration` (Mantiuk et al. 2011, 370 ms): every change of focus takes `duration_s`, near or far.
The paper gives no shape; ours is linear in dioptres, the eye's own unit. A change begins when
the target is further than `refixation_dioptre` from the one for which the last change began,
also on the way: focus then goes from where it is, in `duration_s`, to the new target. A
target that moves less is followed: on the way the change ends at it on time, afterwards focus
stays on it.
"""

from __future__ import annotations

import math


def low_pass_share(dt_s: float, cutoff_hz: float) -> float:
    """Return the share of the way to a target that a first-order low-pass moves in `dt_s`.

    1 − exp(−Δt/τ) with τ = 1/(2π·f_c), 31.8 ms for 5 Hz: the filter in continuous time. The paper
    prints τ = (π·f_c)/2, which is no time.
    """
    return -math.expm1(-dt_s * math.tau * cutoff_hz)


def backward_euler_share(dt_s: float, cutoff_hz: float) -> float:
    """Return the same for the paper's discrete filter: Δt / (Δt + τ) (Hillaire et al. 2008, Eq. 4).

    At its 70 Hz it is 3 dB down at 4.2 Hz, not at 5, and at other frame rates elsewhere.
    """
    return dt_s / (dt_s + 1 / (math.tau * cutoff_hz))
