"""The passes and draws that `plan` prints of an effect are those that a frame has."""

from __future__ import annotations

import ctypes
from contextlib import contextmanager, nullcontext
from itertools import groupby, pairwise
from typing import get_args

import moderngl
import pytest

from tests.support.render import still_life
from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl
from vrcomfort.gpu.passes import Watcher
from vrcomfort.gpu.passes import watched as passes_watched
from vrcomfort.protocol.conditions import EFFECTS, Condition, Kernel
from vrcomfort.render.graph import plan_passes
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.tradeoff.costs import a_step, by_effect, traffic_of
from vrcomfort.tradeoff.walk import REFRESH_HZ, time_s

SIZE_PX = (96, 80)
LENS = {"law": "dioptre", "max_radius_percent": 10.0}
SHUTTER = {"mode": "full", "shutter_fraction": 1.0}
MOVING = {"from_m_s": 0.01, "to_m_s": 0.1}
CASES = {
    **{kernel: {"depth_of_field": {**LENS, "kernel": kernel}} for kernel in get_args(Kernel)},
    "reconstruction": {"motion_blur": SHUTTER},
    "averaged": {"motion_blur": {**SHUTTER, "samples": 32}},
    "per_pixel": {"motion_blur": {**SHUTTER, "method": "per_pixel"}},
    "speed_blur": {"speed_blur": {"moving": MOVING}},
    "relocation_blur": {"relocation_blur": {}},
    "vignette": {"vignette": {"open_deg": 20.0, "restricted_deg": 10.0}},
    "vignette_scene": {"vignette": {"open_deg": 20.0, "restricted_deg": 10.0, "colour": "scene"}},
    "all": {
        "depth_of_field": LENS,
        "motion_blur": SHUTTER,
        "speed_blur": {"moving": MOVING},
        "relocation_blur": {},
        "vignette": {"open_deg": 20.0, "restricted_deg": 10.0},
    },
}
MIP_CHAINS = (
    "common/mip_downsample.frag",
    "depth_of_field/layers.frag",
    "depth_of_field/half_resolution.frag",
)
"""Shaders whose draws one after the other make the levels of one image: one pass."""

_DRAW_FRAMEBUFFER, _COLOR_ATTACHMENT0, _OBJECT_NAME = 0x8CA9, 0x8CE0, 0x8CD1


@contextmanager
def watched(ctx):
    """Yield a list that gets (shader, first texture that it draws into) of each draw."""
    asks = "glGetFramebufferAttachmentParameteriv"
    get = gl.function(ctx, asks, *[ctypes.c_uint] * 3, ctypes.c_void_p)
    where = _DRAW_FRAMEBUFFER, _COLOR_ATTACHMENT0, _OBJECT_NAME
    seen, target = [], ctypes.c_int()

    def watching(draw):
        def render(array, *arguments, **options):
            scope, array.scope = array.scope, None  # entered here, so that it can be asked for
            try:
                with scope or nullcontext():
                    get(*where, ctypes.byref(target))
                    seen.append((str(array.program.extra), target.value))
                    draw(array, *arguments, **options)
            finally:
                array.scope = scope

        return render

    with pytest.MonkeyPatch.context() as patch:
        for name in ("render", "render_indirect"):
            patch.setattr(moderngl.VertexArray, name, watching(getattr(moderngl.VertexArray, name)))
        dispatch = moderngl.ComputeShader.run

        def run(shader, *groups, **options):
            seen.append(("dispatch", shader.glo))
            dispatch(shader, *groups, **options)

        patch.setattr(moderngl.ComputeShader, "run", run)
        yield seen


def passes(seen):
    """Count runs of draws into the same texture, a mip chain as one."""
    runs = [next(draws)[0] for _, draws in groupby(seen, key=lambda each: each[1])]
    chained = sum(a == b and a in MIP_CHAINS for a, b in pairwise(runs))
    return len(runs) - chained


def drawn(ctx, scene, condition):
    """Return effect → (passes, draws) of the left eye, counted at the draws themselves."""
    renderer = StereoRenderer(ctx, SIZE_PX, eyes=1)
    renderer.build(scene, condition)
    before, frame = a_step(Pose(), SIZE_PX)
    renderer.render(before, time_s(frame) - 1 / REFRESH_HZ)
    counted = {}

    class Parts(Watcher):
        @contextmanager
        def part(self, name):
            first = len(seen)
            yield
            if name in EFFECTS:
                counted[name] = passes(seen[first:]), len(seen) - first

    with watched(ctx) as seen, passes_watched(Parts()):
        renderer.render(frame, time_s(frame))
    renderer.release()
    return counted


@pytest.mark.parametrize("case", CASES)
def test_what_is_planned_is_what_is_drawn(ctx, case):
    scene, condition = still_life(), Condition.model_validate({"name": "c", **CASES[case]})
    counted = drawn(ctx, scene, condition)
    planned = [each.name for each in plan_passes(scene, condition) if each.needed]
    assert list(counted) == [name for name in planned if name in EFFECTS]
    assert all(draws for _, draws in counted.values())
    told = by_effect(traffic_of(ctx, scene, condition, a_step(Pose(), SIZE_PX), SIZE_PX))
    assert {name: (each.passes, each.draws) for name, each in told.items()} == counted
