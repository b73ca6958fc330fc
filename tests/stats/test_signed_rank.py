"""Against R: `sleep` (Student 1908) with coin, stats and exactRankTests; SSQ-like differences."""

import time

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.stats import norm, wilcoxon

from vrcomfort.stats import effects
from vrcomfort.stats.effects import largest_shift, lower_tail, rank_biserial, superiority
from vrcomfort.stats.proportions import fisher_exact
from vrcomfort.stats.ranks import as_integers, fewest_for_interval, sign_flip_distribution
from vrcomfort.stats.shift import WalshSums, hodges_lehmann
from vrcomfort.stats.signed_rank import EXACT_UP_TO, signed_rank, worst_rank

DRUG_1 = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
DRUG_2 = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]
SLEEP = as_integers(DRUG_1, 0.1) - as_integers(DRUG_2, 0.1)

differences = st.lists(st.integers(-12, 12), min_size=1, max_size=25)
few = settings(max_examples=30)


@pytest.mark.smoke
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
    shift = signed_rank(SLEEP, 0.1, zeros="wilcox", shift_interval="order_statistics").shift
    assert (shift.estimate, shift.low, shift.high) == pytest.approx((-1.4, -2.95, -1.05))
    assert (shift.n, shift.zeros_included) == (9, False)


def test_intervals_of_sleep():
    """At r = −1 all nine are negative: P = Φ(−δ)⁹ is solved by hand."""
    test = signed_rank(SLEEP, 0.1)
    assert (test.effect.estimate, test.effect.low) == (-1, -1)
    assert test.effect.high == pytest.approx(
        1 - 2 * norm.cdf(2**0.5 * norm.ppf(0.025 ** (1 / 9))), abs=1e-6
    )
    assert (test.shift.low, test.shift.high) == pytest.approx((-2.7, -0.9))


def test_interval_of_the_rank_biserial_can_be_the_formula_of_effectsize():
    values = [-2, -2, -1, 1, 1, 1, 2, 2, 2, 2, 3]
    effect = rank_biserial(values, interval="fisher_z", interval_n=14)
    assert effect.estimate == pytest.approx(31 / 66)
    assert (effect.low, effect.high) == pytest.approx((-0.08480596, 0.80206434), abs=1e-8)
    assert rank_biserial(values, interval="fisher_z").low == pytest.approx(-0.15701, abs=5e-5)


def test_shift_keeps_or_drops_zeros_as_told():
    values = [-2, -2, -1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2, 3]
    assert hodges_lehmann(values, 9.54).estimate == pytest.approx(4.77)
    without = hodges_lehmann(values, 9.54, zeros_included=False)
    assert (without.estimate, without.low, without.high) == pytest.approx((9.54, -4.77, 19.08))


def test_small_samples_have_a_shift_without_an_interval():
    shift = hodges_lehmann([1, 2, 3])
    assert (shift.estimate, shift.low, shift.high, shift.coverage) == (2, None, None, None)
    assert hodges_lehmann([0, 0], zeros_included=False) is None


def test_small_samples_have_wide_intervals_of_the_rank_biserial():
    effect = rank_biserial([-1, 2, 3, 4, 0, 0, 0])
    assert effect.estimate == 0.8
    assert -0.5 < effect.low < 0 < effect.high < 1
    one = rank_biserial([5])
    assert (one.estimate, one.high) == (1, 1)
    assert one.low == pytest.approx(2 * norm.cdf(2**0.5 * norm.ppf(0.025)) - 1, abs=1e-7)


def test_fisher_z_intervals_need_as_many_differences_as_a_test_that_can_reject():
    effect = rank_biserial([-1, 2, 3, 4, 0, 0, 0], interval="fisher_z")
    assert (effect.estimate, effect.low, effect.high) == (0.8, None, None)
    assert rank_biserial([-1, 2, 3, 4], interval="fisher_z", confidence=0.8).low is not None


@pytest.mark.parametrize("confidence", [0.75, 0.8, 0.9, 0.9375, 0.95, 0.99, 0.999])
def test_an_interval_needs_as_many_differences_as_the_exact_test_to_reject(confidence):
    fewest = fewest_for_interval(confidence)
    assert signed_rank(np.arange(1, fewest + 1)).p <= 1 - confidence + 1e-12
    assert signed_rank(np.arange(1, fewest)).p > 1 - confidence
    assert hodges_lehmann(np.arange(1, fewest), confidence=confidence).low is None
    enough = hodges_lehmann(np.arange(1, fewest + 1), confidence=confidence)
    assert enough.low is not None
    assert enough.coverage >= confidence - 1e-12


def test_nothing_but_zeros_is_no_evidence():
    test = signed_rank([0, 0, 0])
    assert (test.z, test.p, test.effect, test.shift.estimate) == (None, 1.0, None, 0.0)
    assert (test.shift.low, test.shift.high) == (None, None)
    six = signed_rank([0] * 6).shift
    assert (six.low, six.high, six.low_closed, six.high_closed) == (0, 0, True, True)


def test_large_samples_use_the_asymptotic_form():
    test = signed_rank(np.arange(1, EXACT_UP_TO + 2))
    assert (test.p_exact, test.method, test.p) == (None, "asymptotic", test.p_asymptotic)


@pytest.mark.slow
@given(st.lists(st.integers(1, 10_000), min_size=3, max_size=20, unique=True), st.randoms())
def test_without_ties_it_is_scipys_exact_test(sizes, random):
    values = [size * random.choice((-1, 1)) for size in sizes]
    for alternative in ("two-sided", "greater", "less"):
        ours = signed_rank(values, alternative=alternative, intervals=False).p
        theirs = wilcoxon(values, alternative=alternative, method="exact").pvalue
        assert ours == pytest.approx(theirs, rel=1e-9)


@given(differences)
@few
def test_swapping_the_conditions_mirrors_everything(values):
    one, other = signed_rank(values), signed_rank([-v for v in values])
    assert (one.w_plus, one.w_minus, one.p) == (other.w_minus, other.w_plus, other.p)
    assert one.shift.estimate == -other.shift.estimate
    assert one.n == one.zeros + len(np.flatnonzero(values))


@given(differences)
@few
def test_one_sided_p_values_overlap_in_what_was_observed(values):
    up, down, both = (
        signed_rank(values, alternative=side, intervals=False).p
        for side in ("greater", "less", "two-sided")
    )
    assert up + down >= 1
    assert both == pytest.approx(min(1, 2 * min(up, down)))


@given(differences)
@few
def test_shift_lies_between_order_statistics_of_the_walsh_averages(values):
    shift = hodges_lehmann(values)
    sums = sorted(a + b for i, a in enumerate(values) for b in values[i:])
    assert shift.estimate == np.median(sums) / 2
    if shift.low is not None:
        assert shift.low <= shift.estimate <= shift.high
        assert {2 * shift.low, 2 * shift.high} <= set(sums)
        assert shift.coverage >= 0.95


@given(differences, st.integers(-60, 60))
@few
def test_walsh_sums_are_ordered_without_being_made(values, bound):
    sums = sorted(a + b for i, a in enumerate(values) for b in values[i:])
    found = WalshSums(values)
    assert found.count == len(sums)
    assert [found.order_statistic(rank + 1) for rank in range(len(sums))] == sums
    assert found.at_most(bound) == sum(each <= bound for each in sums)
    assert found.below(bound) == max((each for each in sums if each < bound), default=None)


def p_of_shifted(values, quarters: int, test) -> float:
    """p of the same test after a shift, in quarters of a step, has been taken off."""
    moved = [4 * value - quarters for value in values]
    return signed_rank(
        moved, zeros=test.zero_method, alternative=test.alternative, intervals=False
    ).p


@given(
    st.lists(st.integers(-4, 9), min_size=1, max_size=14),
    st.sampled_from(["pratt", "wilcox"]),
    st.sampled_from(["two-sided", "greater", "less"]),
)
@example([0, 0, 0, -3, 0, 1, -3, 8, -1, 0], "wilcox", "less")  # rejected at 0.75, not at 1
@few
def test_interval_of_the_shift_is_the_hull_of_what_the_test_does_not_reject(values, zeros, side):
    test = signed_rank(values, zeros=zeros, alternative=side, effect_interval="fisher_z")
    if test.shift is None:
        assert not any(values)
        return
    outside = 4 * min(values) - 1, 4 * max(values) + 1
    kept = [
        quarters / 4
        for quarters in range(outside[0], outside[1] + 1)
        if p_of_shifted(values, quarters, test) > 1 - 0.95
    ]
    for kept_end, end, closed, place in (
        (kept[0], test.shift.low, test.shift.low_closed, outside[0]),
        (kept[-1], test.shift.high, test.shift.high_closed, outside[1]),
    ):
        if end is None:
            assert kept_end == place / 4
        elif closed:
            assert kept_end == end
        else:
            assert abs(kept_end - end) == 0.25


@given(differences, st.sampled_from(["two-sided", "greater", "less"]))
@few
def test_interval_of_the_shift_never_contradicts_p(values, side):
    test = signed_rank(values, alternative=side, effect_interval="fisher_z")
    low, high = test.shift.low, test.shift.high
    above = low is None or low < 0 or (low == 0 and test.shift.low_closed)
    below = high is None or high > 0 or (high == 0 and test.shift.high_closed)
    holds_zero = above and below and not test.shift.holds_rejected_zero
    assert holds_zero == (test.p > 1 - 0.95)


def test_one_sided_tests_have_one_sided_bounds():
    values = [3, 1, 0, 2, -1, 4, 2, 5]
    greater = signed_rank(values, alternative="greater")
    assert (greater.shift.high, greater.effect.high) == (None, 1)
    assert greater.shift.low >= signed_rank(values).shift.low
    assert greater.effect.low > signed_rank(values).effect.low
    less = signed_rank([-value for value in values], alternative="less")
    assert (less.shift.low, less.shift.high) == (None, -greater.shift.low)
    assert (less.effect.low, less.effect.high) == pytest.approx((-1, -greater.effect.low))


@pytest.mark.parametrize(("n", "delta"), [(1, 0.4), (3, -0.7), (6, 0.0), (9, 1.1)])
def test_distribution_of_w_under_a_normal_shift_is_that_of_samples(n, delta):
    samples = np.random.default_rng(n).normal(delta, 1, size=(40_000, n))
    ranks = np.argsort(np.argsort(np.abs(samples), axis=1), axis=1) + 1
    w_plus = np.sum(ranks * (samples > 0), axis=1)
    for w in range(n * (n + 1) // 2):
        assert lower_tail(n, w, delta) == pytest.approx(np.mean(w_plus <= w), abs=0.01)


@pytest.mark.parametrize("n", [2, 8, 19, 25])
def test_without_a_shift_w_is_distributed_as_sign_flips_have_it(n):
    exact = np.cumsum(sign_flip_distribution(2 * np.arange(1, n + 1))[::2])
    found = [lower_tail(n, w, 0.0) for w in range(0, exact.size, 1 + exact.size // 20)]
    assert found == pytest.approx(exact[:: 1 + exact.size // 20], abs=1e-8)


@pytest.mark.parametrize("n", [26, 60, 700])
def test_one_small_dissenter_among_many_has_an_interval(n):
    """At a large shift all digits of the approximate moments cancel."""
    for weaker in (1, 2, 3, 5):
        differences = np.arange(1.0, n + 1)
        differences[weaker - 1] *= -1
        low, high = (rank_biserial(side * differences) for side in (1, -1))
        assert 0.5 < low.low < low.estimate <= low.high <= 1
        assert (high.low, high.high) == pytest.approx((-low.high, -low.low))


@pytest.mark.parametrize(("w_plus", "apart"), [(240, 0.02), (284, 0.028), (323, 0.046)])
def test_exact_and_approximate_ends_of_the_rank_biserial_meet(monkeypatch, w_plus, apart):
    """Above the limit the approximation differs by what the module says of it."""
    n = effects.EXACT_SUM_UP_TO
    exact = [superiority(largest_shift(n, w_plus, tail)) for tail in (0.025, 0.975)]
    monkeypatch.setattr(effects, "EXACT_SUM_UP_TO", n - 1)
    largest_shift.cache_clear()
    rough = [superiority(largest_shift(n, w_plus, tail)) for tail in (0.025, 0.975)]
    largest_shift.cache_clear()
    assert rough == pytest.approx(exact, abs=apart + 0.001)
    assert rough != pytest.approx(exact, abs=1e-6)


@given(st.lists(st.integers(1, 10_000), min_size=1, max_size=15, unique=True), st.randoms())
@few
def test_without_ties_and_zeros_the_rank_biserial_agrees_with_p(sizes, random):
    test = signed_rank([size * random.choice((-1, 1)) for size in sizes])
    assert (test.effect.low <= 0 <= test.effect.high) == (test.p > 0.05)
    assert test.effect.low <= test.effect.estimate <= test.effect.high


@pytest.mark.slow
def test_a_hundred_thousand_pairs_make_no_table_of_pairs():
    values = np.rint(np.random.default_rng(1).normal(10, 300, 100_000)).astype(np.int64)
    start = time.process_time()
    test = signed_rank(values)
    assert time.process_time() - start < 200  # of a few; five thousand million pairs take more
    assert (test.method, test.n) == ("asymptotic", 100_000)
    assert test.shift.low < test.shift.estimate < test.shift.high
    assert test.shift.high - test.shift.low < 8


@given(differences, st.integers(0, 4), st.integers(0, 4))
@few
def test_worst_rank_adds_extreme_ranks_of_the_assumed_sign(values, first, second):
    test = worst_rank(values, [1] * first + [-1] * second)
    assert test.n == len(values) + first + second
    assert worst_rank(values, []).p == signed_rank(values, intervals=False).p


def test_losses_in_one_condition_push_the_result_there():
    assert worst_rank([1, 1, 2], [1, 1, 1]).p < signed_rank([1, 1, 2]).p
    assert worst_rank([1, 1, 2], [-1, -1, -1]).w_minus > signed_rank([1, 1, 2]).w_minus


def test_six_of_ten_against_none_of_ten():
    assert fisher_exact([[6, 4], [0, 10]]) == pytest.approx(0.0108359, abs=1e-7)


def test_an_interval_ends_where_ties_leave_no_shift_that_is_not_rejected():
    """A coarse scale and many people: p jumps from one side's rejection to the other's."""
    values = np.array([((7 * i + i // 11) % 21) - ((5 * i + i // 7) % 20) for i in range(20_000)])
    shift = signed_rank(values).shift
    assert shift.low <= shift.estimate <= shift.high
    assert shift.high - shift.low <= 0.5
