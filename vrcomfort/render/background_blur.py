"""Which nodes are drawn sharp over a blurred background: layers by node."""

from __future__ import annotations

from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.boxes import with_all_below
from vrcomfort.scene.data import Scene
from vrcomfort.settings import did_you_mean


def plan(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan the blur behind a foreground; level 0 is the scene itself.

    Raises
    ------
    InputError
        If no node of the scene has one of the names.
    """
    settings = condition.background_blur
    if settings is None:
        return PlannedPass("background_blur", False, "the condition has none")
    sharp = foreground(scene, condition)
    if settings.level == 0:
        return PlannedPass("background_blur", False, "its level is 0, the scene itself")
    reason = f"MIP level {settings.level:g} behind {int(sharp.sum())} of {len(sharp)} nodes"
    return PlannedPass("background_blur", True, reason)


def foreground(scene: Scene, condition: Condition) -> NDArray[np.bool_]:
    """Return (nodes,) which are drawn over the blur: those that are named, and all below them.

    Raises
    ------
    InputError
        If there are none.
    """
    settings = condition.background_blur
    patterns = () if settings is None else settings.foreground
    names = [node.name for node in scene.nodes]
    named = [any(fnmatchcase(name, pattern) for pattern in patterns) for name in names]
    found = with_all_below(scene, np.array(named, dtype=bool))
    if patterns and not found.any():
        wanted = " or ".join(repr(pattern) for pattern in patterns)
        hint = did_you_mean(patterns[0], set(names) - {""})
        raise InputError(
            f"condition {condition.name!r}: background_blur: no node of the scene "
            f"{scene.name!r} is called {wanted}; {hint}"
        )
    return found
