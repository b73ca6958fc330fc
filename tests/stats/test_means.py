"""Intervals of means: the wider of t and bootstrap-t."""

import math

import numpy as np
import pytest

from vrcomfort.stats.means import mean_interval
from vrcomfort.stats.t_tests import paired_t


def test_it_is_the_t_interval_where_values_are_normal_and_many():
    values = np.random.default_rng(3).normal(5, 2, 400)
    half = 1.9659 * values.std(ddof=1) / 20
    found = mean_interval(values)
    assert found.low == pytest.approx(values.mean() - half, abs=0.02)
    assert found.high == pytest.approx(values.mean() + half, abs=0.02)


def test_it_reaches_farther_than_t_where_the_tail_is_and_as_far_elsewhere():
    values = np.random.default_rng(5).exponential(1, 15)
    found, t = mean_interval(values), paired_t(values)
    assert t is not None
    assert found.low == pytest.approx(t.low)
    assert found.high - values.mean() > 1.1 * (t.high - values.mean())


def test_it_moves_and_scales_with_the_values():
    values = np.array([0, 0, 3, 1, 7, 2, 2, 11])
    one, other = mean_interval(values), mean_interval(10 + 3.74 * values)
    assert (other.low, other.high) == pytest.approx((10 + 3.74 * one.low, 10 + 3.74 * one.high))


def test_the_same_values_give_the_same_interval_in_any_order():
    values = np.array([0, 0, 3, 1, 7, 2, 2, 11])
    assert mean_interval(values) == mean_interval(values[::-1])


@pytest.mark.parametrize("values", [[], [3], [1, 2], [2, 2, 2, 2]])
def test_nothing_is_said_of_two_values_or_of_some_that_do_not_vary(values):
    found = mean_interval(values)
    assert (found.low, found.high) == (None, None)


def test_a_single_value_off_zero_sets_no_bound_on_its_side():
    found = mean_interval([0] * 7 + [5])
    assert (found.low is None, found.high) == (False, None)


@pytest.mark.parametrize(("draw", "mean"), [("normal", 0.0), ("exponential", 1.0)])
def test_it_covers_the_mean_of_ten(draw, mean):
    """.95 asked for; three Monte-Carlo standard errors below it are .90."""
    random = np.random.default_rng(7)
    found = [mean_interval(getattr(random, draw)(size=10)) for _ in range(200)]
    assert np.mean([f.low <= mean <= f.high for f in found]) > 0.90


def test_evidence_that_no_float_can_hold_is_infinite():
    differences = np.random.default_rng(1).normal(20, 1, 4000)
    found = paired_t(differences)
    assert found is not None
    assert found.t > 1000
    assert found.bayes_factor_10 == math.inf


def test_many_values_are_resampled_a_few_at_a_time(monkeypatch):
    values = np.random.default_rng(3).normal(size=201)
    whole = mean_interval(values)
    monkeypatch.setattr("vrcomfort.stats.means._BLOCK", 100)  # less than one resample
    found = mean_interval(values)
    assert (found.low, found.high) == pytest.approx((whole.low, whole.high))
