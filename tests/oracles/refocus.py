"""How focus follows what is looked at: the laws of accommodation.

NumPy twins, in float64, of ``shaders/include/refocus_*.glsl``, each by the name of its law. The
laws and their sources: `vrcomfort.optics.refocus`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vrcomfort.optics.refocus import LAWS
from vrcomfort.protocol.conditions import Focus


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


def metres(state: FocusState, target_m: float, step_m: float, _: Focus) -> FocusState:
    """Move by at most so many metres: ``refocus_metres.glsl``."""
    return FocusState(_towards(state.focus_m, target_m, step_m))


def dioptres(state: FocusState, target_m: float, step_dioptre: float, _: Focus) -> FocusState:
    """Move by at most so many dioptres: ``refocus_dioptres.glsl``."""
    return FocusState(1 / _towards(1 / state.focus_m, 1 / target_m, step_dioptre))


def share(state: FocusState, target_m: float, step_share: float, _: Focus) -> FocusState:
    """Move by a share of the way in metres: ``refocus_share.glsl``."""
    return FocusState(_part_of_the_way(state.focus_m, target_m, step_share))


def duration(state: FocusState, target_m: float, step_s: float, settings: Focus) -> FocusState:
    """Move so that each change takes `duration_s`: ``refocus_duration.glsl``."""
    aim_m, left_s = state.aim_m, state.left_s
    if abs(1 / target_m - 1 / aim_m) > settings.refixation_dioptre:
        aim_m, left_s = target_m, settings.duration_s
    part = step_s / left_s if left_s > step_s else 1.0
    focus_m = 1 / _part_of_the_way(1 / state.focus_m, 1 / target_m, part)
    return FocusState(focus_m, aim_m, max(left_s - step_s, 0.0))


TWINS: dict[str, Callable[[FocusState, float, float, Focus], FocusState]] = {
    "linear": metres,
    "linear_dioptre": dioptres,
    "low_pass": share,
    "low_pass_backward_euler": share,
    "duration": duration,
    "instant": metres,
}
"""By the name of the law."""


def advance(state: FocusState, target_m: float, dt_s: float, settings: Focus, /) -> FocusState:
    """Return the state `dt_s` later; focus never passes `target_m`."""
    step = LAWS[settings.law].step_size(settings, dt_s)
    return TWINS[settings.law](state, target_m, step, settings)


def _towards(current: float, target: float, step: float) -> float:
    return (
        target if abs(target - current) <= step else current + np.copysign(step, target - current)
    )


def _part_of_the_way(current: float, target: float, part: float) -> float:
    return target if part >= 1.0 else current + (target - current) * part
