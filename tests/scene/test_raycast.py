"""The CPU's rays obey the renderer's rules."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.raycast import cast
from tests.support.scene_files import quad, scene_of
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.scene.animation import Animation, Channel
from vrcomfort.scene.data import Image, LodLevel, Material, Node
from vrcomfort.scene.load import load_scene

FORWARD = [[0.0, 0.0, -1.0]]


def ahead(scene, x=0.0, y=0.0, **kwargs):
    """Return the distance from (x, y, 5) along −Z."""
    return float(cast(scene, kwargs.pop("time_s", 0.0), [[x, y, 5.0]], FORWARD, **kwargs)[0])


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    path = tmp_path_factory.mktemp("ball") / "ball.glb"
    trimesh.Scene([trimesh.creation.icosphere(subdivisions=4, radius=2.0)]).export(path)
    return load_scene(path)


@given(st.floats(-1.5, 1.5), st.floats(-1.0, 1.0), st.floats(3.0, 50.0))
@settings(max_examples=30, deadline=None)
def test_a_ball_is_hit_where_it_is(ball, x, y, z):
    expected = z - np.sqrt(4 - x * x - y * y)
    assert cast(ball, 0.0, [[x, y, z]], FORWARD)[0] == pytest.approx(expected, abs=0.012)


def test_misses_are_infinite(ball):
    np.testing.assert_array_equal(
        cast(ball, 0.0, [[0, 0, 5], [9, 0, 5]], [[0, 0, 1], [0, 0, -1]]), [np.inf] * 2
    )


def test_direction_length_does_not_matter():
    scene = scene_of(Node("a", mesh=(0,)), primitives=(quad(),))
    np.testing.assert_allclose(
        cast(scene, 0.0, [[0, 0, 5]] * 2, [[0, 0, -1], [0, 0, -250.0]]), [5, 5]
    )


def test_single_sided_surfaces_are_seen_from_their_front_only():
    scene = scene_of(Node("a", mesh=(0,)), primitives=(quad(),))
    behind = ([[0, 0, -3]], [[0, 0, 1]])
    assert cast(scene, 0.0, *behind)[0] == np.inf
    both = replace(scene, materials=(Material(double_sided=True),))
    assert cast(both, 0.0, *behind)[0] == pytest.approx(3.0)


def test_a_mirroring_node_keeps_its_front():
    mirrored = Node("a", mesh=(0,), scale=np.array([-1.0, 1.0, 1.0]))
    assert ahead(scene_of(mirrored, primitives=(quad(),))) == pytest.approx(5.0)


def test_masks_let_rays_through_where_alpha_is_low():
    pixels = np.full((4, 4, 4), 255, np.uint8)
    pixels[:, :2, 3] = 0
    material = Material(base_color_image=0, alpha_mode="MASK", alpha_cutoff=0.5)
    scene = scene_of(Node("a", mesh=(0, 1)), primitives=(quad(), quad(z=-1.0)), material=material,
                     image=Image(pixels, ("clamp_to_edge", "clamp_to_edge")))  # fmt: skip
    assert ahead(scene, x=0.6) == pytest.approx(5.0)
    assert ahead(scene, x=-0.6) == np.inf
    # Bilinear: the edge lies midway between the second and third texel's centres.
    assert ahead(scene, x=0.01) == pytest.approx(5.0)
    assert ahead(scene, x=-0.01) == np.inf


def test_blended_surfaces_are_transparent():
    scene = scene_of(
        Node("a", mesh=(0,)), primitives=(quad(),), material=Material(alpha_mode="BLEND")
    )
    assert ahead(scene) == np.inf


def test_rays_see_moving_things_at_their_time():
    channel = Channel(
        0, "translation", np.array([0.0, 1.0]), np.array([[0, 0, 0], [0, 0, 4.0]]), "LINEAR"
    )
    scene = scene_of(Node("a", mesh=(0,), moving=True), primitives=(quad(),))
    scene = replace(scene, animations=(Animation("go", (channel,), 1.0),))
    assert ahead(scene, time_s=0.25) == pytest.approx(4.0)
    assert ahead(scene, time_s=1.75) == pytest.approx(2.0)


def test_head_locked_things_go_with_the_head():
    held = Node("held", mesh=(0,), translation=np.array([0.0, 0.0, -2.0]), head_locked=True)
    scene = scene_of(held, primitives=(quad(half=0.2),))
    assert ahead(scene) == np.inf
    head = Pose([3.0, 1.0, 7.0], axis_angle([0, 1, 0], 0.8))
    assert cast(scene, 0.0, [head.position], [head.forward], head=head)[0] == pytest.approx(2.0)


def test_levels_of_detail_change_with_the_heads_distance():
    node = Node("a", mesh=(0,), lod=(LodLevel(4.0, (1,)), LodLevel(20.0, ())))
    scene = scene_of(node, primitives=(quad(), quad(z=0.5)))
    depth = [cast(scene, 0.0, [[0, 0, z]], FORWARD)[0] for z in (3.0, 5.0, 30.0)]
    np.testing.assert_allclose(depth, [3.0, 4.5, np.inf])
    near = Pose([0.0, 0.0, 2.0])
    assert ahead(scene, head=near) == pytest.approx(5.0)


def test_what_is_scaled_to_nothing_is_not_hit():
    hidden = Node("hidden", mesh=(0,), scale=np.zeros(3))
    flat = Node("flat", mesh=(0,), scale=np.array([0.0, 1.0, 1.0]))
    assert np.isinf(ahead(scene_of(hidden, flat, primitives=(quad(-3.0),))))
