"""How focus follows what is looked at: the laws of accommodation.

NumPy twins, in float64, of ``shaders/include/refocus.glsl``. The laws and their sources:
`vrcomfort.optics.refocus`.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from vrcomfort.optics.refocus import backward_euler_share, low_pass_share


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


def refocus(current_m: float, target_m: float, dt_s: float, settings: RefocusSettings, /) -> float:
    """Return the focus distance `dt_s` after it was `current_m`; it never passes `target_m`.

    For the laws without a memory, which are all but `duration`.
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
    """Return the state `dt_s` later, by any law."""
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
