"""`fixed`: focus that nothing decides, and that draws nothing."""

from __future__ import annotations

import numpy as np

from vrcomfort.frame import FocusSample
from vrcomfort.optics.focus import RAYS
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.readback import focus_texture, write_focus
from vrcomfort.render.focus.rule import FocusInputs, FocusRule, Sight
from vrcomfort.render.planned_pass import PlannedPass


def plan(settings: Focus) -> PlannedPass:
    """Plan no pass."""
    return PlannedPass("focus", False, f"focus is fixed at {settings.fixed_m:g} m")


class FixedFocus:
    """The focus distance `fixed_m` in every frame, whatever law there is."""

    def __init__(self, inputs: FocusInputs) -> None:
        self._focus_m = inputs.settings.fixed_m
        self.texture = focus_texture(inputs.ctx, self._focus_m)
        self.triangles = 0

    def render(self, sight: Sight) -> tuple[FocusSample, ...]:
        """Return the sample of this frame."""
        no_rays, unused = np.full(RAYS, np.nan), np.zeros(RAYS, dtype=bool)
        return (FocusSample(sight.frame_index, self._focus_m, self._focus_m, no_rays, unused),)

    def adjust(self, settings: Focus) -> None:
        """Be at another distance from now on."""
        self._focus_m = settings.fixed_m
        write_focus(self.texture, self._focus_m)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return nothing: nothing is late."""
        return ()


RULE = FocusRule("fixed", plan, FixedFocus)
