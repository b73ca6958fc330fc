"""Exact p of Kruskal–Wallis tests: every way to deal the scores, and the table of 1952."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tests.support.places import ROOT
from vrcomfort.stats.mann_whitney import mann_whitney
from vrcomfort.stats.rank_anova import EXACT_UP_TO, kruskal_wallis

FOUND = pd.read_csv(ROOT / "tests" / "data" / "kruskal_wallis" / "r_output.csv")


@pytest.mark.parametrize("row", list(FOUND.itertuples()), ids=FOUND["dataset"])
def test_p_is_the_share_of_all_deals(row):
    groups = [list(map(int, group.split())) for group in row.groups.split("; ")]
    test = kruskal_wallis(groups)
    assert test.method == "exact"
    assert (test.h, test.p) == pytest.approx((row.h, row.p), rel=1e-12)


@pytest.mark.parametrize(
    ("groups", "h", "p"),
    [
        ([[1, 2], [3, 4], [5, 6]], 4.5714, 0.067),
        ([[1, 2, 3], [4, 5, 6], [7, 8, 9]], 7.2, 0.004),
    ],
)
def test_p_of_separated_groups_is_that_of_the_table_of_kruskal_and_wallis(groups, h, p):
    test = kruskal_wallis(groups)
    assert test.h == pytest.approx(h, abs=5e-5)
    assert test.p == pytest.approx(p, abs=5e-4)


@pytest.mark.parametrize("seed", range(4))
def test_two_groups_have_the_p_of_mann_and_whitney(seed):
    random = np.random.default_rng(seed)
    a, b = random.poisson(3, 7), random.poisson(5, 9)
    assert kruskal_wallis([a, b]).p == pytest.approx(mann_whitney(a, b).p_exact)


def test_the_order_of_groups_and_of_people_does_not_matter():
    groups = [[0, 4, 4, 1], [2, 2], [7, 5, 3, 3, 1]]
    p = kruskal_wallis(groups).p
    assert kruskal_wallis(groups[::-1]).p == pytest.approx(p, rel=1e-14)
    assert kruskal_wallis([sorted(group) for group in groups]).p == pytest.approx(p, rel=1e-14)


def test_more_people_have_the_asymptotic_p():
    groups = np.array_split(np.arange(EXACT_UP_TO[3] + 1), 3)
    test = kruskal_wallis(groups)
    assert (test.method, test.p) == ("asymptotic", test.p_asymptotic)
    assert kruskal_wallis([group[:5] for group in groups]).method == "exact"
    asked = kruskal_wallis([group[:5] for group in groups], p_value="asymptotic")
    assert asked.method == "asymptotic"
    assert kruskal_wallis([[i] for i in range(7)]).method == "asymptotic"
