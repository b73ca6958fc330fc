"""`scripted`: focus and its changes are written down, as Mantiuk et al. 2011 have it in one way."""

from __future__ import annotations

import numpy as np

from vrcomfort.frame import FocusSample
from vrcomfort.optics.focus import RAYS, scripted_focus_m
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.readback import focus_texture
from vrcomfort.render.focus.rule import FocusInputs, FocusRule, Sight
from vrcomfort.render.planned_pass import PlannedPass


def plan(settings: Focus) -> PlannedPass:
    """Plan no pass."""
    again = f", every {settings.script_every_s:g} s" if settings.script_every_s else ""
    return PlannedPass("focus", False, f"a script of {len(settings.script)} distances{again}")


class ScriptedFocus:
    """The distance that `script` has at the time of the scene, whatever law there is."""

    def __init__(self, inputs: FocusInputs) -> None:
        self._settings = inputs.settings
        self.texture = focus_texture(inputs.ctx, self._focus_m(0.0))
        self.triangles = 0

    def _focus_m(self, time_s: float) -> float:
        return scripted_focus_m(self._settings.script, time_s, self._settings.script_every_s)

    def render(self, sight: Sight) -> tuple[FocusSample, ...]:
        """Write the distance of this frame, and return its sample."""
        focus_m = self._focus_m(sight.scene_time_s)
        self.texture.write(np.array([focus_m, focus_m, 0.0, 1.0], dtype=np.float32))
        no_rays, unused = np.full(RAYS, np.nan), np.zeros(RAYS, dtype=bool)
        return (FocusSample(sight.frame_index, focus_m, focus_m, no_rays, unused),)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return nothing: nothing is late."""
        return ()


RULE = FocusRule("scripted", plan, ScriptedFocus)
