"""Crossover, mixed model and Friedman."""

import numpy as np
import pandas as pd
import pingouin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import ttest_ind

from vrcomfort.errors import InputError
from vrcomfort.stats.crossover import crossover
from vrcomfort.stats.friedman import friedman
from vrcomfort.stats.mixed import mixed_model

FIRST = np.array([44.9, 22.4, 33.7, 60.1, 3.7, 52.4, 41.1, 37.4, 11.2])
SECOND = np.array([0.0, 11.2, 3.7, 26.2, 7.5, 41.1, 52.4, 29.9, 18.7])
A_FIRST = np.array([True, True, True, True, True, False, False, False, False])


def long() -> pd.DataFrame:
    people = [f"P{i}" for i in range(len(FIRST))]
    one = pd.DataFrame({"id": people, "y": FIRST, "period": "1", "a": A_FIRST})
    two = pd.DataFrame({"id": people, "y": SECOND, "period": "2", "a": ~A_FIRST})
    table = pd.concat([one, two], ignore_index=True)
    order = dict(zip(people, A_FIRST, strict=True))
    table["condition"] = np.where(table["a"], "a", "b")
    return table.assign(sequence=["ab" if order[p] else "ba" for p in table["id"]])


def test_crossover_is_the_pair_of_t_tests():
    result = crossover(FIRST, SECOND, A_FIRST)
    condition = ttest_ind((FIRST - SECOND)[A_FIRST], (FIRST - SECOND)[~A_FIRST])
    sequence = ttest_ind((FIRST + SECOND)[~A_FIRST], (FIRST + SECOND)[A_FIRST])
    assert result.condition.p == pytest.approx(condition.pvalue, rel=1e-9)
    assert result.condition.t == pytest.approx(condition.statistic, rel=1e-9)
    assert result.sequence.t == pytest.approx(sequence.statistic, rel=1e-9)
    assert (result.n_ab, result.n_ba, result.condition.df) == (5, 4, 7)


def test_mixed_model_of_complete_crossover_data_is_the_closed_form():
    closed = crossover(FIRST, SECOND, A_FIRST)
    model = mixed_model(
        long(), value="y", participant="id", factors=["condition", "period", "sequence"],
        references={"condition": "b"},
    )  # fmt: skip
    pairs = zip(
        model.terms.values(), (closed.condition, closed.period, closed.sequence), strict=True
    )
    for term, expected in pairs:
        assert term.estimate == pytest.approx(expected.estimate, rel=1e-4)
        assert term.standard_error == pytest.approx(expected.standard_error, rel=1e-3)
    assert list(model.terms) == ["condition: a − b", "period: 2 − 1", "sequence: ba − ab"]
    assert model.terms["condition: a − b"].df == 7


def test_mixed_model_uses_incomplete_participants():
    model = mixed_model(long().iloc[:-3], value="y", participant="id", factors=["condition"])
    assert (model.n_participants, model.n_values) == (9, 15)


def test_factors_that_coincide_are_refused():
    table = long()
    with pytest.raises(InputError, match="told apart"):
        mixed_model(table.assign(c2=table["condition"]), value="y", participant="id",
                    factors=["condition", "c2"])  # fmt: skip


@pytest.mark.parametrize("order", [[True] * 9, [False] * 9])
def test_one_order_is_no_crossover(order):
    with pytest.raises(InputError, match="both orders"):
        crossover(FIRST, SECOND, order)


@given(st.integers(0, 2**32 - 1), st.integers(3, 12), st.integers(3, 5))
@settings(max_examples=20)
def test_friedman_is_that_of_pingouin(seed, n, k):
    scores = np.random.default_rng(seed).integers(0, 4, (n, k))
    ours = friedman(scores)
    if ours.chi_square is None:
        return
    frame = pd.DataFrame(scores).reset_index().melt("index")
    theirs = pingouin.friedman(frame, dv="value", within="variable", subject="index").iloc[0]
    assert (ours.chi_square, ours.p) == pytest.approx((theirs["Q"], theirs["p_unc"]), rel=1e-6)
    assert ours.kendall_w == pytest.approx(theirs["W"], rel=1e-6, abs=1e-9)


def test_friedman_without_any_difference_is_no_test():
    assert friedman([[1, 1, 1], [2, 2, 2]]).chi_square is None


def test_mixed_model_of_people_who_answer_alike_says_that_nothing_is_left():
    table = pd.DataFrame({"person": list("ppqq"), "condition": list("abab"), "y": [3, 2, 3, 2]})
    with pytest.raises(InputError, match="no variance to model"):
        mixed_model(table, value="y", participant="person", factors=["condition"])
