"""Refuses, before anything is written, what has no gaze where conditions need one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, NamedTuple

from vrcomfort.errors import InputError
from vrcomfort.protocol import Condition

if TYPE_CHECKING:
    from vrcomfort.traces.trace import Trace


def require_eye_tracker(conditions: Iterable[Condition], has_one: Callable[[], bool]) -> None:
    """Refuse a headset without an eye tracker where a condition needs one.

    Parameters
    ----------
    has_one
        Asks the headset; called only where it matters.

    Raises
    ------
    InputError
        Before anything is written; says what to do.
    """
    if (need := _need_of_gaze(conditions)) and not has_one():
        raise _without_gaze(need, "this headset has no eye tracker; use one that has")


def require_recorded_gaze(conditions: Iterable[Condition], trace: Trace | None) -> None:
    """Refuse what is played back, where a condition needs gaze and the trace has none.

    Parameters
    ----------
    trace
        None is a walk that ships with a scene.

    Raises
    ------
    InputError
        Before anything is written; says what to do.
    """
    need = _need_of_gaze(conditions)
    if need and (trace is None or trace.gaze is None):
        remedy = "give a frames.csv with its gaze.csv beside it (simulate: or [simulation.eyes])"
        raise _without_gaze(need, f"what is played back has no gaze; {remedy}")


class _Need(NamedTuple):
    """What needs gaze, in which conditions, and what a protocol writes to do without."""

    what: str
    conditions: list[str]
    remedy: str


def _need_of_gaze(conditions: Iterable[Condition]) -> _Need | None:
    """Return what cannot be shown without gaze."""
    every = tuple(conditions)
    focused = [each.name for each in every if _focus_stops(each)]
    if focused:
        remedy = 'without_gaze = "nine_ray" under [conditions.focus]'
        return _Need("focus follows the gaze", focused, remedy)
    centred = [each.name for each in every if _centre_stops(each)]
    if centred:
        remedy = 'without_gaze = "head" under [conditions.gaze_centre]'
        return _Need("effects are centred on the gaze", centred, remedy)
    return None


def _focus_stops(condition: Condition) -> bool:
    focus = condition.focus
    follows = condition.depth_of_field is not None and focus.method == "gaze"
    return follows and focus.without_gaze == "stop"


def _centre_stops(condition: Condition) -> bool:
    centre = condition.gaze_centre
    return bool(condition.centred_on_gaze) and centre is not None and centre.without_gaze == "stop"


def _without_gaze(need: _Need, why: str) -> InputError:
    names = ", ".join(need.conditions)
    return InputError(f"{need.what} in {names}, and {why}, or write {need.remedy}")
