"""Fronts, slopes and verdicts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vrcomfort.tradeoff.results import Point, falls, front, log_slope, undecided, verdict

numbers = st.floats(0.001, 1000)
points = st.lists(st.builds(Point, st.sampled_from("abcd"), numbers, numbers), max_size=12)


def beats(a, b):
    return a.cost <= b.cost and a.error <= b.error and (a.cost, a.error) != (b.cost, b.error)


@given(points)
def test_nothing_on_the_front_is_beaten_and_everything_else_is(found):
    on_front = front(found)
    assert not any(beats(a, b) for a in found for b in on_front)
    for point in found:
        assert point in on_front or any(beats(a, point) for a in on_front)


@given(points)
def test_along_the_front_error_falls_as_cost_rises(found):
    on_front = front(found)
    assert [p.cost for p in on_front] == sorted(p.cost for p in on_front)
    errors = [p.error for p in on_front]
    assert errors == sorted(errors, reverse=True)


@given(points)
def test_a_front_is_its_own_front(found):
    assert front(front(found)) == front(found)


def test_a_verdict_names_the_one_that_comes_nearest():
    theirs = Point("scatter", 10.0, 4.0)
    ours = [Point("fast", 1.0, 8.0), Point("middle", 5.0, 3.0), Point("slow", 20.0, 1.0)]
    found = verdict(theirs, ours)
    assert found is not None
    assert found.beaten
    assert (found.ours, found.cost_ratio, found.error_ratio) == ("middle", 0.5, 0.75)
    lost = verdict(theirs, [ours[0], ours[2]])
    assert lost is not None
    assert not lost.beaten
    assert lost.factor == pytest.approx(2.0)
    assert verdict(theirs, []) is None


@pytest.mark.parametrize(
    ("cost", "error", "expected"),
    [(9.6, 1, False), (9.8, 1, True), (10.2, 1, True), (10.4, 1, False), (10.2, 3, False)],
)
def test_a_verdict_is_undecided_where_noise_could_turn_it(cost, error, expected):
    again = (0.97, 1.03)
    assert undecided(Point("a", 10.0, 2.0), [Point("b", cost, error)], again) is expected
    both = [Point("b", cost, error), Point("c", 5.0, 1.9)]
    assert not undecided(Point("a", 10.0, 2.0), both, again), "c wins whatever noise does"


@given(st.floats(-2, -0.1), st.floats(0.01, 10))
def test_the_slope_of_a_power_law_is_its_exponent(exponent, scale):
    steps = np.array([1, 2, 4, 8, 16.0])
    assert log_slope(steps, scale * steps**exponent) == pytest.approx(exponent)


def test_a_slope_needs_two_steps():
    assert log_slope([4], [0.1]) is None
    assert log_slope([4, 8], [0.1, 0.0]) is None


def test_an_error_falls_or_does_not():
    assert falls([3, 2, 1])
    assert not falls([3, 3, 1])
