"""The shipped walks: rebuilt byte for byte, on the floor of their scenes, looking at things."""

import importlib.util

import numpy as np
import pytest

from vrcomfort.geometry import rotate
from vrcomfort.resources import data_folder
from vrcomfort.scene.load import load_scene
from vrcomfort.traces.trace import read_trace

SCENES = ["temple", "mountain", "depths"]


@pytest.fixture(scope="module", params=SCENES)
def scene(request):
    return load_scene(request.param)


@pytest.fixture(scope="module")
def trace(scene):
    return read_trace(data_folder("scenes") / f"{scene.name}_walk.csv")


@pytest.fixture(scope="module")
def builder():
    path = data_folder("scenes") / "build_traces.py"
    spec = importlib.util.spec_from_file_location("build_traces", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_building_again_gives_the_same_bytes(builder, tmp_path):
    builder.build(tmp_path)
    for name in SCENES:
        shipped = data_folder("scenes") / f"{name}_walk.csv"
        assert (tmp_path / shipped.name).read_bytes() == shipped.read_bytes()


def world_positions(trace):
    return trace.avatar.positions + rotate(trace.avatar.orientations, trace.head.positions)


def inside(polygon, points):
    """Even-odd rule, all points at once."""
    within = np.zeros(len(points), bool)
    for (x0, z0), (x1, z1) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        crosses = (z0 > points[:, 1]) != (z1 > points[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            x = x0 + (points[:, 1] - z0) / (z1 - z0) * (x1 - x0)
        within ^= crosses & (points[:, 0] < x)
    return within


def test_the_walk_stays_on_the_floor(scene, trace):
    for points in (trace.avatar.positions, world_positions(trace)):
        on_some = np.zeros(len(trace), bool)
        for area in scene.walkable:
            level = np.abs(trace.avatar.positions[:, 1] - area.height_m) < 0.25
            on_some |= inside(area.polygon_xz, points[:, [0, 2]]) & level
        assert on_some.all()


def test_the_walk_starts_where_the_scene_does(scene, trace):
    np.testing.assert_allclose(trace.avatar.positions[0], scene.spawn.position, atol=0.05)


def test_the_walk_is_one_piece_of_half_a_minute_in_a_small_file(scene, trace):
    assert 30.0 <= trace.duration_s <= 45.0
    assert np.flatnonzero(trace.cuts).tolist() == [0]
    size = (data_folder("scenes") / f"{scene.name}_walk.csv").stat().st_size
    assert size < 2_000_000


def test_the_walker_is_a_person(trace):
    height = world_positions(trace)[:, 1] - trace.avatar.positions[:, 1]
    assert 1.55 < height.min() < height.max() < 1.75
    forward = rotate(trace.head.orientations, np.broadcast_to([0.0, 0, -1], (len(trace), 3)))
    forward = rotate(trace.avatar.orientations, forward)
    cosine = np.clip(np.sum(forward[1:] * forward[:-1], axis=1), -1.0, 1.0)
    assert 200 < np.degrees(np.arccos(cosine)).max() * 72 < 600
