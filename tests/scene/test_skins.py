"""Skinned meshes: where joints put vertices, what is drawn of them, and how fast it moves."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.support.render import clips_of, eye
from tests.support.scene_files import Gltf
from vrcomfort.errors import InputError
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.gpu import gl
from vrcomfort.render.camera import PreviousCamera
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.output import read_depth, read_linear, read_texture
from vrcomfort.render.scene_pass import ScenePass
from vrcomfort.scene.data import Environment, Node
from vrcomfort.scene.load import load_scene
from vrcomfort.scene.node_poses import NodePoses

SIZE = (64, 64)
QUARTER_TURN = axis_angle([0.0, 0.0, 1.0], np.pi / 2).tolist()
ROWS = 5
"""The arm has so many pairs of vertices, half a metre apart, from y = 0 to y = 2."""


def arm(
    path,
    *,
    keys,
    kind="rotation",
    attributes=None,
    skin=None,
    mesh_node=None,
    root=None,
    bind_scale=1.0,
):
    """Write an arm from (0, 0, −3) up, whose elbow at y = 1 turns or moves by key frames.

    The lower vertices follow the shoulder, the upper ones the elbow, the middle ones both.
    """
    file = Gltf()
    y = np.repeat(np.linspace(0, 2, ROWS), 2)
    x = np.tile([-0.25, 0.25], ROWS)
    upper = np.clip(y - 0.5, 0, 1)
    weights = np.stack([1 - upper, upper, 0 * y, 0 * y], axis=1)
    quads = [[2 * i, 2 * i + 1, 2 * i + 3, 2 * i, 2 * i + 3, 2 * i + 2] for i in range(ROWS - 1)]
    bind = np.tile(np.diag([bind_scale] * 3 + [1.0]), (2, 1, 1))
    bind[1, 1, 3] = -1.0  # joint-from-bind of the elbow
    primitive = {
        "attributes": {
            "POSITION": file.accessor(np.stack([x, y, 0 * y], axis=1)),
            "NORMAL": file.accessor(np.tile([0, 0, 1], (2 * ROWS, 1))),
            "JOINTS_0": file.accessor(np.tile([0, 1, 7, 7], (2 * ROWS, 1)), "uint8"),
            "WEIGHTS_0": file.accessor(weights),
            **(attributes or (lambda _: {}))(file),
        },
        "indices": file.accessor(np.ravel(quads), "uint8"),
    }
    matrices = file.accessor(bind.swapaxes(1, 2).reshape(2, 16))
    times, values = file.accessor(np.arange(len(keys), dtype=float)), file.accessor(keys)
    file.save(
        path,
        meshes=[{"primitives": [primitive]}],
        nodes=[
            {"name": "shoulder", "translation": [0, 0, -3], "children": [1], **(root or {})},
            {"name": "elbow", "translation": [0, 1, 0]},
            {"name": "arm", "mesh": 0, "skin": 0, **(mesh_node or {})},
        ],
        scenes=[{"nodes": [2, 0]}],
        skins=[{"joints": [0, 1], "inverseBindMatrices": matrices, **(skin or {})}],
        materials=[],
        animations=[
            {
                "samplers": [{"input": times, "output": values}],
                "channels": [{"sampler": 0, "target": {"node": 1, "path": kind}}],
            }
        ],
    )
    return path


def weights(each):
    """Return what gives every vertex the same weights."""
    return lambda file: {"WEIGHTS_0": file.accessor(np.tile(each, (2 * ROWS, 1)))}


TURNS = [[0, 0, 0, 1], QUARTER_TURN]


def arm_node(scene):
    return next(index for index, node in enumerate(scene.nodes) if node.skin is not None)


def world_positions(scene, time_s):
    """Return the (10, 3) places of the arm's vertices."""
    node = arm_node(scene)
    place = scene.world_from_node(time_s)[node]
    return scene.positions(node, 0, time_s) @ place[:3, :3].T + place[:3, 3]


def test_joints_put_vertices_where_their_weights_say(tmp_path):
    scene = load_scene(arm(tmp_path / "a.gltf", keys=TURNS))
    assert scene.warnings == ()
    found = world_positions(scene, 1.0 - 1e-12)
    # The elbow is at (0, 1, −3) and turns what is above it to the left: (x, 1 + h) to (−h, 1 + x).
    np.testing.assert_allclose(found[:2], [[-0.25, 0, -3], [0.25, 0, -3]], atol=1e-6)
    np.testing.assert_allclose(found[-2:], [[-1, 0.75, -3], [-1, 1.25, -3]], atol=1e-6)
    halfway = [([-0.25, 1, -3], [0, 0.75, -3]), ([0.25, 1, -3], [0, 1.25, -3])]
    np.testing.assert_allclose(found[4:6], np.mean(halfway, axis=1), atol=1e-6)


def test_where_the_skinned_node_is_does_not_matter(tmp_path):
    plain = load_scene(arm(tmp_path / "a.gltf", keys=TURNS))
    moved = {"translation": [5, 6, 7], "scale": [2, -1, 0], "rotation": QUARTER_TURN}
    other = load_scene(arm(tmp_path / "b.gltf", keys=TURNS, mesh_node=moved))
    np.testing.assert_array_equal(world_positions(plain, 0.4), world_positions(other, 0.4))


def test_weights_are_made_to_add_up_and_joints_without_weight_do_not_count(tmp_path):
    scene = load_scene(arm(tmp_path / "a.gltf", keys=TURNS, attributes=weights([2, 2, 0, 0])))
    bending = scene.primitives[0].bending
    np.testing.assert_array_equal(bending.weights, np.tile([0.5, 0.5, 0, 0], (2 * ROWS, 1)))
    assert bending.joints.max() == 1


def posed(scene, time_s):
    """Return the scene without skins: its vertices are where NumPy bends them."""
    node = arm_node(scene)
    primitive = scene.primitives[0]
    matrices = scene.all_skins.place_from_bind(scene.world_from_joint(time_s))
    blended = np.einsum(
        "nk,nkij->nij", primitive.bending.weights, matrices[primitive.bending.joints]
    )
    normals = np.einsum(
        "nij,nj->ni", np.linalg.inv(blended[:, :3, :3]).swapaxes(1, 2), primitive.normals
    )
    rigid = replace(
        primitive,
        positions=scene.positions(node, 0, time_s).astype(np.float32),
        normals=(normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32),
        bending=None,
    )
    nodes = (Node("arm", translation=scene.world_from_node(time_s)[node, :3, 3], mesh=(0,)),)
    return replace(scene, nodes=nodes, primitives=(rigid,), skins=(), animations=())


SUN = Environment(shadow_distance_m=10.0)


def drawn(ctx, scene, time_s, camera, **settings):
    scene_pass = ScenePass(ctx, replace(scene, environment=SUN), SIZE, velocity=False, **settings)
    scene_pass.render(camera, time_s)
    return read_linear(scene_pass.colour), read_depth(scene_pass.depth)


@pytest.mark.parametrize("far_m", [0.0, 20_000.0])
def test_what_is_drawn_is_what_numpy_bends(ctx, tmp_path, far_m):
    """Colour (normals, sun and shadow) and depth; and as exactly far from the origin."""
    turns = [[0, 0, 0, 1], axis_angle([1.0, 1.0, 0.0], 1.2).tolist()]
    root = {"translation": [far_m, 0, -3], "scale": [1, 1.2, 1]}
    scene = load_scene(arm(tmp_path / "a.gltf", keys=turns, root=root))
    camera = eye((far_m, 1.0, 0.0))
    colour, depth = drawn(ctx, scene, 0.7, camera)
    rigid_colour, rigid_depth = drawn(ctx, posed(scene, 0.7), 0.0, camera)
    assert ((depth > 0) & (depth < 1)).mean() > 0.02
    same = np.isclose(depth, rigid_depth, rtol=1e-5)
    assert same.mean() > 0.998, "but for pixels at an edge"
    np.testing.assert_allclose(colour[same], rigid_colour[same], atol=0.02)
    assert np.abs(colour - rigid_colour).mean() < 1e-3


def depth_alone(ctx, scene, time_s, camera):
    """Return the depth that shadows and focus go by, and the number of draws for it."""
    gpu = GpuScene(ctx, scene)
    depth = gl.depth_texture(ctx, SIZE)
    target = ctx.framebuffer([], depth)
    target.use()
    target.clear(depth=0.0)
    ctx.enable_only(ctx.DEPTH_TEST)
    ctx.depth_func = gl.DEPTH_FUNC
    gpu.update(time_s, Pose())
    count = gpu.draw_depth(clips_of(camera), camera.world_from_eye.position)
    return read_depth(depth), count


def test_depth_alone_is_bent_as_well(ctx, tmp_path):
    scene = load_scene(arm(tmp_path / "a.gltf", keys=TURNS))
    camera = eye((0, 1, 0))
    found, _ = depth_alone(ctx, scene, 0.6, camera)
    expected, _ = depth_alone(ctx, posed(scene, 0.6), 0.0, camera)
    assert np.isclose(found, expected, rtol=1e-5).mean() > 0.998, "but for pixels at an edge"
    assert (found > 0).mean() > 0.02


def test_a_mesh_that_joints_carry_out_of_its_own_box_is_still_seen(ctx, tmp_path):
    aside = [[0, 1, 0], [40, 1, 0]]
    scene = load_scene(arm(tmp_path / "a.gltf", keys=aside, kind="translation"))
    _, depth = drawn(ctx, scene, 1.0 - 1e-9, eye((40, 1.5, 0)))
    assert (depth > 0).any()


def test_what_joints_have_carried_away_is_not_drawn(ctx, tmp_path):
    aside = [[0, 1, 0], [40, 1, 0]]
    elbow_alone = weights([0, 1, 0, 0])
    scene = load_scene(
        arm(tmp_path / "a.gltf", keys=aside, kind="translation", attributes=elbow_alone)
    )
    counts = [depth_alone(ctx, scene, time_s, eye((0, 1, 0)))[1] for time_s in (0.0, 1.0 - 1e-9)]
    assert counts == [1, 0]


def test_velocity_is_that_of_bent_vertices_now_and_a_frame_ago(ctx, tmp_path):
    """The elbow slides by 0.5 m/s; what only it bends moves as a rigid thing would."""
    keys = [[0, 1, 0], [0.5, 1, 0]]
    elbow_alone = weights([0, 1, 0, 0])
    scene = load_scene(
        arm(tmp_path / "a.gltf", keys=keys, kind="translation", attributes=elbow_alone)
    )
    scene_pass = ScenePass(ctx, scene, SIZE, velocity=True, velocity_dtype="f4")
    camera, step_s = eye((0, 1, 0)), 0.1
    scene_pass.render(camera, 0.5, PreviousCamera(camera.world_from_eye, 0.4))
    velocity = read_texture(scene_pass.velocity)
    covered = read_depth(scene_pass.depth) > 0
    # 32 px for a tangent of 1: 0.05 m at 3 m.
    expected_px = 0.5 * step_s / 3 * 32
    inside = covered & (np.abs(velocity[..., 0]) > 0)
    assert inside.sum() > 50
    np.testing.assert_allclose(velocity[inside], [[expected_px, 0.0]] * inside.sum(), atol=2e-4)


def test_velocity_of_a_turning_elbow_is_the_difference_of_projections(ctx, tmp_path):
    scene = load_scene(arm(tmp_path / "a.gltf", keys=TURNS))
    scene_pass = ScenePass(ctx, scene, SIZE, velocity=True, samples=1, velocity_dtype="f4")
    camera = eye((0, 1, 0))
    scene_pass.render(camera, 0.5, PreviousCamera(camera.world_from_eye, 0.45))
    velocity = read_texture(scene_pass.velocity)
    tip = [world_positions(scene, time_s)[-2:].mean(axis=0) for time_s in (0.5, 0.45)]
    elbow = world_positions(scene, 0.5)[4:6].mean(axis=0)
    pixels = [32 * (place[:2] - [0, 1]) / 3 for place in tip]
    # A little inside the tip, where all vertices around follow the elbow alone.
    inner = 0.9 * tip[0] + 0.1 * elbow
    before = 0.9 * tip[1] + 0.1 * world_positions(scene, 0.45)[4:6].mean(axis=0)
    column, row = np.floor(32 + 32 * (inner[:2] - [0, 1]) / 3).astype(int)
    expected = 32 * (inner - before)[:2] / 3
    np.testing.assert_allclose(velocity[63 - row, column], expected, atol=0.08)
    assert np.linalg.norm(pixels[0] - pixels[1]) > 0.5


def test_kept_poses_are_those_of_the_scene(tmp_path):
    scene = load_scene(arm(tmp_path / "a.gltf", keys=TURNS))
    poses = NodePoses(scene)
    for time_s in (0.0, 0.3, 0.8):
        world = poses.world_from_node(time_s, Pose())
        np.testing.assert_allclose(world, scene.world_from_node(time_s), atol=1e-12)
        expected = scene.all_skins.place_from_bind(scene.world_from_joint(time_s))
        np.testing.assert_allclose(poses.place_from_bind(time_s), expected, atol=1e-12)


def test_a_scene_is_looked_at_as_its_joints_bend_it(tmp_path):
    up = load_scene(arm(tmp_path / "a.gltf", keys=[[0, 0, 0, 1]] * 2))
    low = load_scene(arm(tmp_path / "b.gltf", keys=[QUARTER_TURN] * 2))
    assert low.spawn.position[0] < up.spawn.position[0] - 0.3


def test_a_scene_without_skins_has_no_joints_on_the_gpu(ctx, tmp_path):
    scene = load_scene(arm(tmp_path / "a.gltf", keys=TURNS))
    with_skin = len(GpuScene(ctx, scene)._list.keys[0].features)
    assert "SKIN" in GpuScene(ctx, scene)._list.keys[0].features
    rigid = GpuScene(ctx, posed(scene, 0.0))
    assert "SKIN" not in rigid._list.keys[0].features
    assert len(rigid._list.keys[0].features) == with_skin - 1


def joints(file, count=2 * ROWS, most=1, dtype="uint8"):
    return {"JOINTS_0": file.accessor(np.full((count, 4), most), dtype)}


BROKEN = {
    "JOINTS_1: 4 joints may bend": {"attributes": lambda f: {"JOINTS_1": joints(f)["JOINTS_0"]}},
    "has joint 2 of 2": {
        "attributes": lambda f: {**joints(f, most=2), "WEIGHTS_0": f.accessor(np.ones((10, 4)))}
    },
    "has 9 JOINTS_0 for 10 WEIGHTS_0": {"attributes": lambda f: joints(f, count=9)},
    "joints that are not unsigned whole numbers of 8 or 16": {
        "attributes": lambda f: joints(f, dtype="float32")
    },
    "weights are negative, or all 0": {
        "attributes": lambda f: {"WEIGHTS_0": f.accessor(np.zeros((10, 4)))}
    },
    r"brings the scene to 1025 joints, and 1024 is the most": {"skin": {"joints": [0] * 1025}},
    "has 2 inverse bind matrices for 3 joints": {"skin": {"joints": [0, 1, 0]}},
    r"skins\[0\]\.joints\[0\] refers to number 9": {"skin": {"joints": [9]}},
    r"skins\[0\]\.joints": {"skin": {"joints": []}},
    r"nodes\[2\] \('arm'\)\.skin refers to number 4": {"mesh_node": {"skin": 4}},
    "moves or scales its mesh by more than": {"root": {"scale": [1e6] * 3}, "bind_scale": 1e6},
}


@pytest.mark.parametrize("message", BROKEN)
def test_a_broken_skin_is_told(tmp_path, message):
    with pytest.raises(InputError, match=message) as caught:
        load_scene(arm(tmp_path / "a.gltf", keys=TURNS, **BROKEN[message]))
    assert caught.value.file == tmp_path / "a.gltf"


def test_a_skin_on_a_mesh_without_joints_is_told(tmp_path):
    file = Gltf()
    path = file.save(
        tmp_path / "a.gltf",
        meshes=[{"primitives": [file.triangle()]}],
        nodes=[{"mesh": 0, "skin": 0, "name": "body"}],
        skins=[{"joints": [0]}],
    )
    with pytest.raises(
        InputError, match="node 'body' has a skin, but a mesh of it has no JOINTS_0"
    ):
        load_scene(path)


def test_a_joint_outside_of_the_scene_is_told(tmp_path):
    file = Gltf()
    weights = file.accessor([[1, 0, 0, 0]] * 3)
    triangle = file.triangle(JOINTS_0=file.accessor([[0, 0, 0, 0]] * 3, "uint8"), WEIGHTS_0=weights)
    path = file.save(
        tmp_path / "a.gltf",
        meshes=[{"primitives": [triangle]}],
        nodes=[{"mesh": 0, "skin": 0}, {"name": "bone"}],
        scenes=[{"nodes": [0]}],
        skins=[{"joints": [1], "name": "rig"}],
    )
    with pytest.raises(InputError, match="skin 'rig' has a joint that is no node of the scene"):
        load_scene(path)


def test_what_no_skin_bends_may_have_leftovers_of_one(tmp_path):
    """Neither the skin of another scene nor weights that nothing uses are looked at."""
    file = arm(tmp_path / "a.gltf", keys=TURNS, attributes=weights([0, 0, 0, 0]))
    content = json.loads(file.read_text())
    del content["nodes"][2]["skin"]
    content["skins"][0]["joints"] = [0, 3]
    content["nodes"].append({"name": "of another scene"})
    file.write_text(json.dumps(content))
    assert all(node.skin is None for node in load_scene(file).nodes)


def test_a_skin_in_a_hand_on_a_mesh_that_is_not_is_refused(tmp_path):
    file = arm(tmp_path / "a.gltf", keys=TURNS)
    side_car = tmp_path / "a.toml"
    side_car.write_text('[nodes."shoulder"]\nhand = "right"\n')
    with pytest.raises(InputError, match="node 'arm' and the joints of its skin go with different"):
        load_scene(file)
    side_car.write_text('[nodes."*"]\nhand = "right"\n')
    assert load_scene(file).has_hands
