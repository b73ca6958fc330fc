"""The balls of a task in the pictures: in both eyes, under the effects, and met by the focus."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render.test_pipeline import SIZE, standing
from tests.support.render import at, glowing, scene, wall
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur
from vrcomfort.render.output import read_rgb8
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.markers import Markers

PLAIN = Condition(name="plain")
FAR = Condition(
    name="far",
    depth_of_field=DepthOfField(max_radius_percent=10.0),
    focus=Focus(method="fixed", fixed_m=30.0),
)
RAYS = Condition(name="rays", depth_of_field=DepthOfField(), focus=Focus(law="instant"))
STREAKS = Condition(name="streaks", motion_blur=MotionBlur(mode="objects_only"))
BALL = (np.array([0.0, 0.8, -1.0]), 0.1)


def room():
    """Return a dark wall 20 m ahead."""
    return scene([at(0, 0, -20.0, mesh=(0,))], [wall(100.0)], [glowing((0.0, 0.0, 0.02))])


def shown(ctx, condition, steps):
    """Draw frames, with the ball of each step; return the last images' red, and the focus."""
    markers = Markers(room(), [(0.9, 0.05, 0.05)])
    renderer = StereoRenderer(ctx, SIZE)
    renderer.build(markers.scene, condition)
    for index, ball in enumerate(steps):
        markers.place([ball])
        result = renderer.render(standing(index), index / 90)
    focus = renderer.drain()
    return [read_rgb8(eye)[..., 0].astype(float) for eye in result.eyes], focus


def test_a_ball_is_seen_by_both_eyes_where_its_distance_puts_it(ctx):
    (left, right), _ = shown(ctx, PLAIN, [BALL, BALL])
    columns = np.arange(SIZE[0])
    middles = [float((red.sum(axis=0) * columns).sum() / red.sum()) for red in (left, right)]
    assert left.max() > 60
    # 63 mm at 1 m, where half the width is a tangent of 1
    assert middles[0] - middles[1] == pytest.approx(0.063 * SIZE[0] / 2, abs=0.3)


def test_a_ball_that_is_taken_away_is_not_seen(ctx):
    (left, _), _ = shown(ctx, PLAIN, [BALL, BALL, None])
    (nothing, _), _ = shown(ctx, PLAIN, [None])
    np.testing.assert_array_equal(left, nothing)


def test_depth_of_field_blurs_a_ball_out_of_focus(ctx):
    (sharp, _), _ = shown(ctx, PLAIN, [BALL, BALL])
    (soft, _), _ = shown(ctx, FAR, [BALL, BALL])
    assert soft.max() < 0.8 * sharp.max()
    assert (soft > 5).sum() > 1.5 * (sharp > 5).sum()


def test_the_focus_is_found_on_a_ball(ctx):
    _, samples = shown(ctx, RAYS, [BALL, BALL, BALL])
    assert samples[-1].rays_m[0] == pytest.approx(0.9, abs=0.02)


def test_a_ball_that_moves_leaves_a_streak_and_one_that_appears_none(ctx):
    aside = (np.array([0.5, 0.8, -1.0]), 0.1)
    (moved, _), _ = shown(ctx, STREAKS, [BALL, BALL, aside])
    (came, _), _ = shown(ctx, STREAKS, [BALL, BALL, None, aside, aside, aside])
    (still, _), _ = shown(ctx, PLAIN, [aside, aside])
    np.testing.assert_allclose(came, still, atol=1.0)
    assert (moved > 5).sum() > 1.3 * (still > 5).sum()


def test_a_ball_that_is_never_still_is_seen_from_its_second_frame_on(ctx):
    path = [(np.array([0.02 * k, 0.8, -1.0]), 0.1) for k in range(5)]
    for count in (2, 5):
        (seen, _), _ = shown(ctx, PLAIN, path[:count])
        (still, _), _ = shown(ctx, PLAIN, [path[count - 1]] * 2)
        np.testing.assert_array_equal(seen, still)
    assert still.max() > 60


def test_a_ball_that_appears_is_no_longer_than_itself_while_it_grows(ctx):
    aside = (np.array([0.5, 0.8, -1.0]), 0.1)
    (grows, _), _ = shown(ctx, STREAKS, [BALL, BALL, None, aside, aside])
    (still, _), _ = shown(ctx, PLAIN, [aside, aside])
    assert not (grows[still == 0] > 5).sum() > 0.3 * (still > 5).sum()
