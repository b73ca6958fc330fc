import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.render import clips_of
from vrcomfort.geometry import Fov, Pose, normalize
from vrcomfort.render import culling
from vrcomfort.render.camera import EyeCamera

coordinate = st.floats(-50, 50)
vector = st.tuples(coordinate, coordinate, coordinate)
part = st.floats(-1, 1)


def box(center, half):
    return culling.boxes(np.array([center]), np.array([half]))


@settings(max_examples=200, deadline=None)
@given(
    quaternion=st.tuples(part, part, part, part).filter(lambda q: np.linalg.norm(q) > 0.1),
    center=vector,
    half=st.tuples(*[st.floats(0, 5)] * 3),
    inside=st.tuples(part, part, part),
)
def test_a_box_with_a_point_in_view_is_never_dropped(quaternion, center, half, inside):
    camera = EyeCamera(Pose((0, 0, 0), normalize(quaternion)), Fov(-0.9, 0.6, 0.5, -0.7))
    (matrix,) = clips_of(camera)
    x, y, z, w = matrix @ np.append(np.array(center) + np.array(half) * inside, 1.0)
    in_view = w > 0 and max(abs(x), abs(y)) <= w and z <= w
    kept = culling.visible(culling.planes(matrix), box(center, half))[0]
    assert kept or not in_view


def test_boxes_behind_and_beside_are_dropped():
    planes = culling.planes(clips_of(EyeCamera(Pose(), Fov(-0.5, 0.5, 0.5, -0.5)))[0])
    centers = np.array([[0, 0, -5.0], [0, 0, 5.0], [9, 0, -5.0], [0, 0, -1e6]])
    kept = culling.visible(planes, culling.boxes(centers, np.full((4, 3), 0.5)))
    assert kept.tolist() == [True, False, False, True]


def test_several_frusta_at_once_see_what_each_sees():
    turns = [normalize(q) for q in np.random.default_rng(5).normal(size=(9, 4))]
    cameras = [EyeCamera(Pose((0, 0, 0), q), Fov(-0.9, 0.6, 0.5, -0.7)) for q in turns]
    planes = [culling.planes(clip) for clip in clips_of(*cameras)]
    boxes = np.random.default_rng(6).normal(size=(2, 200, 3))
    boxes = culling.boxes(5 * boxes[0], np.abs(boxes[1]))
    together = culling.visible(np.array(planes), boxes)
    assert np.array_equal(together, [culling.visible(each, boxes) for each in planes])
    assert 0 < together.mean() < 1


def test_frusta_around_other_points_see_what_they_see_of_boxes_from_there():
    rng = np.random.default_rng(7)
    clips = clips_of(*[EyeCamera(Pose(), Fov(-0.9, 0.6, 0.5, -0.7))] * 3)
    centers, halves, origins = (
        rng.normal(size=(200, 3)) * 5,
        rng.random((200, 3)),
        rng.normal(size=(3, 3)),
    )
    planes = culling.planes(clips)
    found = culling.visible(culling.from_origins(planes, origins), culling.boxes(centers, halves))
    for plane, origin, seen in zip(planes, origins, found, strict=True):
        assert np.array_equal(seen, culling.visible(plane, culling.boxes(centers - origin, halves)))
    assert not np.array_equal(found[0], found[1])


@given(center=vector, half=st.tuples(*[st.floats(0, 5)] * 3), inside=st.tuples(part, part, part))
def test_a_transformed_box_holds_the_transformed_points(center, half, inside):
    matrix = np.random.default_rng(3).normal(size=(1, 4, 4))
    moved, reach = culling.transformed_boxes(matrix, np.array([center]), np.array([half]))
    point = matrix[0, :3, :3] @ (np.array(center) + np.array(half) * inside) + matrix[0, :3, 3]
    assert np.all(np.abs(point - moved[0]) <= reach[0] + 1e-9)
