"""The depth of what is seen: of a blurred foreground as far as its blur, else the scene's own."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracles.seen_depth import seen_depth
from tests.support.effects import seen, square_pixels, textures
from tests.support.render import still_life
from vrcomfort.geometry import Pose
from vrcomfort.gpu.passes import watched
from vrcomfort.gpu.traffic import TrafficCounter
from vrcomfort.protocol.conditions import Condition, DepthOfField
from vrcomfort.render.effects.depth_of_field.seen_depth import TAPS, SeenDepthPass
from vrcomfort.render.effects.effect import EffectInputs
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.tradeoff.costs import a_step

SIZE_PX = (61, 47)
FOCUS_M = 2.0
FULL_BLUR_DIOPTRE = 2.0


def spread(ctx, distance_m, percent):
    """Return the depth that was drawn, and the scene's own, with the widest disc in pixels."""
    colour, depth = textures(ctx, np.zeros((*distance_m.shape, 3)), distance_m)
    focus = ctx.texture((1, 1), 4, np.full(4, FOCUS_M, "f4").tobytes(), dtype="f4")
    lens = DepthOfField(
        law="dioptre", max_radius_percent=percent, full_blur_dioptre=FULL_BLUR_DIOPTRE
    )
    effect = SeenDepthPass(EffectInputs(ctx, lens, colour, {"depth": depth, "focus": focus}, 3e4))
    effect.render(seen(square_pixels(SIZE_PX)).camera)
    own, found = (
        np.frombuffer(each.read(), np.float32).reshape(distance_m.shape)
        for each in (depth, effect.target)
    )
    return found, own, percent / 100 * SIZE_PX[0]


@pytest.mark.parametrize("percent", [5.0, 10.0])
def test_it_is_that_of_the_nearest_foreground_whose_disc_reaches(ctx, percent):
    distance_m = np.random.default_rng(3).choice([0.6, 0.9, 1.5, 2.0, 5.0], SIZE_PX[::-1], p=[
        0.01, 0.01, 0.01, 0.47, 0.5])  # fmt: skip
    found, own, max_radius_px = spread(ctx, distance_m, percent)
    radius = (1 / FOCUS_M - 1 / distance_m) * max_radius_px / FULL_BLUR_DIOPTRE
    expected = seen_depth(own, np.clip(radius, -max_radius_px, max_radius_px), max_radius_px, TAPS)
    np.testing.assert_array_equal(found, expected.astype(np.float32))
    assert (found != own).any()


def test_wide_discs_are_sought_in_steps_and_lose_less_than_one(ctx):
    distance_m = np.full(SIZE_PX[::-1], 5.0)
    distance_m[:, :20] = 0.4
    found, own, max_radius_px = spread(ctx, distance_m, 10.0)
    reached = int((found[0] == own[0, 0]).sum()) - 20
    radius = min(max_radius_px, (1 / 0.4 - 1 / FOCUS_M) * max_radius_px / FULL_BLUR_DIOPTRE)
    assert radius - 1 < reached <= radius


@pytest.mark.parametrize("distance_m", [FOCUS_M, 50.0])
def test_nothing_behind_the_focus_spreads(ctx, distance_m):
    depths = np.full(SIZE_PX[::-1], 60.0)
    depths[10:20, 10:20] = distance_m
    found, own, _ = spread(ctx, depths, 10.0)
    np.testing.assert_array_equal(found, own)


@pytest.mark.parametrize(
    ("mode", "effects", "spreads"),
    [
        ("scene", {"depth_of_field": {"law": "dioptre"}}, False),
        ("blur_aware", {"depth_of_field": {"law": "dioptre"}}, True),
        ("blur_aware", {"vignette": {"open_deg": 60.0}}, False),
    ],
)
def test_only_a_blurred_condition_draws_it_and_pictures_stay(ctx, mode, effects, spreads):
    condition = Condition.model_validate({"name": "c", **effects})
    _, frame = a_step(Pose(), (48, 40))
    pictures, own, parts = [], [], []
    for each in ("scene", mode):
        renderer, counter = StereoRenderer(ctx, (48, 40), headset_depth=each), TrafficCounter(ctx)
        renderer.build(still_life(), condition)
        given = []
        with watched(counter):
            drawn = renderer.render(frame, 0.0, lambda _, images, to=given: to.append(images))
        pictures.append([image.read() for image in drawn.eyes])
        own.append([images.headset_depth is images.depth for images in given])
        parts.append(set(counter.parts))
        renderer.release()
    assert pictures[0] == pictures[1]
    assert own == [[True, True], [not spreads] * 2]
    assert parts[1] - parts[0] == ({"headset_depth"} if spreads else set())
