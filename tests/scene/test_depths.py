"""The scene `depths`: equal targets at staggered distances, none hidden, and a stair to walk."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracles.raycast import cast
from vrcomfort.geometry import Pose, yaw_pitch_roll
from vrcomfort.headset.locomotion import Locomotion, MoveCommand
from vrcomfort.scene.floors import Floors
from vrcomfort.scene.load import load_scene

DISTANCES_M = [0.5 * 1.5**k for k in range(10)]
BALL_M, CENTRE_M = 0.09, 1.5
SPEED_M_S, FRAME_S = 1.4, 1 / 90


@pytest.fixture(scope="module")
def depths():
    return load_scene("depths")


@pytest.fixture(scope="module")
def targets(depths):
    """Return (10, 3) centres of the targets' balls, nearest first."""
    world = depths.world_from_node(0.0)
    named = [i for i, each in enumerate(depths.nodes) if each.name.startswith("target_")]
    centres = []
    for node in sorted(named, key=lambda i: depths.nodes[i].name):
        places = np.concatenate([depths.primitives[m].positions for m in depths.nodes[node].mesh])
        x, _, z = (places.min(axis=0) + places.max(axis=0)) / 2 + world[node, :3, 3]
        centres.append([x, CENTRE_M, z])
    return np.array(centres)


def test_each_target_is_half_as_far_again_as_the_one_before(targets):
    away = np.hypot(*targets[:, [0, 2]].T)
    np.testing.assert_allclose(away, DISTANCES_M, atol=2e-3)


def test_targets_are_the_same_thing(depths):
    shapes = {}
    for node in depths.nodes:
        if node.name.startswith("target_"):
            parts = [depths.primitives[item].positions for item in node.mesh]
            low = np.concatenate(parts).min(axis=0)
            shapes[node.name] = [np.sort(part - low, axis=0) for part in parts]
    first, *others = shapes.values()
    assert len(others) == 9
    for other in others:
        for one, same in zip(first, other, strict=True):
            np.testing.assert_allclose(one, same, atol=3e-4)


@pytest.mark.parametrize("aside_m", [-0.032, 0.0, 0.032])
def test_none_hides_another_from_either_eye(depths, targets, aside_m):
    eye = np.array([aside_m, 1.6, 0.0])
    for centre in targets:
        to = centre - eye
        # A ring within the ball's outline: no other target covers any part of it.
        side = np.cross(to / np.linalg.norm(to), [0.0, 1.0, 0.0])
        around = [side * np.cos(a) + [0, np.sin(a), 0] for a in np.linspace(0, 2 * np.pi, 12)]
        aimed = np.array([to + 0.9 * BALL_M * each for each in around])
        hit = cast(depths, 0.0, np.tile(eye, (len(aimed), 1)), aimed)
        assert (np.abs(hit - np.linalg.norm(to)) < 1.5 * BALL_M).all()


def test_the_stair_is_walked_at_the_total_speed(depths):
    walker = Locomotion(SPEED_M_S)
    head = Pose((0.0, 1.6, 0.0))
    foot = Pose((4.3, 0.0, -0.4), yaw_pitch_roll(0.0, 0.0, 0.0))
    walker.send(spawn=foot, floors=Floors(depths.walkable))
    walker.arrive(head)
    way_m, before, seconds = 0.0, None, 0.0
    heights = []
    while seconds < 6.0:
        walker.step(head, MoveCommand(0.0, 1.0), FRAME_S)
        feet = np.array((walker.avatar @ head).position) - [0.0, 1.6, 0.0]
        heights.append(feet[1])
        if before is not None and feet[1] < 1.7 - 1e-9:
            way_m += float(np.abs(feet - before)[[1, 2]].sum())  # up a riser, then across a tread
            seconds_on_stair = seconds
        before, seconds = feet, seconds + FRAME_S
    assert heights[-1] == pytest.approx(1.7)
    assert np.all(np.diff(heights) >= 0)
    assert way_m / seconds_on_stair == pytest.approx(SPEED_M_S, rel=0.01)
