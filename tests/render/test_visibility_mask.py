"""What no lens shows is neither drawn nor read; what is seen has the bits it has without a mask."""

from typing import get_args

import numpy as np
import pytest

from bench.mask import beyond_ellipse
from tests.render.test_pipeline import standing
from tests.support.render import RIGHT_ANGLE, still_life
from vrcomfort.gpu import passes, shaders, visible_area
from vrcomfort.gpu.traffic import TrafficCounter
from vrcomfort.protocol.conditions import (
    Condition,
    DepthOfField,
    Focus,
    Kernel,
    MotionBlur,
    RelocationBlur,
    SpeedBlur,
    Vignette,
)
from vrcomfort.render.output import read_texture
from vrcomfort.render.pipeline import StereoRenderer

SIZE = (64, 64)
WIDE = Focus(law="instant")
HIDDEN = (beyond_ellipse(RIGHT_ANGLE),) * 2
DEFOCUS = DepthOfField(max_radius_percent=4)
CONDITIONS = {
    "plain": {},
    "blur": {"depth_of_field": DEFOCUS},
    "half": {"depth_of_field": DepthOfField(max_radius_percent=4, samples=12)},
    "streaks": {"motion_blur": MotionBlur(mode="full", max_radius_percent=4)},
    "both": {
        "depth_of_field": DEFOCUS,
        "motion_blur": MotionBlur(mode="full", max_radius_percent=4),
    },
    "vignette": {"vignette": Vignette(open_deg=60, colour="scene")},
    "speed": {"speed_blur": SpeedBlur(moving={"from_m_s": 0.01, "to_m_s": 0.1})},
    "relocation": {"relocation_blur": RelocationBlur(level=2.5)},
    **{
        kernel: {"depth_of_field": replace_kernel}
        for kernel in get_args(Kernel)
        if kernel != "vrcomfort"  # is "blur"
        for replace_kernel in [DepthOfField(max_radius_percent=4, kernel=kernel)]
    },
}


def drawn(ctx, condition, hidden, size=SIZE, frames=(0.0, 0.06)):
    """Return the last frame's images, (2, height, width, 4), the lowest row first."""
    renderer = StereoRenderer(ctx, size, hidden=hidden)
    renderer.begin(still_life(), condition)
    for index, yaw in enumerate(frames):
        result = renderer.render(standing(index, yaw), index / 90)
    return np.stack([np.array(read_texture(eye))[::-1] for eye in result.eyes])


@pytest.mark.parametrize("name", CONDITIONS)
def test_what_is_seen_has_the_same_bits_and_the_rest_is_black(ctx, name):
    condition = Condition(name=name, focus=WIDE, **CONDITIONS[name])
    whole, masked = (drawn(ctx, condition, hidden) for hidden in ((None, None), HIDDEN))
    hidden = visible_area.hidden_pixels(HIDDEN[0], RIGHT_ANGLE, SIZE)
    assert 0.15 < hidden.mean() < 0.25
    assert (whole[:, ~hidden] == masked[:, ~hidden]).all()
    assert (masked[:, :6, :6, :3] == 0).all()
    assert (whole[:, :6, :6, :3] > 0).any()


LARGE = (192, 160)


def reads_of_undrawn(ctx, condition, size=LARGE):
    """Return by pass how many texels it reads in a frame that were to be drawn and were not."""
    with shaders.counting_reads(undrawn=True):
        renderer = StereoRenderer(ctx, size, hidden=HIDDEN[:1], eyes=1)
        renderer.build(still_life(), condition)
    renderer.render(standing(0), 0.0)
    renderer.area.clear(shaders.UNDRAWN, shaders.UNDRAWN_DEPTH)
    with passes.watched(counter := TrafficCounter(ctx)):
        renderer.render(standing(1, 0.06), 1 / 90)
    return {each.declared.name: each.reads for each in counter.drawn if each.reads}


@pytest.mark.parametrize("name", CONDITIONS)
def test_no_pass_reads_what_was_not_drawn(ctx, name):
    condition = Condition(name=name, focus=WIDE, **CONDITIONS[name])
    assert reads_of_undrawn(ctx, condition) == {}


@pytest.mark.parametrize(
    "name", sorted({"half", "blur", *get_args(Kernel)} - {"scatter", "vrcomfort"})
)
def test_no_kernel_has_the_whole_image_drawn(ctx, name):
    """Each of its passes says how far it reads; only discs of `scatter` may come from anywhere."""
    renderer = StereoRenderer(ctx, LARGE, hidden=HIDDEN[:1], eyes=1)
    renderer.build(still_life(), Condition(name=name, focus=WIDE, **CONDITIONS[name]))
    renderer.area.look([RIGHT_ANGLE])
    margin = renderer.area.margin(renderer.scene_pass.colour.glo)
    assert margin < min(LARGE) / visible_area.TILE_PX


def test_at_rest_what_is_seen_is_copied_and_nothing_else(ctx):
    condition = Condition(name="streaks", **CONDITIONS["streaks"])
    names = []
    for hidden in (HIDDEN[:1], (None, None)):
        renderer = StereoRenderer(ctx, SIZE, hidden=hidden, eyes=1)
        renderer.begin(still_life(), condition)
        renderer.render(standing(0), 0.0)
        with passes.watched(counter := TrafficCounter(ctx)):
            renderer.render(standing(1), 0.0)
        names.append({each.declared.name for each in counter.drawn})
    masked, whole = names
    assert "common/copy.frag" in masked
    assert "copy" not in masked
    assert "copy" in whole
    at_rest = (drawn(ctx, condition, hidden, frames=(0.0, 0.0)) for hidden in (HIDDEN, (None,) * 2))
    seen = ~visible_area.hidden_pixels(HIDDEN[0], RIGHT_ANGLE, SIZE)
    masked, whole = (images[:, seen] for images in at_rest)
    assert (masked == whole).all()


def test_passes_that_reach_farther_than_they_say_are_found(ctx, monkeypatch):
    monkeypatch.setattr(visible_area, "tiles_within", lambda *_: 0)
    found = reads_of_undrawn(ctx, Condition(name="both", focus=WIDE, **CONDITIONS["both"]))
    assert {"depth_of_field/complex.frag", "motion_blur/tile_max_dilate.frag"} & set(found)
