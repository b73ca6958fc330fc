"""Tests of further designs against R: tests/data/designs, by reference.R there."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.stats import t as t_distribution

from tests.support.places import ROOT
from vrcomfort.errors import InputError
from vrcomfort.report.families import holds
from vrcomfort.stats.anova import anova
from vrcomfort.stats.correlation import correlation, intraclass, repeated_measures_correlation
from vrcomfort.stats.mann_whitney import EXACT_UP_TO, mann_whitney
from vrcomfort.stats.mixed import mixed_model
from vrcomfort.stats.packages import pingouin
from vrcomfort.stats.proportions import preference, sign_test
from vrcomfort.stats.rank_anova import aligned_ranks, kruskal_wallis
from vrcomfort.stats.ranks import level_of
from vrcomfort.stats.t_tests import (
    PRIOR_SCALE,
    equivalence_of_groups,
    equivalence_of_pairs,
    jzs_bayes_factor,
    paired_t,
    two_sample_t,
)

DATA = ROOT / "tests" / "data" / "designs"
NUMBERS = pd.read_csv(DATA / "data.csv")
SIDES = ("two-sided", "greater", "less")
FLEISS = [[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]]
"""Four judges of six targets: Shrout & Fleiss (1979), table 2."""


def of(dataset: str, group: str) -> np.ndarray:
    chosen = (NUMBERS["dataset"] == dataset) & (NUMBERS["group"] == group)
    return NUMBERS.loc[chosen, "value"].to_numpy()


def both(dataset: str) -> tuple[np.ndarray, np.ndarray]:
    return of(dataset, "a"), of(dataset, "b")


def ours_mann_whitney(name: str) -> dict[str, float | None]:
    a, b = both(name)
    found: dict[str, float | None] = {}
    for side in SIDES:
        test = mann_whitney(a, b, alternative=side, intervals=False)
        found |= {f"p_exact {side}": test.p_exact, f"p_asymptotic {side}": test.p_asymptotic}
    test = mann_whitney(a, b)
    shift, effect = test.shift, test.effect
    return found | {
        "u": test.u, "z": test.z, "shift": shift.estimate, "shift_low": shift.low,
        "shift_high": shift.high, "rank_biserial": effect.estimate, "effect_low": effect.low,
        "effect_high": effect.high,
    }  # fmt: skip


def of_t(test) -> dict[str, float | None]:
    g = test.hedges_g
    return {"t": test.t, "df": test.df, "p": test.p, "low": test.low, "high": test.high,
            "mean": test.mean, "standard_error": test.standard_error, "g": g.estimate,
            "g_low": g.low, "g_high": g.high, "bf": test.bayes_factor_10}  # fmt: skip


def ours_welch(name: str) -> dict[str, float | None]:
    one_sided = two_sample_t(*both(name), alternative="greater")
    return of_t(two_sample_t(*both(name))) | {
        "p_greater": one_sided.p, "low_greater": one_sided.low,
    }  # fmt: skip


def ours_sign(name: str) -> dict[str, float]:
    a, b = both(name)
    found = {}
    for side in SIDES:
        test = sign_test(a - b, alternative=side)
        found |= {f"p {side}": test.p, f"share_low {side}": test.share.low,
                  f"share_high {side}": test.share.high}  # fmt: skip
    return found


def ours_correlation(name: str, method: str) -> dict[str, float | None]:
    a, b = both(name)
    return vars(correlation(a[: b.size], b[: a.size], method=method))


def ours_repeated_measures(name: str) -> dict[str, float | None]:
    x, y = (np.concatenate([of(name, g) for g in pair]) for pair in (("x1", "x2"), ("x3", "x4")))
    people = np.tile(np.arange(9), 2)
    return vars(repeated_measures_correlation(x, y, people))


def ours_preference(name: str) -> dict[str, float]:
    found = preference(*map(int, name.split("-")))
    shares = {f"{end}_{i}": getattr(share, end) for i, share in enumerate(found.shares, start=1)
              for end in ("low", "high")}  # fmt: skip
    return shares | {"p": found.p, "low": found.share_of_a.low, "high": found.share_of_a.high}


def ours_intraclass(name: str) -> dict[str, float]:
    groups = ("x1", "x2", "x3", "x4")
    scores = FLEISS if name == "shrout_fleiss" else np.column_stack([of(name, g) for g in groups])
    words = {"1": "one", "2": "two", "3": "three"}
    named = {f"{words[each.form[0]]}_{each.form[2]}": each for each in intraclass(scores)}
    return {key: each.estimate for key, each in named.items()} | {
        f"{key} {end}": getattr(each, end) for key, each in named.items() for end in ("low", "high")
    }


def crossed(dataset: str) -> pd.DataFrame:
    table = pd.read_csv(DATA / "crossed.csv")
    return table[table["dataset"] == dataset]


CROSSED = {"value": "value", "participant": "participant", "within": ["view", "dose"]}


def ours_crossed(name: str) -> dict[str, float | None]:
    found = {}
    for type_, number in (("II", 2), ("III", 3)):
        made = anova(crossed(name), **CROSSED, between=["group", "sex"], sums_of_squares=type_)
        for each in made.effects:
            found |= {f"{number} {each.effect} F": each.f, f"{number} {each.effect} p": each.p}
    return found


def ours_aligned_ranks(name: str) -> dict[str, float | None]:
    _, effects = aligned_ranks(crossed(name), **CROSSED, between=["group"])
    return {f"{each.effect} {key}": getattr(each, key.lower())
            for each in effects for key in ("F", "p")}  # fmt: skip


def ours_marginal_means(name: str) -> dict[str, float | None]:
    table = crossed(name).reset_index(drop=True).drop(index=[2, 7, 13, 14, 39, 60])
    model = mixed_model(
        table, value="value", participant="participant", factors=["dose", "view", "group"],
        references={"dose": "low"}, errors="model",
    )  # fmt: skip
    keys = ("estimate", "standard_error", "df", "low", "high")
    found = {
        f"{factor}{level} {key}": getattr(mean, key)
        for factor, means in model.means.items()
        for level, mean in means.items()
        for key in keys
    }
    for pair, difference in model.pairwise["dose"].items():
        named = " - ".join(f"dose{level}" for level in pair.split(" − "))
        found |= {f"{named} {key}": getattr(difference, key) for key in (*keys, "p_adjusted")}
    return found


OURS = {
    "crossed": ours_crossed,
    "aligned_ranks": ours_aligned_ranks,
    "marginal_means": ours_marginal_means,
    "mann_whitney": ours_mann_whitney,
    "welch": ours_welch,
    "pooled": lambda name: of_t(two_sample_t(*both(name), variances="pooled")),
    "paired": lambda name: of_t(paired_t(np.subtract(*both(name)))),
    "tost_groups": lambda name: vars(equivalence_of_groups(*both(name), (-3, 3))),
    "tost_pairs": lambda name: vars(equivalence_of_pairs(np.subtract(*both(name)), (-2, 2))),
    "sign": ours_sign,
    "kruskal_wallis": lambda name: vars(
        kruskal_wallis([of(name, g) for g in "abc"], p_value="asymptotic")
    ),
    "pearson": lambda name: ours_correlation(name, "pearson"),
    "spearman": lambda name: ours_correlation(name, "spearman"),
    "kendall": lambda name: ours_correlation(name, "kendall"),
    "repeated_measures": ours_repeated_measures,
    "preference": ours_preference,
    "intraclass": ours_intraclass,
}


R_OUTPUT = pd.read_csv(DATA / "r_output.csv")


@pytest.mark.parametrize("analysis", R_OUTPUT["analysis"].unique())
def test_numbers_are_those_of_r(analysis: str) -> None:
    for dataset, rows in R_OUTPUT[R_OUTPUT["analysis"] == analysis].groupby("dataset"):
        ours = OURS[analysis](dataset)
        expected = dict(zip(rows["quantity"], rows["value"], strict=True))
        known = {key: value for key, value in expected.items() if not np.isnan(value)}
        if analysis == "pearson":  # R's interval is Fisher's, which skewed scores leave
            low, high = known.pop("low"), known.pop("high")
            assert ours["low"] <= low < high <= ours["high"]
        found = {key: ours[key] for key in known}
        assert found == pytest.approx(known, rel=1e-6, abs=1e-12), dataset


def test_shrout_and_fleiss_print_these() -> None:
    printed = [0.17, 0.29, 0.71, 0.44, 0.62, 0.91]
    assert [each.estimate for each in intraclass(FLEISS)] == pytest.approx(printed, abs=0.005)


@pytest.mark.parametrize("dataset", ["distinct", "tied", "uneven", "separate"])
def test_shift_holds_what_the_test_does_not_reject(dataset: str) -> None:
    a, b = both(dataset)
    for side in SIDES:
        shift = mann_whitney(a, b, alternative=side).shift
        for theta in np.arange(-30, 60):
            p = mann_whitney(a - theta, b, alternative=side, intervals=False).p
            above = shift.low is None or theta > shift.low
            above = above or (theta == shift.low and shift.low_closed)
            below = shift.high is None or theta < shift.high
            below = below or (theta == shift.high and shift.high_closed)
            assert p <= 0.05 or (above and below), side


def test_groups_too_large_for_the_exact_distribution_are_asymptotic() -> None:
    half = EXACT_UP_TO // 2
    for more, method in ((0, "exact"), (1, "asymptotic")):
        test = mann_whitney(range(half + more), range(half), intervals=False)
        assert test.method == method


def test_who_is_alone_or_all_alike_gets_a_result_that_says_so() -> None:
    assert mann_whitney([], [1, 2]) is None
    one = mann_whitney([3], [1])
    assert (one.p, one.shift.estimate, one.shift.low, one.effect.estimate) == (1.0, 2.0, None, 1.0)
    alike = mann_whitney([2, 2, 2], [2, 2])
    assert (alike.p, alike.z, alike.shift.estimate, alike.effect.estimate) == (1.0, None, 0.0, 0.0)
    apart = mann_whitney([9] * 6, [1] * 6)
    assert (apart.shift.low, apart.shift.high, apart.effect.estimate) == (8.0, 8.0, 1.0)
    lonely = mann_whitney([9], [1] * 15)
    assert (lonely.p, lonely.shift.low, lonely.shift.high) == (1 / 16, None, None)
    assert -1 < apart.effect.low < apart.effect.high == 1


@pytest.mark.parametrize(("a", "b"), [([], []), ([1], [2]), ([1, 2], [3]), ([2, 2], [3, 3])])
def test_no_t_without_two_values_or_without_variance(a: list[int], b: list[int]) -> None:
    assert two_sample_t(a, b) is None
    assert equivalence_of_groups(a, b, (-1, 1)) is None


def test_one_constant_group_has_a_welch_test() -> None:
    test = two_sample_t([1, 2, 3], [5, 5, 5])
    assert (test.df, test.mean) == (2, -3)


def test_two_pairs_have_no_unbiased_g() -> None:
    test = paired_t([1, 2])
    assert np.isnan(test.hedges_g.estimate)
    assert test.hedges_g.low is None


def test_a_sign_test_of_nothing_is_no_evidence() -> None:
    assert (sign_test([]).p, sign_test([]).median) == (1.0, None)
    none = sign_test([0, 0, 0])
    assert (none.p, none.zeros, none.share) == (1.0, 3, None)
    assert sign_test([1, 2, 3]).p == 0.25


def test_the_median_of_a_sign_test_has_the_interval_that_the_test_does_not_reject() -> None:
    values = np.array([-3, -1, 2, 4, 5, 7, 9, 12])
    median = sign_test(values).median
    assert (median.low, median.high, median.low_closed, median.high_closed) == (-3, 12, 0, 0)
    assert median.coverage == pytest.approx(1 - 2 / 2**8)
    tenths = np.arange(-50, 140)
    inside = [theta for theta in tenths if sign_test(10 * values - theta).p > 0.05]
    assert (min(inside), max(inside)) == (-29, 119)


@pytest.mark.parametrize("method", ["pearson", "spearman", "kendall"])
def test_a_correlation_needs_three_pairs_and_variance(method: str) -> None:
    for x, y in (([], []), ([1, 2], [2, 1]), ([1, 1, 1, 1], [1, 2, 3, 4])):
        assert correlation(x, y, method=method).estimate is None
    line = correlation([1, 2, 3, 4], [2, 4, 6, 8], method=method)
    assert (line.estimate, line.low) == (pytest.approx(1), None)


def test_repeated_measures_on_a_line_correlate_by_one_and_no_more() -> None:
    """Rounding once made it more than 1, which has no arctangent."""
    random = np.random.default_rng(5)
    for _ in range(200):
        x = random.integers(0, 40, 12) * 3.74
        found = repeated_measures_correlation(x, 2.55 * x, np.repeat([1, 2, 3], 4))
        assert found.estimate is not None
        assert abs(found.estimate) <= 1


def test_repeated_measures_of_single_values_say_nothing() -> None:
    assert repeated_measures_correlation([1, 2, 3], [1, 2, 3], ["a", "b", "c"]).estimate is None
    assert repeated_measures_correlation([1, 1, 2, 2], [1, 2, 3, 4], list("aabb")).estimate is None


def test_a_person_of_one_pair_changes_no_repeated_measures_correlation() -> None:
    x, y, people = [1, 2, 4, 3, 5, 9], [2, 1, 5, 1, 4, 8], list("aaabbb")
    with_one = repeated_measures_correlation([*x, 7], [*y, 0], [*people, "c"])
    assert with_one == repeated_measures_correlation(x, y, people)


@pytest.mark.parametrize("groups", [[], [[1, 2, 3]], [[1], [2]], [[1, 2, 3], []]])
def test_kruskal_wallis_needs_groups(groups: list[list[int]]) -> None:
    with pytest.raises(InputError, match="two groups and three people"):
        kruskal_wallis(groups)


def test_kruskal_wallis_of_ties_alone_and_of_separate_groups() -> None:
    assert kruskal_wallis([[1, 1], [1, 1]]).p is None
    assert kruskal_wallis([[1, 1], [2, 2], [3, 3]]).epsilon_squared == pytest.approx(1)


def test_an_intraclass_correlation_needs_people_and_variance() -> None:
    with pytest.raises(InputError, match="two people"):
        intraclass([[1, 2]])
    with pytest.raises(InputError, match="no variance"):
        intraclass([[1, 1], [2, 2]])


def test_nobody_with_a_preference() -> None:
    found = preference(0, 0, 4)
    assert (found.p, found.share_of_a, found.shares[2].estimate) == (1.0, None, 1.0)
    assert preference(0, 0, 0).shares == (None, None, None)


@pytest.mark.parametrize("n", [3, 8, 40])
def test_differences_that_hardly_vary_have_an_interval_of_g(n: int) -> None:
    """The noncentral t has no value far from the noncentrality, and for very large ones."""
    shares = (1.0, 1e-1, -1e-2, 1e-3, -1e-4, 0.9e-4, 1e-5, -1e-8, 1e-12)
    for share in shares:
        found = paired_t(np.sign(share) * 7 + share * np.arange(n))
        assert found is not None
        low, high = found.hedges_g.low, found.hedges_g.high
        assert low is not None
        assert high is not None
        assert low < found.hedges_g.estimate < high


def test_the_interval_of_g_goes_on_where_the_noncentral_t_has_no_value() -> None:
    below, above = (
        paired_t(7 + spread * np.array([-1.0, 1.0] * 4))
        for spread in (1.001 * 7e-4 * 7**0.5, 0.999 * 7e-4 * 7**0.5)
    )
    assert below is not None
    assert above is not None
    assert below.t < 1e4 < above.t
    for end in ("low", "high"):
        ends = [getattr(each.hedges_g, end) / each.t for each in (below, above)]
        assert ends[0] == pytest.approx(ends[1], rel=1e-5)


@pytest.mark.parametrize("n", [3, 8, 40])
def test_a_bayes_factor_grows_with_t(n: int) -> None:
    """An integral over g loses it beyond t of some hundreds: pingouin's falls, even below 0."""
    found = [jzs_bayes_factor(t, n) for t in (0.0, *np.geomspace(1, 1e8, 30))]
    assert all(a < b or b == np.inf for a, b in pairwise(found[1:]))
    assert 0 < found[0] < 1
    # Far out, where the weight lies at a g of t², it goes as t to the power of n - 2.
    far = [jzs_bayes_factor(t, n) for t in (1e6, 2e6)]
    assert far[1] == np.inf or far[1] / far[0] == pytest.approx(2 ** (n - 2), rel=1e-4)


def test_the_bayes_factor_of_sleep_is_that_of_r() -> None:
    """Student's data; R's BayesFactor prints 17.25888."""
    differences = -np.array([1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4])
    found = paired_t(differences)
    assert found is not None
    assert found.bayes_factor_10 == pytest.approx(17.25888, rel=1e-7)


@pytest.mark.parametrize("sizes", [(3, None), (20, None), (9, 14)])
def test_a_bayes_factor_is_that_of_pingouin(sizes: tuple[int, int | None]) -> None:
    n, m = sizes
    for t in (-2.5, 0.0, 0.4, 3.0, 20.0):
        theirs = pingouin().bayesfactor_ttest(t, n, m, paired=m is None, r=PRIOR_SCALE)
        assert jzs_bayes_factor(t, n, m) == pytest.approx(float(theirs), rel=1e-8)


@pytest.mark.parametrize("method", ["pearson", "spearman", "kendall"])
def test_intervals_of_correlations_say_of_0_what_p_says(method: str) -> None:
    for seed in range(40):
        random = np.random.default_rng(seed)
        x, y = random.integers(0, 5, (2, 5 + seed % 12)) ** 2
        found = correlation(x, y + x * (seed % 3), method=method)
        if found.low is None or found.high is None or found.p is None:
            continue
        above = found.low < 0 or (found.low == 0 and found.low_closed)
        below = found.high > 0 or (found.high == 0 and found.high_closed)
        assert (above and below) == (found.p > 0.05), seed
        assert -1 <= found.low <= found.estimate <= found.high <= 1


def test_pearsons_interval_is_that_of_the_jackknife_where_a_pair_is_far_out() -> None:
    """SciPy's r of each set without a pair; the jackknife's error of atanh r, and t of 8 df."""
    x = np.array([1.0, 2, 2, 3, 4, 4, 5, 6, 7, 30])
    y = np.array([2.0, 1, 3, 2, 5, 3, 6, 4, 5, 12])
    z = np.arctanh([np.corrcoef(np.delete(x, i), np.delete(y, i))[0, 1] for i in range(10)])
    error = np.sqrt(9 / 10 * np.sum((z - z.mean()) ** 2))
    assert error > 1 / np.sqrt(7)
    found = correlation(x, y, method="pearson")
    half = t_distribution.isf(0.025, 8) * error
    expected = np.tanh(np.arctanh(found.estimate) + np.array([-half, half]))
    assert (found.low, found.high) == pytest.approx(tuple(expected), rel=1e-9)


@pytest.mark.parametrize("alternative", ["two-sided", "greater", "less"])
@pytest.mark.parametrize("variances", ["welch", "pooled"])
def test_standardised_effects_say_of_zero_what_their_p_says(variances, alternative) -> None:
    """Welch's p is not that of the pooled deviation; the jackknife's interval is no inversion."""
    random, seen, sign = np.random.default_rng(12), 0, -1 if alternative == "less" else 1
    for _ in range(20):
        n, m = random.integers(3, 25, 2)
        a, b = random.normal(sign * 0.9, 1, n), random.normal(0, random.choice([0.2, 1, 4]), m)
        tests = [two_sample_t(a, b, variances=variances, alternative=alternative)]
        tests += [paired_t(random.standard_t(2, n) + sign * 0.7, alternative=alternative)]
        for test in tests:
            for each in (test.cohen_d_interval, test.hedges_g):
                assert holds(each, 0.0) == (test.p > 0.05)
                assert each.low is None or each.low <= each.estimate
                assert each.high is None or each.high >= each.estimate
                seen += not (each.low_closed and each.high_closed)
    assert seen  # some are those that the test has decided


def test_an_exact_p_that_is_the_level_rejects() -> None:
    """1 − .9 is less than .1 in floating point, and the p of three against three is .1."""
    test = mann_whitney([4, 5, 6], [1, 2, 3], confidence=0.9)
    assert test.p == pytest.approx(0.1)
    assert not holds(test.shift, 0.0)
    assert not holds(test.effect, 0.0)
    assert level_of(0.9) == 0.1


def test_the_agreement_of_means_has_no_end_where_that_of_single_scores_is_at_its_lowest() -> None:
    """Spearman and Brown's formula changes its sign there: the low end was above the high one."""
    random = np.random.default_rng(3)
    for _ in range(60):
        scores = random.integers(0, 12, (random.integers(2, 9), 2))
        scores[:, 1] = 12 - scores[:, 0] + random.integers(0, 6, len(scores))
        for each in intraclass(scores):
            assert each.low <= each.estimate <= each.high <= 1, each
            assert each.form.endswith("k") or each.low >= -1, each
    two_people = [[8, 9, 23, 24, 33, 50, 51, 57], [0, 14, 15, 24, 41, 50, 52, 57]]
    assert all(each.low <= each.estimate <= each.high for each in intraclass(two_people))
    lowest = {each.form: each for each in intraclass([[0, 9], [8, 1], [1, 9], [9, 0], [5, 4]])}
    assert (lowest["2,1"].low, lowest["2,k"].low) == (-1, -np.inf)


@pytest.mark.parametrize("scores", [[[1, 2], [2, 1]], [[0.1, 0.4], [0.4, 0.1]]])
def test_two_people_who_change_places_have_the_lowest_agreement_with_any_upper_end(scores) -> None:
    """People and occasions have equal means, so that no variance is estimated: it divided by 0."""
    found = {each.form: each for each in intraclass(scores)}
    assert (found["2,1"].estimate, found["2,1"].low, found["2,1"].high) == (-1, -1, 1)
    assert (found["2,k"].estimate, found["2,k"].high, found["2,1"].p) == (-np.inf, 1, 1)
