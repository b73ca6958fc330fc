"""Focus where the participant looks: rays around the line of sight, blinks, no eye tracker."""

import numpy as np
import pytest

from tests.support.render import at, glowing, scene, wall
from vrcomfort.api.playback import require_eye_tracker
from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Fov, Gaze, Pose, View, yaw_pitch_roll
from vrcomfort.optics.focus import gaze_tangents
from vrcomfort.protocol import Condition, DepthOfField
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.rules import make_focus_pass
from vrcomfort.render.focus.search import HeadView
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.pipeline import StereoRenderer

SETTINGS = Focus(method="gaze", law="instant")
AHEAD = Gaze(Pose())
BLINK = Gaze(Pose(np.zeros(3), yaw_pitch_roll(1.0, 1.0, 0.0)), valid=False)


def gaze_at(yaw_deg, pitch_deg=0.0):
    return Gaze(Pose(np.zeros(3), yaw_pitch_roll(*np.radians([yaw_deg, pitch_deg, 0.0]))))


def rooms():
    """A wall at 6 m, a board at 2 m that is 20° to the left, a thin post at 1 m ahead."""
    nodes = [
        at(0.0, 0.0, -6.0, scale=np.array([60.0, 60.0, 1.0])),
        at(-2.0 * np.tan(np.radians(20)), 0.0, -2.0, scale=np.full(3, 0.6)),
        at(0.0, 0.0, -1.0, scale=np.array([0.012, 2.0, 1.0])),
    ]
    return scene(nodes, [wall()], [glowing((1.0, 1.0, 1.0))])


def samples(ctx, gazes, *, settings=SETTINGS, head=None, cuts=()):
    head = head or Pose()
    gpu = GpuScene(ctx, rooms())
    focus = make_focus_pass(ctx, gpu, settings)
    gpu.update(0.0, head)
    found = []
    for index, gaze in enumerate(gazes):
        found += focus.render(
            HeadView(
                frame_index=index,
                display_time_ns=index * 10_000_000,
                world_from_head=head,
                discontinuity=index in cuts,
                gaze=gaze,
            )
        )
    return [*found, *focus.drain()]


def test_focus_is_where_the_gaze_is(ctx):
    looks = [gaze_at(20.0), gaze_at(-20.0), gaze_at(20.0, 30.0), gaze_at(24.0)]
    found = samples(ctx, looks)
    assert [s.focus_m for s in found] == pytest.approx([2.0, 6.0, 6.0, 2.0], rel=1e-5)
    assert found[0].used.all()
    np.testing.assert_allclose(found[0].rays_m, 2.0, rtol=1e-5)


def test_depth_is_along_the_heads_axis_not_along_the_gaze(ctx):
    (found,) = samples(ctx, [gaze_at(-50.0, 10.0)])
    np.testing.assert_allclose(found.rays_m, 6.0, rtol=1e-5)


def test_a_thin_post_does_not_hold_the_focus_but_a_broad_board_at_its_rim_does(ctx):
    """The post is 0.7° wide: less than half of the 3° that the tracker may be wrong."""
    (at_post,) = samples(ctx, [AHEAD])
    assert at_post.focus_m == pytest.approx(6.0, rel=1e-5)
    assert np.isclose(at_post.rays_m, 1.0, rtol=1e-5).sum() >= 1
    # The board reaches from about 12 to 28 degrees; one degree inside its rim most rays are on it.
    inside, outside = samples(ctx, [gaze_at(26.4), gaze_at(29.5)])
    assert inside.focus_m == pytest.approx(2.0, rel=1e-5)
    assert outside.focus_m == pytest.approx(6.0, rel=1e-5)
    exact = SETTINGS.model_copy(update={"gaze_radius_deg": 0.0})
    (on_post,) = samples(ctx, [AHEAD], settings=exact)
    assert on_post.focus_m == pytest.approx(1.0, rel=1e-5)


def test_the_rays_are_where_the_twin_says(ctx):
    """Depths on a slanted wall: a plane n·p = c in the head's frame."""
    turn = Pose(np.zeros(3), yaw_pitch_roll(0.5, 0.3, 0.0))
    node = at(0.0, 0.0, -3.0, rotation=turn.orientation, scale=np.full(3, 40.0))
    gpu = GpuScene(ctx, scene([node], [wall()], [glowing((1.0, 1.0, 1.0))]))
    focus = make_focus_pass(ctx, gpu, SETTINGS)
    gpu.update(0.0, Pose())
    gaze = gaze_at(25.0, -10.0)
    focus.render(HeadView(frame_index=0, display_time_ns=0, world_from_head=Pose(), gaze=gaze))
    (found,) = focus.drain()
    rays = np.concatenate([gaze_tangents(gaze.pose, 1.5), -np.ones((9, 1))], axis=1)
    normal = turn.matrix()[:3, 2]
    np.testing.assert_allclose(found.rays_m, normal @ [0, 0, -3.0] / (rays @ normal), rtol=1e-5)
    assert found.focus_m == pytest.approx(np.median(found.rays_m), rel=1e-6)
    assert found.used.sum() == 1


def test_a_blink_keeps_the_target_and_focus_still_gets_there(ctx):
    slow = SETTINGS.model_copy(update={"law": "linear_dioptre", "refocus_s": 0.1})
    looks = [gaze_at(-20.0), gaze_at(20.0), BLINK, BLINK, gaze_at(-20.0)]
    found = samples(ctx, looks, settings=slow)
    target = [s.focus_raw_m for s in found]
    assert target == pytest.approx([6.0, 2.0, 2.0, 2.0, 6.0], rel=1e-5)
    dioptres = [1 / s.focus_m for s in found]
    expected = [1 / 6, 1 / 6 + 0.1, 1 / 6 + 0.2, 1 / 6 + 0.3, 1 / 6 + 0.2]
    assert dioptres == pytest.approx(expected, rel=1e-4)
    for blink in found[2:4]:
        assert np.isnan(blink.rays_m).all()
        assert not blink.used.any()


def test_before_the_eyes_are_found_focus_is_straight_ahead(ctx):
    off_post = Pose(np.array([0.5, 0.0, 0.0]))
    looks = [BLINK, BLINK, gaze_at(36.0), BLINK, BLINK, BLINK]
    found = samples(ctx, looks, head=off_post, cuts=(4,))
    expected = [6.0, 6.0, 2.0, 2.0, 6.0, 6.0]
    assert [s.focus_m for s in found] == pytest.approx(expected, rel=1e-5)


def test_a_gaze_that_no_eye_can_have_counts_as_none(ctx):
    found = samples(ctx, [gaze_at(20.0), gaze_at(100.0), gaze_at(180.0)])
    assert [s.focus_m for s in found] == pytest.approx([2.0] * 3, rel=1e-5)


def test_without_an_eye_tracker_there_is_a_sentence_or_nine_rays(ctx):
    with pytest.raises(InputError, match="has no eye tracker; use one that has, or write"):
        samples(ctx, [None])
    instead = SETTINGS.model_copy(update={"without_gaze": "nine_ray", "mean": "dioptres"})
    (found,) = samples(ctx, [None], settings=instead)
    rays = Focus(method="nine_ray", law="instant", mean="dioptres")
    (nine,) = samples(ctx, [None], settings=rays)
    np.testing.assert_array_equal(found.rays_m, nine.rays_m)
    assert found.focus_m == nine.focus_m
    assert found.used.tolist() == nine.used.tolist()


def test_an_eye_tracker_is_asked_for_only_where_focus_needs_one():
    follows = Condition(name="looks", focus=Focus(method="gaze"), depth_of_field=DepthOfField())
    sharp = Condition(name="sharp", focus=Focus(method="gaze"))  # nothing is out of focus
    instead = Focus(method="gaze", without_gaze="nine_ray")
    calm = follows.model_copy(update={"focus": instead})
    require_eye_tracker([sharp, calm], lambda: pytest.fail("nobody needs to know"))
    require_eye_tracker([sharp, follows], lambda: True)
    with pytest.raises(InputError, match="in looks, and this headset has no eye tracker"):
        require_eye_tracker([sharp, follows], lambda: False)


def frame(index, head, gaze_in_head):
    fov = Fov(-0.7, 0.7, 0.7, -0.7)
    gaze = None if gaze_in_head is None else Gaze(head @ gaze_in_head.pose, gaze_in_head.valid)
    eyes = tuple(View(head @ Pose(np.array([x, 0.0, 0.0])), fov) for x in (-0.03, 0.03))
    return Frame(index, index * 10_000_000, 10_000_000, head, eyes, Pose(), gaze=gaze)


def test_a_session_takes_the_gaze_from_stage_to_head(ctx):
    """In the renderer, with a head that is turned: what is looked at stays the same board."""
    renderer = StereoRenderer(ctx, (32, 40), samples=2)
    condition = Condition(name="gaze", focus=SETTINGS, depth_of_field=DepthOfField(law="eye"))
    renderer.begin(rooms(), condition)
    head = Pose(np.zeros(3), yaw_pitch_roll(np.radians(10.0), 0.0, 0.0))
    renderer.render(frame(0, head, gaze_at(10.0)), 0.0)
    (found,) = renderer.drain()
    # The board is square to the world, and depth runs along the head's axis, 10° beside.
    across = 2.0 * np.tan(np.radians(20.0))
    expected = 2.0 * np.cos(np.radians(10.0)) + across * np.sin(np.radians(10.0))
    assert found.rays_m[0] == pytest.approx(expected, rel=1e-5)
    assert found.focus_m == pytest.approx(expected, rel=1e-3)
    with pytest.raises(InputError, match="eye tracker"):
        renderer.render(frame(1, head, None), 0.0)
    renderer.release()
