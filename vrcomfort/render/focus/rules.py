"""The focus rules there are."""

from __future__ import annotations

import moderngl

from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus import autofocus_zone, fixed, gaze, nine_ray, scripted
from vrcomfort.render.focus.rule import FocusInputs, FocusPass
from vrcomfort.render.gpu_scene import GpuScene

_RULES = nine_ray.RULE, autofocus_zone.RULE, gaze.RULE, fixed.RULE, scripted.RULE
RULES = {each.name: each for each in _RULES}
"""By name."""


def make_focus_pass(
    ctx: moderngl.Context,
    gpu: GpuScene,
    settings: Focus,
    *,
    near_m: float = 0.02,
    along_ray: bool = False,
) -> FocusPass:
    """Return the pass that `settings.method` asks for: :class:`FocusInputs` says what it takes."""
    return RULES[settings.method].build(FocusInputs(ctx, gpu, settings, near_m, along_ray))
