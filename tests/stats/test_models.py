"""Crossover, mixed model and Friedman."""

from dataclasses import astuple

import numpy as np
import pandas as pd
import pingouin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import ttest_ind

from vrcomfort.errors import InputError
from vrcomfort.stats.mixed import crossover, mixed_model
from vrcomfort.stats.rank_anova import friedman

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


@pytest.mark.smoke
def test_mixed_model_of_complete_crossover_data_is_the_closed_form():
    closed = crossover(FIRST, SECOND, A_FIRST)
    model = mixed_model(
        long(), value="y", participant="id", factors=["condition", "period", "sequence"],
        references={"condition": "b"}, errors="model",
    )  # fmt: skip
    pairs = zip(
        model.terms.values(), (closed.condition, closed.period, closed.sequence), strict=True
    )
    for term, expected in pairs:
        assert astuple(term) == pytest.approx(astuple(expected), rel=1e-9)
    assert list(model.terms) == ["condition: a − b", "period: 2 − 1", "sequence: ba − ab"]


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


def fewest(text: str) -> pd.DataFrame:
    """Return a table of cells: person, condition and score."""
    rows = [(cell[0], cell[1], float(cell[2:])) for cell in text.split()]
    return pd.DataFrame(rows, columns=["person", "condition", "y"])


def test_standard_error_with_missing_cells_is_that_of_lme4_and_nlme():
    table = fewest("ax0 ay9 bx4 by7 cx22 cy30 dy11 ex15 fy3")
    model = mixed_model(
        table, value="y", participant="person", factors=["condition"], errors="model"
    )
    assert model.terms["condition: y − x"].standard_error == pytest.approx(1.8317, abs=5e-5)


def restricted_deviance(table: pd.DataFrame, group_variance: float, variance: float) -> float:
    """−2 log restricted likelihood by its definition: determinants of n × n matrices."""
    y = table["y"].to_numpy()
    x = np.column_stack([np.ones(len(table)), *pd.get_dummies(table["condition"]).to_numpy().T[1:]])
    same = table["person"].to_numpy()[:, None] == table["person"].to_numpy()
    inverse = np.linalg.inv(group_variance * same + variance * np.eye(len(table)))
    information = x.T @ inverse @ x
    left = y - x @ np.linalg.solve(information, x.T @ inverse @ y)
    determinants = np.linalg.slogdet(information)[1] - np.linalg.slogdet(inverse)[1]
    return float(left @ inverse @ left + determinants)


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.floats(0, 3))
@settings(max_examples=30)
def test_no_variances_near_or_far_are_likelier_than_the_fitted(seed, spread):
    random = np.random.default_rng(seed)
    cells = [(i, c) for i in range(7) for c in "abc" if random.random() < 0.7]
    table = pd.DataFrame(cells, columns=["person", "condition"])
    person = random.normal(0, spread, 7)
    table["y"] = np.round(person[table["person"]] + random.normal(0, 1, len(table)), 1)
    try:
        model = mixed_model(table, value="y", participant="person", factors=["condition"])
    except InputError:
        return
    fitted = model.participant_sd**2, model.residual_sd**2
    best = restricted_deviance(table, *fitted)
    for group in (0, *(fitted[0] * np.array([0.5, 0.99, 1.01, 2])), fitted[1]):
        for variance in fitted[1] * np.array([0.5, 0.99, 1, 1.01, 2]):
            assert restricted_deviance(table, group, variance) >= best - 1e-9


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ("ax1 ay2", "too few"),
        ("ax1 by2 cx3", "no participant has two values"),
        ("ax1 ay2 bx3 by4", "no variance"),
        ("ax1 bx4 ay3", "too few"),
        ("ax5 bx5 ay5 by5 cx5", "no variance"),
        ("ax1 bx2", "no effect has two levels"),
    ],
)
def test_what_two_variances_cannot_be_told_from_is_said(cells, words):
    with pytest.raises(InputError, match=words):
        mixed_model(fewest(cells), value="y", participant="person", factors=["condition"])


@pytest.mark.parametrize("errors", ["cluster_robust", "model"])
def test_of_one_value_each_the_model_is_a_t_test_of_groups(errors):
    one, two = np.array([1.0, 4, 2, 8, 3]), np.array([2.0, 9, 11, 4, 7])
    rows = [("a", value) for value in one] + [("b", value) for value in two]
    table = pd.DataFrame(rows, columns=["condition", "y"]).assign(person=np.arange(10))
    model = mixed_model(
        table, value="y", participant="person", factors=["condition"], errors=errors,
        repeated=False,
    )  # fmt: skip
    found, expected = model.terms["condition: b − a"], ttest_ind(two, one)
    assert (found.t, found.estimate) == pytest.approx((expected.statistic, two.mean() - one.mean()))
    assert (found.df, found.p) == pytest.approx((8, expected.pvalue))
    assert model.omnibus["condition"].p == pytest.approx(expected.pvalue)
    assert model.participant_sd is None


@pytest.mark.parametrize(
    ("cells", "words"), [("ax1 by2", "too few"), ("ax1 by2 cx1", "no variance")]
)
def test_what_no_residual_is_left_of_is_said(cells, words):
    with pytest.raises(InputError, match=words):
        mixed_model(
            fewest(cells), value="y", participant="person", factors=["condition"], repeated=False
        )


def test_people_who_differ_as_residuals_do_leave_all_degrees_of_freedom():
    """The slope of the deviance is 0 at λ = 0, but for rounding; R's lme4 is singular there."""
    scores = {
        "a": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
        "b": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
        "c": [0, 0, 0, None, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1],
    }
    rows = [
        {"id": f"P{i}", "condition": name, "y": np.float64(13.92) * value}
        for name, values in scores.items()
        for i, value in enumerate(values)
        if value is not None
    ]
    model = mixed_model(
        pd.DataFrame(rows), value="y", participant="id", factors=["condition"], errors="model"
    )
    assert model.participant_sd == 0
    assert [term.df for term in model.terms.values()] == pytest.approx([38, 38])
    assert model.terms["condition: c − a"].p == pytest.approx(0.06602701, abs=1e-8)


def test_a_crossover_of_equal_scores_has_no_test_of_rounding():
    """Everybody has 16.83 in the mean, but not in floating point: once p was .036."""
    first = np.array([9, 5, 4, 9, 3, 7, 2, 8, 6, 1, 5, 4, 9, 3, 7]) * 3.74
    second = 33.66 - first
    for scale in (1.0, 1e-6, 1e6):
        found = crossover(scale * first, scale * second, np.arange(15) % 2 == 0)
        assert (found.sequence.estimate, found.sequence.p, found.sequence.low) == (0.0, None, None)
        assert found.condition.p is not None
