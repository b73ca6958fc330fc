"""Geometry: group laws, projections and interpolation, against matrices and by hand."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.geometry import (
    Fov,
    Pose,
    axis_angle,
    clip_from_view,
    focal_length_px,
    interpolate_pose,
    normalize,
    principal_point_px,
    quaternion_multiply,
    rotate,
    rotation_matrix,
    slerp,
    yaw_pitch_roll,
)

metres = st.floats(-1e4, 1e4)
vectors = st.tuples(metres, metres, metres).map(np.array)
component = st.floats(-1, 1)
quaternions = (
    st.tuples(component, component, component, component)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(normalize)
)
poses = st.builds(Pose, vectors, quaternions)


@given(quaternions, quaternions, vectors)
def test_quaternion_product_is_composition_of_rotations(a, b, v):
    expected = rotation_matrix(a) @ rotation_matrix(b) @ v
    np.testing.assert_allclose(rotate(quaternion_multiply(a, b), v), expected, atol=1e-9 * 1e4)


@given(quaternions)
def test_rotation_matrix_is_orthonormal_and_right_handed(q):
    matrix = rotation_matrix(q)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(matrix) == pytest.approx(1)


@given(poses, poses)
def test_pose_composition_is_matrix_product(a, b):
    np.testing.assert_allclose((a @ b).matrix(), a.matrix() @ b.matrix(), atol=1e-8)


@given(poses)
def test_inverse_undoes_the_pose(pose):
    np.testing.assert_allclose((pose @ pose.inverse()).matrix(), np.eye(4), atol=1e-8)


def test_head_turns_left_then_up_then_rolls():
    left = yaw_pitch_roll(np.pi / 2, 0, 0)
    np.testing.assert_allclose(rotate(left, [0, 0, -1]), [-1, 0, 0], atol=1e-15)
    left_and_up = yaw_pitch_roll(np.pi / 2, np.pi / 4, 0)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(rotate(left_and_up, [0, 0, -1]), [-half, half, 0], atol=1e-15)
    rolled = yaw_pitch_roll(0, 0, np.pi / 2)
    np.testing.assert_allclose(rotate(rolled, [0, 1, 0]), [-1, 0, 0], atol=1e-15)


@given(quaternions, quaternions, st.floats(0, 1))
def test_slerp_turns_at_constant_speed_along_the_shorter_arc(a, b, t):
    whole = _angle_between(a, b)
    assert _angle_between(a, slerp(a, b, t)) == pytest.approx(t * whole, abs=1e-6)
    assert whole <= np.pi + 1e-9


@given(quaternions, quaternions, st.floats(-0.5, 1.5))
def test_one_slerp_in_plain_numbers_is_that_of_arrays(a, b, t):
    (many,) = slerp(a[None], b[None], np.array([t]))
    np.testing.assert_allclose(slerp(a, b, t), many, atol=1e-9)


@given(vectors, quaternions, st.floats(0.5, 2.0))
def test_a_pose_from_plain_numbers_is_the_pose(position, orientation, length):
    pose = Pose.of(position.tolist(), (length * orientation).tolist())
    np.testing.assert_array_equal(pose.position, position)
    np.testing.assert_allclose(pose.orientation, orientation, atol=1e-15)
    with pytest.raises(ValueError, match="read-only"):
        pose.position[0] = 1.0


def test_slerp_extrapolates():
    a, b = axis_angle([0, 1, 0], 0.0), axis_angle([0, 1, 0], 0.2)
    np.testing.assert_allclose(slerp(a, b, 1.5), axis_angle([0, 1, 0], 0.3), atol=1e-15)


@given(poses, poses)
def test_interpolated_pose_meets_both_ends(a, b):
    for t, end in ((0.0, a), (1.0, b)):
        pose = interpolate_pose(a, b, t)
        np.testing.assert_allclose(pose.position, end.position, atol=1e-9 * 1e4)
        assert _angle_between(pose.orientation, end.orientation) == pytest.approx(0, abs=1e-6)


def test_reverse_z_depth_is_near_over_distance():
    clip = clip_from_view(Fov(-0.7, 0.6, 0.8, -0.9), 0.05)
    for distance, depth in ((0.05, 1.0), (1.0, 0.05), (30_000.0, 0.05 / 30_000)):
        _, _, z, w = clip @ [0.1, 0.2, -distance, 1]
        assert z / w == pytest.approx(depth, rel=1e-15)
    direction_at_infinity = clip @ [0, 0, -1, 0]
    assert direction_at_infinity[2] == 0


def test_asymmetric_frustum_maps_its_edges_to_the_clip_edges():
    fov = Fov(-0.7, 0.6, 0.8, -0.9)
    clip = clip_from_view(fov, 0.05)
    left, right, up, down = fov.tangents
    for tangent, row, edge in ((left, 0, -1), (right, 0, 1), (up, 1, 1), (down, 1, -1)):
        point = np.array([0.0, 0.0, -1.0, 1.0])
        point[row] = tangent
        projected = clip @ point
        assert projected[row] / projected[3] == pytest.approx(edge)


def test_focal_length_and_principal_point_of_a_symmetric_view():
    fov = Fov.symmetric(vertical_rad=np.pi / 2, aspect=640 / 800)
    assert focal_length_px(fov, (640, 800)) == pytest.approx((400, 400))
    assert principal_point_px(fov, (640, 800)) == pytest.approx((320, 400))


def test_poses_cannot_be_changed_in_place():
    pose = Pose()
    for array in (pose.position, pose.orientation, pose.rotation):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(AttributeError, match="a pose never changes"):
        pose.position = np.ones(3)
    assert pose == Pose()


@given(poses, poses)
def test_poses_are_equal_where_their_numbers_are(a, b):
    assert pickle.loads(pickle.dumps(a)) == a  # noqa: S301 - what it has just written
    same = a.numbers == b.numbers
    assert (a == b) is same
    assert not same or hash(a) == hash(b)
    assert a.numbers == (*a.position.tolist(), *a.orientation.tolist())
    turned = a.turned_as(b)
    assert np.array_equal(turned.position, a.position)
    assert np.array_equal(turned.orientation, b.orientation)
    np.testing.assert_allclose(turned.rotation @ [0, 0, -1], b.forward, atol=1e-12)


def _angle_between(a, b):
    b = b if np.dot(a, b) >= 0 else -b
    return 4 * np.arctan2(np.linalg.norm(a - b) / 2, np.linalg.norm(a + b) / 2)
