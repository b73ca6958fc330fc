"""Refuses, before anything is written, a headset or a trace without the gaze that focus needs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

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
    if (needing := _led_by_gaze(conditions)) and not has_one():
        raise _without_gaze(needing, "this headset has no eye tracker; use one that has")


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
    needing = _led_by_gaze(conditions)
    if needing and (trace is None or trace.gaze is None):
        remedy = "give a frames.csv with its gaze.csv beside it (simulate: or [simulation.eyes])"
        raise _without_gaze(needing, f"what is played back has no gaze; {remedy}")


def _led_by_gaze(conditions: Iterable[Condition]) -> list[str]:
    """Return the names of the conditions that cannot be shown without gaze."""
    return [
        condition.name
        for condition in conditions
        if condition.depth_of_field is not None
        and condition.focus.method == "gaze"
        and condition.focus.without_gaze == "stop"
    ]


def _without_gaze(needing: list[str], why: str) -> InputError:
    return InputError(
        f"focus follows the gaze in {', '.join(needing)}, and {why}, "
        'or write without_gaze = "nine_ray" under [conditions.focus]'
    )
