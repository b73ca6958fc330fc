"""The focus rules, found in the modules of this package by themselves."""

from __future__ import annotations

import moderngl

from vrcomfort.declarations import declared_in
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render import focus
from vrcomfort.render.focus.search import FocusInputs, FocusPass, FocusRule
from vrcomfort.render.gpu_scene import GpuScene

RULES = {each.name: each for each in declared_in(focus, FocusRule)}
"""By name."""


def make_focus_pass(
    ctx: moderngl.Context,
    gpu: GpuScene,
    settings: Focus,
    *,
    near_m: float = 0.02,
    along_ray: bool = False,
) -> FocusPass:
    """Return the focus pass of `settings.method`; parameters as in :class:`FocusInputs`."""
    return RULES[settings.method].build(FocusInputs(ctx, gpu, settings, near_m, along_ray))
