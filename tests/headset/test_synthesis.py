"""Synthetic walks: they go where the itinerary says, at human speeds, and the seed decides."""

import numpy as np
import pytest

from vrcomfort.geometry import rotate
from vrcomfort.traces.synthesis import Gait, Look, Walk, smooth, synthesize
from vrcomfort.traces.trace import Trace

LOOK_RIGHT = (3.0, 1.2, -4.0)
ITINERARY = [Look((0.0, 1.3, -9.0), 2.0), Walk((0.0, 0.0, -4.0)), Look(LOOK_RIGHT, 3.0)]


@pytest.fixture(scope="module")
def trace() -> Trace:
    return synthesize((0.0, 0.0, 0.0), ITINERARY, seed=7)


def world_positions(trace):
    return trace.avatar.positions + rotate(trace.avatar.orientations, trace.head.positions)


def world_forward(trace):
    ahead = rotate(trace.head.orientations, np.broadcast_to([0.0, 0.0, -1.0], (len(trace), 3)))
    return rotate(trace.avatar.orientations, ahead)


def turn_rates_deg_s(trace):
    forward = world_forward(trace)
    cosine = np.clip(np.sum(forward[1:] * forward[:-1], axis=1), -1.0, 1.0)
    return np.degrees(np.arccos(cosine)) / np.diff(trace.time_ns * 1e-9)


def test_the_walk_ends_where_the_itinerary_does(trace):
    np.testing.assert_allclose(trace.avatar.positions[-1], [0.0, 0.0, -4.0], atol=1e-6)


def test_the_head_stands_still_before_a_thing_and_looks_at_it(trace):
    at = -30
    towards = np.array(LOOK_RIGHT) - world_positions(trace)[at]
    cosine = world_forward(trace)[at] @ towards / np.linalg.norm(towards)
    assert np.degrees(np.arccos(cosine)) < 3.0
    assert turn_rates_deg_s(trace)[-72:].max() < 5.0


def test_locomotion_keeps_to_the_papers_speed(trace):
    speed = np.linalg.norm(np.diff(trace.avatar.positions, axis=0), axis=1) * 72
    assert 1.39 < speed.max() < 1.4 + 1e-3


def test_eyes_stay_at_the_height_of_a_person(trace):
    height = world_positions(trace)[:, 1]
    assert 1.6 <= height.min() < height.max() <= 1.7
    assert np.ptp(height) > 0.03  # it bobs


def test_the_head_rolls_and_sways_while_walking(trace):
    ear = rotate(trace.head.orientations, np.broadcast_to([1.0, 0.0, 0.0], (len(trace), 3)))
    walking = slice(200, 300)
    assert np.ptp(np.degrees(np.arcsin(ear[walking, 1]))) > 1.0
    assert np.ptp(trace.head.positions[walking, 0]) > 0.015


def test_turns_are_fast(trace):
    assert 250 < turn_rates_deg_s(trace).max() < 450


def test_the_seed_decides(trace):
    again, other = (synthesize((0.0, 0.0, 0.0), ITINERARY, seed=seed) for seed in (7, 8))
    assert np.array_equal(again.head.cells(), trace.head.cells())
    assert not np.array_equal(other.head.cells(), trace.head.cells())


def test_quaternions_are_unit_and_times_exact(trace):
    for track in (trace.head, trace.avatar):
        np.testing.assert_allclose(np.linalg.norm(track.orientations, axis=1), 1, atol=2e-7)
    assert trace.time_ns[72] == 1_000_000_000


def test_without_gait_the_head_is_where_the_eyes_should_be():
    still = Gait(idle_sway_m=0.0, idle_turn_deg=0.0)
    trace = synthesize((1.0, 2.0, 3.0), [Look((1.0, 3.65, 0.0), 1.0)], seed=1, gait=still)
    np.testing.assert_allclose(world_positions(trace), [[1.0, 3.65, 3.0]] * len(trace), atol=1e-6)


def test_smoothing_keeps_constants_and_never_overshoots():
    step = np.repeat([[0.0], [1.0]], 50, axis=0)
    smoothed = smooth(step, 20)
    assert smoothed.min() >= 0.0
    assert smoothed.max() <= 1.0 + 1e-12
    np.testing.assert_allclose(smooth(np.ones((30, 2)), 12), 1.0)
