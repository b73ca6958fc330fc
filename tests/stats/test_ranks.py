from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vrcomfort.errors import InputError
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.ranks import as_integers, doubled_midranks, sign_flip_distribution, tied_count

small = st.lists(st.integers(-4, 4), min_size=1, max_size=8)


@given(st.lists(st.integers(-50, 50), min_size=1, max_size=30))
def test_midranks_share_the_sum_of_all_ranks(values):
    doubled = doubled_midranks(values)
    assert doubled.sum() == len(values) * (len(values) + 1)
    assert np.array_equal(np.argsort(doubled, kind="stable"), np.argsort(values, kind="stable"))


def test_ties_share_their_mean_rank():
    assert doubled_midranks([3, 1, 3, 7]).tolist() == [5, 2, 5, 8]
    assert tied_count([3, 1, 3, 7]) == 2


@given(small)
@settings(max_examples=40)
def test_null_distribution_is_that_of_all_sign_flips(values):
    ranks = doubled_midranks(values)
    counts = np.zeros(int(ranks.sum()) + 1)
    for signs in product((0, 1), repeat=len(values)):
        counts[int(np.dot(signs, ranks))] += 1
    assert np.array_equal(sign_flip_distribution(ranks), counts / 2 ** len(values))


def test_multiples_of_a_weight_become_exact_ties():
    weighted = np.array([3.74 * 3 - 3.74 * 2, 3.74 * 7 - 3.74 * 6, 0.0])
    assert weighted[0] != weighted[1]
    assert as_integers(weighted, 3.74).tolist() == [1, 1, 0]


@pytest.mark.parametrize("bad", [[1.0, 2.5], [1.0, float("nan")]])
def test_values_off_the_scale_are_refused(bad):
    with pytest.raises(InputError):
        as_integers(bad)


def test_holm_steps_down_within_the_tests_that_were_made():
    assert holm([0.01, None, 0.04, 0.03]) == [pytest.approx(0.03), None, 0.06, 0.06]
    assert holm([]) == []


@given(st.lists(st.floats(0, 1), min_size=1, max_size=8))
def test_holm_lies_between_the_raw_p_and_bonferroni(p):
    for raw, adjusted in zip(p, holm(p), strict=True):
        assert raw <= adjusted <= min(1.0, len(p) * raw + 1e-15)


def test_exact_probabilities_are_dyadic():
    probability = sign_flip_distribution(2 * np.arange(1, 21))
    tail = sum(Fraction(p) for p in probability[:20])
    assert (tail * 2**20).denominator == 1
