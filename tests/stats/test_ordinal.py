"""Cumulative logit models against R: tests/data/ordinal, by reference.R there."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import approx_fprime

from tests.support.places import ROOT
from vrcomfort.errors import InputError
from vrcomfort.stats.ordinal import _Likelihood, fit_cumulative_link, ordinal_model

DATA = ROOT / "tests" / "data" / "ordinal"
ANSWERS = pd.read_csv(DATA / "data.csv")
FOUND = pd.read_csv(DATA / "r_output.csv")
REFERENCES = {"wine": "cold", "repeated": "off", "few": "off", "independent": "off"}
NAMES = {
    "a": {"warm": "awarm", "on": "aon", "part": "apart"},
    "b": {"yes": "byes", "hall": "bhall"},
}


def rows_of(dataset: str) -> pd.DataFrame:
    return ANSWERS[ANSWERS["dataset"] == dataset]


@cache
def model_of(dataset: str, *, alone: bool = False):
    rows = rows_of(dataset)
    rows = rows.assign(who=range(len(rows))) if alone else rows
    return ordinal_model(
        rows, value="answer", participant="who", factors=["a", "b"],
        references={"a": REFERENCES[dataset]},
    )  # fmt: skip


def ours(model) -> dict[str, float]:
    """Return the numbers of a model as R calls them."""
    answers = [f"{answer:g}" for answer in model.answers]
    cuts = [f"{low}|{high}" for low, high in pairwise(answers)]
    found = {f"{cut} estimate": each for cut, each in zip(cuts, model.thresholds, strict=True)}
    for term, odds in model.terms.items():
        factor, levels = term.split(": ")
        name = NAMES[factor][levels.split(" − ")[0]]
        found |= {f"{name} estimate": odds.estimate, f"{name} se": odds.standard_error,
                  f"{name} z": odds.z, f"{name} p": odds.p}  # fmt: skip
    found |= {f"lr_{factor}": test.chi_squared for factor, test in model.omnibus.items()}
    check = model.proportional["a"].test
    if check:
        found |= {"nominal_lr_a": check.chi_squared, "nominal_df_a": check.df,
                  "nominal_p_a": check.p}  # fmt: skip
    return found | {"log_likelihood": model.log_likelihood, "sd estimate": model.participant_sd}


def compared(analysis: str, dataset: str, numbers: dict[str, float], names) -> int:
    """Compare what R has and we have to a relative 1e-6; return how many numbers that were."""
    rows = FOUND[(FOUND["analysis"] == analysis) & (FOUND["dataset"] == dataset)]
    said = {row.quantity: row.value for row in rows.itertuples() if names(row.quantity)}
    shared = said.keys() & numbers.keys()
    for name in shared:
        assert numbers[name] == pytest.approx(said[name], rel=1e-6), (dataset, name)
    return len(shared)


@pytest.mark.parametrize(("dataset", "n"), [("wine", 13), ("repeated", 14), ("few", 13)])
def test_random_intercepts_are_those_of_the_integrated_likelihood(dataset, n):
    numbers = ours(model_of(dataset))
    counted = compared("integrate", dataset, numbers, lambda name: name != "sd se")
    counted += compared("clmm", dataset, numbers, lambda name: name.startswith(("lr_", "log_")))
    assert counted == n


@pytest.mark.parametrize("dataset", ["wine", "repeated", "few"])
def test_clmm_is_as_near_as_it_gets(dataset):
    # Its own maximum is up to 4e-5 beside that of the likelihood; see reference.R.
    numbers = ours(model_of(dataset))
    rows = FOUND[(FOUND["analysis"] == "clmm") & (FOUND["dataset"] == dataset)]
    for row in rows.itertuples():
        if row.quantity in numbers:
            assert numbers[row.quantity] == pytest.approx(row.value, rel=2e-4), row.quantity


@pytest.mark.parametrize(("dataset", "n"), [("wine", 13), ("repeated", 19), ("independent", 19)])
def test_without_repeated_answers_it_is_clm(dataset, n):
    model = model_of(dataset, alone=True)
    assert model.participant_sd is None
    tested = dataset != "wine"  # there, some answers were not given under every level
    names = {name for name in ours(model) if tested or not name.startswith("nominal")}
    assert compared("clm", dataset, ours(model), names.__contains__) == n


def test_polr_has_the_same_estimates():
    model = model_of("independent")
    rows = FOUND[FOUND["analysis"] == "polr"].set_index("quantity")["value"]
    assert model.terms["a: on − off"].estimate == pytest.approx(rows["aon"], rel=1e-6)
    assert model.terms["b: hall − garden"].estimate == pytest.approx(rows["bhall"], rel=1e-6)
    assert model.thresholds == pytest.approx([rows["0|1"], rows["1|2"], rows["2|3"]], rel=1e-6)


def test_two_answers_of_two_groups_are_the_odds_ratio_of_their_table():
    table = pd.DataFrame({
        "answer": [0] * 7 + [1] * 3 + [0] * 2 + [1] * 8,
        "condition": ["b"] * 10 + ["a"] * 10, "who": range(20),
    })  # fmt: skip
    model = ordinal_model(
        table, value="answer", participant="who", factors=["condition"],
        references={"condition": "b"},
    )  # fmt: skip
    odds = model.terms["condition: a − b"]
    assert odds.odds_ratio == pytest.approx(8 * 7 / (2 * 3), rel=1e-8)
    assert odds.standard_error == pytest.approx(np.sqrt(1 / 8 + 1 / 7 + 1 / 2 + 1 / 3), rel=1e-8)
    assert model.proportional == {}


def test_the_gradient_is_that_of_the_likelihood():
    rows = rows_of("repeated")
    design = (rows[["a"]].to_numpy() == "on").astype(float)
    nominal = (rows[["b"]].to_numpy() == "hall").astype(float)
    groups = np.unique(rows["who"], return_inverse=True)[1]
    likelihood = _Likelihood(rows["answer"].to_numpy(), design, nominal, groups)
    at = np.array([-1.0, 0.5, 2.0, 0.1, -0.2, 0.3, 0.8, 1.2])
    numeric = approx_fprime(at, lambda p: likelihood.value(p)[0], 1e-6)
    assert likelihood.value(at)[1] == pytest.approx(numeric, abs=2e-4)


def test_people_who_do_not_differ_have_no_random_intercept():
    table = pd.DataFrame({
        "answer": [0, 1, 2, 1, 0, 2] * 6, "condition": list("aababb") * 6,
        "who": np.repeat(range(6), 6),
    })  # fmt: skip
    model = ordinal_model(table, value="answer", participant="who", factors=["condition"])
    alone = ordinal_model(
        table.assign(who=range(36)), value="answer", participant="who", factors=["condition"]
    )
    assert (model.participant_sd, alone.participant_sd) == (0, None)
    assert model.terms == alone.terms


def test_answers_that_a_level_lacks_are_taken_together_for_the_check():
    table = pd.DataFrame({
        "answer": [0, 0, 1, 1, 2, 3, 0, 1, 1, 2, 2, 2], "condition": ["a"] * 6 + ["b"] * 6,
        "who": range(12),
    })  # fmt: skip
    model = ordinal_model(table, value="answer", participant="who", factors=["condition"])
    check = model.proportional["condition"]
    assert check.together == ((2.0, 3.0),)
    assert check.test.df == 1
    # Above 0: 4 of 6 under a, 5 of 6 under b; above 1: 2 and 3; above 2: 1 and none.
    above = check.cuts["condition: b − a"]
    assert above[:2] == pytest.approx([(5 / 1) / (4 / 2), 1 / (2 / 4)], rel=1e-6)
    assert above[2] is None


@pytest.mark.parametrize(
    ("answers", "conditions", "said"),
    [
        ([1, 1, 1, 1], "aabb", "all answers are alike"),
        ([1, 2, 1, 2], "aaaa", "no effect has two levels"),
        ([0, 1, 0, 2, 3, 3], "aaabbb", "an effect separates the answers"),
    ],
)
def test_what_cannot_be_fitted_is_said(answers, conditions, said):
    table = pd.DataFrame({"answer": answers, "c": list(conditions), "who": range(len(answers))})
    with pytest.raises(InputError, match=said):
        ordinal_model(table, value="answer", participant="who", factors=["c"])


def test_effects_that_cannot_be_told_apart_are_said():
    table = rows_of("few").assign(c=lambda rows: rows["b"])
    with pytest.raises(InputError, match="b and c cannot be told apart"):
        ordinal_model(table, value="answer", participant="who", factors=["b", "c"])


def test_every_answer_of_a_fit_counts_once():
    rows = rows_of("few")
    design = np.empty((len(rows), 0))
    fit = fit_cumulative_link(rows["answer"].to_numpy(), design)
    shares = np.cumsum(np.bincount(rows["answer"]))[:-1] / len(rows)
    assert 1 / (1 + np.exp(-fit.thresholds)) == pytest.approx(shares)
