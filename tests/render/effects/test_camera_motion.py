"""Motion blur's previous eye: what each mode cancels, to the last digit."""

from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.motion import velocity_px
from vrcomfort.geometry import (
    Fov,
    Pose,
    axis_angle,
    clip_from_view,
    focal_length_px,
    quaternion_multiply,
    rotate,
)
from vrcomfort.protocol.conditions import MotionBlur, Neck
from vrcomfort.render.camera import (
    camera_motion,
    extrapolated_eye_pose,
    hand_poses,
    previous_eye_pose,
    turned_like,
)

SIZE_PX = (640, 800)
FOV = Fov.symmetric(vertical_rad=1.6, aspect=0.8)
CLIP_FROM_VIEW = clip_from_view(FOV, 0.02)

few = settings(max_examples=25)
"""Enough for laws that hold everywhere, to the last digit."""

coordinate = st.floats(-50, 50)
position = st.tuples(coordinate, st.floats(-3, 3), coordinate).map(np.array)
axis = position.filter(lambda v: np.linalg.norm(v) > 0.1)
turn = st.builds(axis_angle, axis, st.floats(0, np.pi / 2))
pose = st.builds(Pose, position, turn)
eye = st.builds(
    Pose, st.tuples(st.floats(-0.04, 0.04), st.just(0.0), st.floats(-0.1, 0.1)).map(np.array), turn
)
depth_m = st.floats(0.05, 30_000)


def clip_positions(now, before, points_m, dtype=np.float64):
    """Return present and previous clip positions, the way the vertex shader computes them."""
    motion = camera_motion([now], [before])
    if dtype == np.float64:
        delta = now.position - before.position
        rotations = [p.inverse().matrix()[:3, :3] for p in (now, before)]
    else:
        rotations, delta = [each[0] for each in motion[:2]], motion.eye_delta_m[0]
    relative = (points_m - now.position).astype(dtype)
    projection = CLIP_FROM_VIEW.astype(dtype)

    def project(rotation, x):
        view = np.append(rotation.astype(dtype) @ x, dtype(1))
        return projection @ view

    return project(rotations[0], relative), project(rotations[1], relative + delta.astype(dtype))


def velocity(now, before, distance_m, dtype=np.float64, tangent=(0.3, -0.4)):
    point = now.position + distance_m * rotate(now.orientation, [*tangent, -1.0])
    clip_now, clip_before = clip_positions(now, before, point, dtype)
    return velocity_px(clip_now, clip_before, SIZE_PX)


def eyes(mode, world_from_stage, heads, head_from_eye, previous_world_from_stage=None, **settings):
    previous = previous_eye_pose(
        mode,
        world_from_stage=world_from_stage,
        stage_from_head=heads[1],
        head_from_eye=head_from_eye,
        previous_world_from_stage=previous_world_from_stage or world_from_stage,
        previous_stage_from_head=heads[0],
        **settings,
    )
    return world_from_stage @ heads[1] @ head_from_eye, previous


@few
@given(pose, pose, turn, eye, depth_m)
def test_head_rotation_is_cancelled_at_every_depth(avatar, head, rotation, head_from_eye, distance):
    before = Pose(head.position, quaternion_multiply(rotation, head.orientation))
    now, previous = eyes("rotation_cancelled", avatar, (before, head), head_from_eye)
    assert previous == now
    for dtype in (np.float64, np.float32):
        assert np.all(velocity(now, previous, distance, dtype) == 0)


@few
@given(pose, pose, position, turn, eye)
def test_rotation_cancelled_keeps_translation(avatar, head, step, rotation, head_from_eye):
    step = step / 100
    turned = Pose(head.position - step, quaternion_multiply(rotation, head.orientation))
    now, previous = eyes("rotation_cancelled", avatar, (turned, head), head_from_eye)
    np.testing.assert_allclose(
        now.position - previous.position, rotate(avatar.orientation, step), atol=1e-12
    )
    np.testing.assert_array_equal(now.orientation, previous.orientation)


@few
@given(pose, position, st.floats(0.3, 1000), eye)
def test_translation_is_the_projected_difference(head, step, distance, head_from_eye):
    """Float32 on the GPU stays within max(0.01 px, 1e-5 |v|) of float64."""
    before = Pose(head.position - step / 500, head.orientation)
    now, previous = eyes("rotation_cancelled", Pose(), (before, head), head_from_eye)
    exact = velocity(now, previous, distance)
    single = velocity(now, previous, distance, np.float32)
    tolerance = max(0.01, 1e-5 * float(np.linalg.norm(exact)))
    assert np.linalg.norm(single - exact) <= tolerance


@pytest.mark.slow
@few
@given(pose, pose, pose, pose, eye)
def test_head_cancelled_keeps_locomotion_only(avatar, avatar_before, head, head_before, offset):
    now, previous = eyes("head_cancelled", avatar, (head_before, head), offset, avatar_before)
    assert previous == avatar_before @ head @ offset
    if avatar == avatar_before:
        assert previous == now


@few
@given(pose, pose, eye, position)
def test_a_head_locked_point_never_moves(avatar, head, offset, point):
    """In head space both eyes are the same eye, so its velocity is zero under any motion."""
    now = avatar @ head @ offset
    motion = camera_motion([now], [now])
    assert np.all(motion.eye_delta_m == 0)
    assert np.array_equal(motion.view_from_world, motion.previous_view_from_world)
    assert np.all(velocity(now, now, 1.0 + np.linalg.norm(point), np.float32) == 0)


def test_the_per_eye_form_leaves_the_lever_arm():
    """The 2020 text's own form: 20 px at 0.5 m for 90 degrees, where the focal length is 320 px.

    The left eye, 31.5 mm from the head's centre, was as far behind it and is now beside it.
    """
    heads = (Pose(orientation=axis_angle([0, 1, 0], np.pi / 2)), Pose())
    left = Pose(np.array([-0.0315, 0, 0]))
    now, previous = eyes("rotation_cancelled_eye", Pose(), heads, left)
    focal_px = focal_length_px(FOV, SIZE_PX)[0]
    found = velocity(now, previous, 0.5, tangent=(0.0, 0.0)) * 320 / focal_px
    assert found[0] == pytest.approx(320 * 0.0315 / (0.5 + 0.0315), abs=1e-3)
    assert abs(found[0]) == pytest.approx(20, abs=1.1)
    assert np.all(velocity(*eyes("rotation_cancelled", Pose(), heads, left), 0.5) == 0)


@few
@given(pose, pose, pose, pose, eye)
def test_objects_only_ignores_every_camera(avatar, avatar_before, head, head_before, offset):
    now, previous = eyes("objects_only", avatar, (head_before, head), offset, avatar_before)
    assert previous == now


necks = st.builds(Neck, behind_m=st.floats(0, 0.3), below_m=st.floats(0, 0.3))


def nodded(head, neck, rotation):
    """Return where a head was before it turned about its neck."""
    head_from_neck = Pose(np.array([0.0, -neck.below_m, neck.behind_m]))
    turned = Pose(orientation=quaternion_multiply(rotation, head.orientation))
    place = (head @ head_from_neck).position - (turned @ head_from_neck).position
    return Pose(place, turned.orientation)


@few
@given(pose, pose, turn, eye, depth_m, necks)
def test_head_rotation_about_the_neck_is_cancelled_at_every_depth(
    avatar, head, rotation, head_from_eye, distance, neck
):
    heads = nodded(head, neck, rotation), head
    now, previous = eyes("rotation_cancelled", avatar, heads, head_from_eye, neck=neck)
    assert np.linalg.norm(velocity(now, previous, distance, np.float32)) <= 1e-3


@few
@given(pose, pose, position, turn, eye, necks)
def test_a_neck_that_moves_blurs_as_far_as_it_moves(
    avatar, head, step, rotation, head_from_eye, neck
):
    step = step / 100
    before = nodded(head, neck, rotation)
    moved = Pose(before.position - step, before.orientation)
    now, previous = eyes("rotation_cancelled", avatar, (moved, head), head_from_eye, neck=neck)
    np.testing.assert_allclose(
        now.position - previous.position, rotate(avatar.orientation, step), atol=1e-12
    )


def test_a_neck_takes_the_streak_of_a_turn_from_near_things():
    """200 degrees per second at 90 Hz: 2.5 px, 0.5 m away, at a focal length of 320 px."""
    neck = Neck(behind_m=0.1)
    rotation = axis_angle([0, 1, 0], np.radians(200 / 90))
    heads = nodded(Pose(), neck, rotation), Pose()
    found = {}
    for name, pivot in (("head", None), ("neck", neck)):
        now, previous = eyes("rotation_cancelled", Pose(), heads, Pose(), neck=pivot)
        moved_px = velocity(now, previous, 0.5, tangent=(0.0, 0.0))[0]
        found[name] = abs(moved_px) * 320 / focal_length_px(FOV, SIZE_PX)[0]
    assert found["head"] == pytest.approx(320 * 0.1 * np.radians(200 / 90) / 0.5, rel=0.01)
    assert found["neck"] == pytest.approx(0, abs=1e-9)


modes = st.sampled_from(get_args(MotionBlur.model_fields["mode"].annotation))


def turned_by(avatar, angle_rad, head):
    """Return the avatar before it was turned about the place below a head."""
    feet = avatar @ Pose(head.position * [1, 0, 1])
    turn = Pose(orientation=axis_angle([0, 1, 0], -angle_rad))
    return Pose(feet.position) @ turn @ Pose(-feet.position) @ avatar


upright = st.builds(
    Pose, position, st.floats(-3, 3).map(lambda angle: axis_angle([0, 1, 0], angle))
)
virtual_turn_rad = st.floats(0.01, np.pi / 2)


@few
@given(modes, upright, pose, eye, virtual_turn_rad, depth_m)
def test_virtual_turning_is_cancelled_in_every_mode(
    mode, avatar, head, head_from_eye, angle, distance
):
    before = turned_by(avatar, angle, head)
    now, previous = eyes(
        mode, avatar, (head, head), head_from_eye, before, virtual_turning="cancelled"
    )
    np.testing.assert_allclose(previous.position, now.position, atol=1e-12)
    assert np.linalg.norm(velocity(now, previous, distance, np.float32)) <= 1e-3


@few
@given(modes, upright, st.tuples(pose, pose), eye, position)
def test_cancelled_turning_keeps_all_other_motion(mode, avatar, heads, offset, step):
    """Walking without a turn, and whatever the mode keeps of the head."""
    before = Pose(avatar.position - step / 100, avatar.orientation)
    as_ever = eyes(mode, avatar, heads, offset, before)
    assert eyes(mode, avatar, heads, offset, before, virtual_turning="cancelled") == as_ever


@few
@given(modes, upright, pose, eye, virtual_turn_rad)
def test_virtual_turning_is_kept_in_every_mode(mode, avatar, head, head_from_eye, angle):
    before = turned_by(avatar, angle, head)
    _, previous = eyes(mode, avatar, (head, head), head_from_eye, before, virtual_turning="kept")
    seen = before @ head @ head_from_eye
    np.testing.assert_allclose(previous.matrix(), seen.matrix(), atol=1e-9)


def test_objects_only_with_turning_kept_does_not_blur_walking():
    walked = Pose(np.array([0.0, 0.0, 0.02]))
    heads = Pose(np.array([0.0, 1.6, 0.0])), Pose(np.array([0.0, 1.6, -0.01]))
    now, previous = eyes("objects_only", Pose(), heads, Pose(), walked, virtual_turning="kept")
    assert previous == now


def test_two_degrees_of_virtual_turning_at_three_metres():
    """Kept, they move the image by 11.2 px at a focal length of 320 px; cancelled, by none."""
    head = Pose(np.array([0.0, 1.6, 0.0]))
    before = turned_by(Pose(), np.radians(2), head)
    moved_px = []
    for turning in ("kept", "cancelled"):
        now, previous = eyes(
            "rotation_cancelled", Pose(), (head, head), Pose(), before, virtual_turning=turning
        )
        found = velocity(now, previous, 3.0, tangent=(0.0, 0.0))
        moved_px.append(abs(found[0]) * 320 / focal_length_px(FOV, SIZE_PX)[0])
    assert moved_px == pytest.approx([320 * np.tan(np.radians(2)), 0], abs=1e-3)


def counted_hands(carried, stages, heads, hands):
    return hand_poses(
        carried,
        world_from_stage=stages[1],
        stage_from_head=heads[1],
        stage_from_hands=hands[1],
        previous_world_from_stage=stages[0],
        previous_stage_from_head=heads[0],
        previous_stage_from_hands=hands[0],
    )


@pytest.mark.slow
@few
@given(st.tuples(upright, upright), st.tuples(pose, pose), eye)
def test_a_hand_that_goes_with_the_head_has_moved_in_the_world_alone(stages, heads, head_from_hand):
    hands = [(head @ head_from_hand, None) for head in heads]
    now, before = counted_hands("with_head", stages, heads, hands)
    np.testing.assert_allclose(before.left.matrix(), now.left.matrix(), atol=1e-9)
    now, before = counted_hands("in_world", stages, heads, hands)
    assert now.left == stages[1] @ hands[1][0]
    assert before.left == stages[0] @ hands[0][0]
    assert now.right is None
    assert before.right is None


@few
@given(upright, pose, st.tuples(pose, pose))
def test_before_a_resting_head_both_ways_of_counting_a_hand_agree(stage, head, places):
    hands = [(None, place) for place in places]
    for carried in ("with_head", "in_world"):
        _, before = counted_hands(carried, (stage, stage), (head, head), hands)
        expected = (stage @ places[0]).matrix()
        np.testing.assert_allclose(before.right.matrix(), expected, atol=1e-9)


@few
@given(st.sampled_from(["with_head", "in_world"]), upright, st.tuples(pose, pose), pose)
def test_a_hand_that_rests_or_was_not_known_has_not_moved(carried, stage, heads, hand):
    rest = counted_hands(carried, (stage, stage), (heads[1], heads[1]), [(hand, None)] * 2)
    assert rest[0] == rest[1], "bit by bit: nothing is drawn for a picture in which all rests"
    found = counted_hands(carried, (stage, stage), heads, [(None, None), (hand, None)])
    assert found[0] == found[1]


@few
@given(upright, upright, pose)
def test_a_stage_turned_like_another_leaves_the_head_in_its_place(stage, other, head):
    found = turned_like(stage, other, head)
    assert np.array_equal(found.orientation, other.orientation)
    np.testing.assert_allclose(
        (found @ head).position, (stage @ head).position, atol=1e-12, rtol=1e-14
    )
    assert turned_like(stage, stage, head) == stage


@few
@given(turn, turn, eye, st.integers(-1, 1), st.floats(0.05, 100))
def test_a_runtimes_rounded_positions_leave_hundredths_of_a_pixel(
    orientation, rotation, offset, ulps, distance
):
    """Float32 positions 30 m from the origin jitter by 2 um: 0.03 px at 5 cm, focal 400 px."""
    place = np.float32([30, 1.6, -30])
    moved = place + ulps * np.spacing(place)
    heads = (
        Pose(moved.astype(float), quaternion_multiply(rotation, orientation)),
        Pose(place.astype(float), orientation),
    )
    found = velocity(*eyes("rotation_cancelled", Pose(), heads, offset), distance, np.float32)
    assert np.linalg.norm(found) <= 0.06 * 0.05 / distance + 1e-4


@few
@given(pose, pose)
def test_extrapolation_passes_through_both_poses(now, before):
    for frames, expected in ((0.0, now), (-1.0, before)):
        found = extrapolated_eye_pose(now, before, frames)
        np.testing.assert_allclose(found.matrix(), expected.matrix(), atol=1e-9)
