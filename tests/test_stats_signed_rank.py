"""Against R: `sleep` (Student 1908) with coin, stats and exactRankTests; SSQ-like differences."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import wilcoxon

from vrcomfort.stats.effects import rank_biserial
from vrcomfort.stats.ranks import as_integers, fewest_for_interval
from vrcomfort.stats.shift import hodges_lehmann, walsh_averages
from vrcomfort.stats.signed_rank import EXACT_UP_TO, signed_rank
from vrcomfort.stats.withdrawal import fisher_exact, worst_rank

DRUG_1 = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
DRUG_2 = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
SLEEP = as_integers(DRUG_1, 0.1) - as_integers(DRUG_2, 0.1)

differences = st.lists(st.integers(-12, 12), min_size=1, max_size=25)


def test_sleep_pratt_is_that_of_r_coin():
    test = signed_rank(SLEEP, 0.1)
    assert test.z == pytest.approx(-2.7575, abs=5e-5)
    assert test.p_exact == pytest.approx(0.00390625, rel=1e-12)
    assert (test.n, test.zeros, test.ties, test.w_plus, test.w_minus) == (10, 1, 2, 0, 54)


def test_sleep_without_zeros_is_that_of_r_coin():
    test = signed_rank(SLEEP, 0.1, zeros="wilcox")
    assert test.z == pytest.approx(-2.6679, abs=5e-5)
    assert test.p_exact == pytest.approx(0.00390625, rel=1e-12)
    assert (test.w_plus, test.w_minus) == (0, 45)


def test_sleep_shift_is_that_of_r_up_to_its_root_finding():
    shift = signed_rank(SLEEP, 0.1, zeros="wilcox").shift
    assert (shift.estimate, shift.low, shift.high) == pytest.approx((-1.4, -2.95, -1.05))
    assert (shift.n, shift.zeros_included) == (9, False)


def test_sleep_effect_has_no_width_at_minus_one():
    effect = signed_rank(SLEEP, 0.1).effect
    assert (effect.estimate, effect.low, effect.high) == (-1, -1, -1)


def test_interval_of_the_rank_biserial_is_the_formula_of_effectsize():
    values = [-2, -2, -1, 1, 1, 1, 2, 2, 2, 2, 3]
    effect = rank_biserial(values, interval_n=14)
    assert effect.estimate == pytest.approx(31 / 66)
    assert (effect.low, effect.high) == pytest.approx((-0.08480596, 0.80206434), abs=1e-8)
    assert rank_biserial(values).low == pytest.approx(-0.15701, abs=5e-5)


def test_shift_keeps_or_drops_zeros_as_told():
    values = [-2, -2, -1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2, 3]
    assert hodges_lehmann(values, 9.54).estimate == pytest.approx(4.77)
    without = hodges_lehmann(values, 9.54, zeros_included=False)
    assert (without.estimate, without.low, without.high) == pytest.approx((9.54, -4.77, 19.08))


def test_small_samples_have_a_shift_without_an_interval():
    shift = hodges_lehmann([1, 2, 3])
    assert (shift.estimate, shift.low, shift.high, shift.coverage) == (2, None, None, None)
    assert hodges_lehmann([0, 0], zeros_included=False) is None


def test_small_samples_have_a_rank_biserial_without_an_interval():
    effect = rank_biserial([-1, 2, 3, 4, 0, 0, 0])
    assert (effect.estimate, effect.low, effect.high) == (0.8, None, None)
    assert (rank_biserial([1, 2]).estimate, rank_biserial([1, 2]).low) == (1, None)
    assert rank_biserial([-1, 2, 3, 4], confidence=0.8).low is not None


@pytest.mark.parametrize("confidence", [0.75, 0.8, 0.9, 0.9375, 0.95, 0.99, 0.999])
def test_an_interval_needs_as_many_differences_as_the_exact_test_to_reject(confidence):
    fewest = fewest_for_interval(confidence)
    assert signed_rank(np.arange(1, fewest + 1)).p <= 1 - confidence + 1e-12
    assert signed_rank(np.arange(1, fewest)).p > 1 - confidence
    assert hodges_lehmann(np.arange(1, fewest), confidence=confidence).low is None
    enough = hodges_lehmann(np.arange(1, fewest + 1), confidence=confidence)
    assert enough.low is not None
    assert enough.coverage >= confidence - 1e-12


@pytest.mark.parametrize(("n", "leaves_out_zero"), [(6, 0.16), (12, 0.08)])
def test_how_often_the_interval_of_the_rank_biserial_leaves_out_zero(n, leaves_out_zero):
    samples = [np.arange(1, n + 1) * signs for signs in product((-1, 1), repeat=n)]
    left_out = [not (e.low <= 0 <= e.high) for e in map(rank_biserial, samples)]
    assert np.mean(left_out) == pytest.approx(leaves_out_zero, abs=0.005)


def test_nothing_but_zeros_is_no_evidence():
    test = signed_rank([0, 0, 0])
    assert (test.z, test.p, test.effect, test.shift.estimate) == (None, 1.0, None, 0.0)


def test_large_samples_use_the_asymptotic_form():
    test = signed_rank(np.arange(1, EXACT_UP_TO + 2))
    assert (test.p_exact, test.method, test.p) == (None, "asymptotic", test.p_asymptotic)


@given(st.lists(st.integers(1, 10_000), min_size=3, max_size=20, unique=True), st.randoms())
def test_without_ties_it_is_scipys_exact_test(sizes, random):
    values = [size * random.choice((-1, 1)) for size in sizes]
    for alternative in ("two-sided", "greater", "less"):
        ours = signed_rank(values, alternative=alternative).p
        theirs = wilcoxon(values, alternative=alternative, method="exact").pvalue
        assert ours == pytest.approx(theirs, rel=1e-9)


@given(differences)
def test_swapping_the_conditions_mirrors_everything(values):
    one, other = signed_rank(values), signed_rank([-v for v in values])
    assert (one.w_plus, one.w_minus, one.p) == (other.w_minus, other.w_plus, other.p)
    assert one.shift.estimate == -other.shift.estimate
    assert one.n == one.zeros + len(np.flatnonzero(values))


@given(differences)
def test_one_sided_p_values_overlap_in_what_was_observed(values):
    up = signed_rank(values, alternative="greater").p
    down = signed_rank(values, alternative="less").p
    assert up + down >= 1
    assert signed_rank(values).p == pytest.approx(min(1, 2 * min(up, down)))


@given(differences)
def test_shift_lies_in_its_interval_and_among_the_walsh_averages(values):
    shift = hodges_lehmann(values)
    averages = walsh_averages(values)
    assert averages[0] <= shift.estimate <= averages[-1]
    if shift.low is not None:
        assert shift.low <= shift.estimate <= shift.high
        assert shift.coverage >= 0.95


@given(differences, st.integers(0, 4), st.integers(0, 4))
def test_worst_rank_adds_extreme_ranks_of_the_assumed_sign(values, first, second):
    test = worst_rank(values, [1] * first + [-1] * second)
    assert test.n == len(values) + first + second
    assert worst_rank(values, []).p == signed_rank(values).p


def test_losses_in_one_condition_push_the_result_there():
    assert worst_rank([1, 1, 2], [1, 1, 1]).p < signed_rank([1, 1, 2]).p
    assert worst_rank([1, 1, 2], [-1, -1, -1]).w_minus > signed_rank([1, 1, 2]).w_minus


def test_six_of_ten_against_none_of_ten():
    assert fisher_exact([[6, 4], [0, 10]]) == pytest.approx(0.0108359, abs=1e-7)
