"""Means over time: intervals that compare conditions within people."""

import numpy as np
import pytest
from scipy import stats
from scipy.stats import t as t_distribution

from vrcomfort.stats.means import mean_curves, within_variances

RANDOM = np.random.default_rng(3)


def balanced(people, conditions, spread=5.0):
    """Return values (people × conditions) of people who differ much."""
    own = RANDOM.normal(0, spread, (people, 1))
    return own + RANDOM.normal(0, 1, (people, conditions)) + np.arange(conditions)


def long(table):
    people, conditions = table.shape
    met = np.tile(np.arange(conditions), people)
    return table.reshape(-1, 1), met, np.repeat(np.arange(people), conditions)


@pytest.mark.parametrize("conditions", [2, 3, 5])
def test_intervals_of_complete_data_are_those_of_loftus_and_masson(conditions):
    table = balanced(12, conditions)
    found = mean_curves([0], *long(table), count=conditions)
    left = table - table.mean(axis=1, keepdims=True) - table.mean(axis=0) + table.mean()
    df = 11 * (conditions - 1)
    error = np.sqrt((left**2).sum() / df / 12)
    np.testing.assert_allclose(found.mean[:, 0], table.mean(axis=0))
    np.testing.assert_allclose(found.half[:, 0], t_distribution.isf(0.025, df) * error, rtol=1e-6)


def test_a_condition_that_sensitive_people_alone_met_is_not_higher_for_that():
    own = np.repeat(np.array([0.0, 10.0] * 10), 2)
    values = own + RANDOM.normal(0, 0.5, 40)
    met = np.tile([0, 1], 20)
    values[(met == 1) & (own == 0)] = np.nan
    found = mean_curves([0], values[:, None], met, np.repeat(np.arange(20), 2), count=2)
    assert found.n[:, 0].tolist() == [20, 10]
    assert abs(found.mean[1, 0] - found.mean[0, 0]) < 1
    assert np.nanmean(values[met == 1]) - np.nanmean(values[met == 0]) > 4


def test_one_condition_has_the_interval_of_its_mean():
    values = RANDOM.normal(5, 2, (30, 1))
    found = mean_curves([0], values, np.zeros(30, int), np.arange(30) // 2, count=1)
    assert found.half[0, 0] > 0


def test_no_variance_one_person_and_nobody_have_means_without_intervals():
    values = np.array([[0.0, 3.0, np.nan], [0.0, 5.0, np.nan]])
    found = mean_curves([0, 1, 2], values, [0, 1], [0, 0], count=2)
    np.testing.assert_array_equal(found.mean, [[0, 3, np.nan], [0, 5, np.nan]])
    assert np.isnan(found.half).all()
    assert found.n.tolist() == [[1, 1, 0], [1, 1, 0]]


def test_what_all_means_share_is_in_no_variance():
    for count in (2, 3, 6):
        alone = np.full(count, 0.7)
        np.testing.assert_allclose(within_variances(np.diag(alone) + 3.0), alone)
    np.testing.assert_allclose(within_variances(np.array([[2.5]])), [2.5])
    unequal = np.diag([1.0, 3.0]) + 5.0  # half of the variance of the difference each
    np.testing.assert_allclose(within_variances(unequal), [2.0, 2.0])


def test_means_of_different_people_have_their_own_t_interval():
    values = np.array([1.0, 4.0, 2.0, 7.0, 3.0, 8.0, 5.0])
    conditions = np.array([0, 0, 0, 1, 1, 1, 2])
    found = mean_curves([0], values[:, None], conditions, np.arange(7), count=3)
    for condition in range(2):
        mine = values[conditions == condition]
        expected = stats.ttest_1samp(mine, 0).confidence_interval()
        half = found.half[condition, 0]
        assert found.mean[condition, 0] == pytest.approx(mine.mean())
        assert half == pytest.approx((expected.high - expected.low) / 2)
    assert np.isnan(found.half[2, 0]), "of one person there is no interval"
