"""The condition that the options of a command name."""

from __future__ import annotations

from vrcomfort.errors import InputError
from vrcomfort.protocol import Condition, DepthOfField, Focus, MotionBlur, Protocol

DEFAULT_CONDITION = Condition(
    name="default",
    label="Depth of field like an eye's, and motion blur without that of turning the head",
    focus=Focus(mean="dioptres", law="linear_dioptre"),
    depth_of_field=DepthOfField(law="dioptre"),
    motion_blur=MotionBlur(),
)


def pick_condition(
    protocol: str | None, condition: str | None
) -> tuple[Protocol | None, Condition]:
    """Return the condition that a pair of options names; without both, the default.

    Raises
    ------
    InputError
        If only one of the two is given, or the protocol has no such condition.
    """
    from vrcomfort.protocol import load_protocol

    if protocol is None:
        if condition is not None:
            raise InputError("--condition needs --protocol, the file that defines it")
        return None, DEFAULT_CONDITION
    study = load_protocol(protocol)
    names = [each.name for each in study.conditions]
    if condition is None or condition not in names:
        given = f"no condition {condition!r}" if condition else "--condition is missing"
        raise InputError(f"{given}; protocol {study.name} has: {', '.join(names)}")
    return study, study.condition(condition)
