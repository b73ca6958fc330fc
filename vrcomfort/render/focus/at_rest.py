"""Rules whose focus follows nothing and draws nothing: `fixed` and `scripted`."""

from __future__ import annotations

import numpy as np

from vrcomfort.frame import FocusSample
from vrcomfort.optics.focus import RAYS, scripted_focus_m
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.search import (
    FocusInputs,
    FocusRule,
    HeadView,
    focus_texture,
    write_focus,
)


def _decide_fixed(settings: Focus) -> tuple[bool, str]:
    """Say that it draws nothing."""
    return False, f"focus is fixed at {settings.fixed_m:g} m"


class FixedFocus:
    """The focus distance `fixed_m` in every frame, under any law."""

    def __init__(self, inputs: FocusInputs) -> None:
        self._focus_m = inputs.settings.fixed_m
        self.texture = focus_texture(inputs.ctx, self._focus_m)

    def render(self, view: HeadView) -> tuple[FocusSample, ...]:
        """Return the sample of this frame."""
        no_rays, unused = np.full(RAYS, np.nan), np.zeros(RAYS, dtype=bool)
        return (FocusSample(view.frame_index, self._focus_m, self._focus_m, no_rays, unused),)

    def adjust(self, settings: Focus) -> None:
        """Be at another distance from now on."""
        self._focus_m = settings.fixed_m
        write_focus(self.texture, self._focus_m)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return nothing: nothing is late."""
        return ()


def _decide_script(settings: Focus) -> tuple[bool, str]:
    """Say that it draws nothing."""
    again = f", every {settings.script_every_s:g} s" if settings.script_every_s else ""
    return False, f"a script of {len(settings.script)} distances{again}"


class ScriptedFocus:
    """The distance in `script` at the time of the scene, under any law.

    Mantiuk et al. 2011 compare it with focus that follows the gaze.
    """

    def __init__(self, inputs: FocusInputs) -> None:
        self._settings = inputs.settings
        self.texture = focus_texture(inputs.ctx, self._focus_m(0.0))

    def _focus_m(self, time_s: float) -> float:
        return scripted_focus_m(self._settings.script, time_s, self._settings.script_every_s)

    def render(self, view: HeadView) -> tuple[FocusSample, ...]:
        """Write the distance of this frame, and return its sample."""
        focus_m = self._focus_m(view.scene_time_s)
        self.texture.write(np.array([focus_m, focus_m, 0.0, 1.0], dtype=np.float32))
        no_rays, unused = np.full(RAYS, np.nan), np.zeros(RAYS, dtype=bool)
        return (FocusSample(view.frame_index, focus_m, focus_m, no_rays, unused),)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return nothing: nothing is late."""
        return ()


FIXED = FocusRule("fixed", _decide_fixed, FixedFocus)
SCRIPTED = FocusRule("scripted", _decide_script, ScriptedFocus)
