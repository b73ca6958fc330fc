"""How focus follows what is looked at: the laws of accommodation.

NumPy twins of ``shaders/include/refocus.glsl``. Each law moves focus by the time since the frame
before, whatever that was. All but `low_pass_backward_euler` are exact: two steps are the same as
one of their summed length, so neither frame rate nor dropped frames change how fast focus moves.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np


class RefocusSettings(Protocol):
    """The settings used here; `protocol.conditions.Focus` has them."""

    @property
    def law(self) -> str:
        """Return the law's name, one of those below."""

    @property
    def refocus_s(self) -> float:
        """Return the time from `infinity_m` to 1 m of the two linear laws."""

    @property
    def infinity_m(self) -> float:
        """Return the distance taken for the sky."""

    @property
    def cutoff_hz(self) -> float:
        """Return the cut-off frequency of the low-pass filters."""

    @property
    def duration_s(self) -> float:
        """Return how long every change of focus takes."""

    @property
    def refixation_dioptre(self) -> float:
        """Return how far a target has to move before a new change of focus begins."""


class FocusState(NamedTuple):
    """What a law remembers from frame to frame.

    Parameters
    ----------
    focus_m
        Where focus is.
    aim_m, left_s
        `duration` only: the target for which the present change began, and the time it still has.
    """

    focus_m: float
    aim_m: float = math.inf
    left_s: float = 0.0


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


def refocus(current_m: float, target_m: float, dt_s: float, settings: RefocusSettings, /) -> float:
    """Return the focus distance `dt_s` after it was `current_m`; it never passes `target_m`.

    For the laws without a memory, which are all but `duration`.

    Notes
    -----
    `instant` is at the target at once.
    `linear` moves in metres, `infinity_m` in `refocus_s`: 60 km/s for 30 km in 500 ms, 16.7 µs per
    metre (Carnegie & Rhee 2015; the printed 1.7 µs is a slip). Within a room that is instant.
    `linear_dioptre` moves 1 D in `refocus_s`: 2 D/s, from the sky to 1 m in 500 ms, which is what
    the physiology that the paper cites says.
    `low_pass` and `low_pass_backward_euler` filter metres (Hillaire et al. 2008, Eq. 4).
    """
    if settings.law == "instant":
        return target_m
    if settings.law == "linear":
        return _towards(current_m, target_m, settings.infinity_m / settings.refocus_s * dt_s)
    if settings.law == "linear_dioptre":
        return 1.0 / _towards(1.0 / current_m, 1.0 / target_m, dt_s / settings.refocus_s)
    filters = {"low_pass": low_pass_share, "low_pass_backward_euler": backward_euler_share}
    return _part_of_the_way(current_m, target_m, filters[settings.law](dt_s, settings.cutoff_hz))


def advance(
    state: FocusState, target_m: float, dt_s: float, settings: RefocusSettings, /
) -> FocusState:
    """Return the state `dt_s` later, by any law.

    Notes
    -----
    `duration` (Mantiuk et al. 2011, 370 ms): every change of focus takes `duration_s`, near or far.
    The paper gives no shape; ours is linear in dioptres, the eye's own unit. A change begins when
    the target is further than `refixation_dioptre` from the one for which the last change began,
    also on the way: focus then goes from where it is, in `duration_s`, to the new target. A
    target that moves less is followed: on the way the change ends at it on time, afterwards focus
    stays on it.
    """
    if settings.law != "duration":
        return FocusState(refocus(state.focus_m, target_m, dt_s, settings))
    aim_m, left_s = state.aim_m, state.left_s
    if abs(1 / target_m - 1 / aim_m) > settings.refixation_dioptre:
        aim_m, left_s = target_m, settings.duration_s
    share = dt_s / left_s if left_s > dt_s else 1.0
    focus_m = 1 / _part_of_the_way(1 / state.focus_m, 1 / target_m, share)
    return FocusState(focus_m, aim_m, max(left_s - dt_s, 0.0))


def _towards(current: float, target: float, step: float) -> float:
    return (
        target if abs(target - current) <= step else current + np.copysign(step, target - current)
    )


def _part_of_the_way(current: float, target: float, share: float) -> float:
    return target if share >= 1.0 else current + (target - current) * share
