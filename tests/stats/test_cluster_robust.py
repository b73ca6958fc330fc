"""CR2 errors of mixed models: equal to R's clubSandwich, and calibrated where lme4's are not."""

import csv
from math import isnan

import numpy as np
import pandas as pd
import pytest

from tests.support.oracles import data_set
from tests.support.places import ROOT
from vrcomfort.stats.mixed import mixed_model

R_OUTPUT = ROOT / "tests" / "data" / "cluster_robust" / "r_output.csv"


def r_output() -> dict[tuple[str, str], dict[str, float]]:
    """Return what R printed, by data set and factors."""
    found: dict[tuple[str, str], dict[str, float]] = {}
    with R_OUTPUT.open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            label, _, quantity = row["quantity"].partition("; ")
            value = float(row["value"]) if row["value"] else float("nan")
            found.setdefault((row["dataset"], label), {})[quantity] = value
    return found


def ours(dataset: str, factors: list[str]) -> dict[str, float | None]:
    table = data_set("exposures.csv", dataset)
    model = mixed_model(table, value="score", participant="participant", factors=factors)
    # R names a coefficient by its factor and level: `condition: b − a` is conditionb.
    named = {name.replace(": ", "").partition(" − ")[0]: e for name, e in model.terms.items()}
    found = {
        f"{name} {key}": getattr(each, key)
        for name, each in named.items()
        for key in ("estimate", "standard_error", "df", "p")
    }
    for name, test in model.omnibus.items():
        found |= {f"{name}: f": test.f, f"{name}: df_error": test.df_error, f"{name}: p": test.p}
    return found


@pytest.mark.parametrize(("dataset", "label"), r_output())
def test_errors_df_and_omnibus_tests_are_those_of_clubsandwich(dataset, label):
    expected = {k: v for k, v in r_output()[dataset, label].items() if "(Intercept)" not in k}
    found = ours(dataset, label.split(" + "))
    assert found.keys() == expected.keys()
    for quantity, value in expected.items():
        mine = found[quantity]
        if isnan(value):
            assert mine is None, quantity
        else:  # lme4's search for the variances ends at 1e-8
            assert mine == pytest.approx(value, rel=1e-6, abs=1e-12), quantity


def test_a_person_who_alone_met_a_level_leaves_its_effect_untested():
    """Nothing in such data says how far that one person may be from the others."""
    rows = [(f"P{i}", c, float(i % 3 + 2 * (c == "b") + (i * 7 + k) % 5))
            for i in range(8) for k, c in enumerate("ab")]  # fmt: skip
    rows += [("P0", "c", 9.0)]
    table = pd.DataFrame(rows, columns=["who", "condition", "y"])
    found = mixed_model(table, value="y", participant="who", factors=["condition"])
    alone, shared = (found.terms[f"condition: {level} − a"] for level in "cb")
    assert alone.p is None
    assert alone.low is None
    assert shared.p is not None
    assert found.omnibus["condition"].p is None


@pytest.mark.parametrize(("unit", "reference"), [(1, "a"), (3.74, "b"), (1e3, "c"), (3.74, "a")])
def test_a_person_whose_only_score_decides_effects_leaves_them_untested(unit, reference):
    """Of P2's residual nothing but rounding is left, and once that was divided by itself."""
    orders = {"P0": "cab", "P1": "cab", "P2": "b", "P3": "acb"}
    scores = dict(zip(orders, ([29, 4, 12], [22, 12, 12], [13], [6, 26, 22]), strict=True))
    rows = [
        (who, c, str(place), unit * score)
        for who, order in orders.items()
        for place, (c, score) in enumerate(zip(order, scores[who], strict=True))
    ]
    table = pd.DataFrame(rows, columns=["who", "condition", "position", "y"])
    found = mixed_model(
        table, value="y", participant="who", factors=["condition", "position"],
        references={"condition": reference},
    )  # fmt: skip
    assert {each.p for each in found.terms.values()} == {None}
    last = found.terms["position: 2 − 0"]  # clubSandwich 0.5.8: 2.333333, 3.333333
    assert (last.estimate / unit, last.standard_error / unit) == pytest.approx((7 / 3, 10 / 3))


def test_where_the_model_is_true_both_kinds_of_errors_agree():
    random = np.random.default_rng(4)
    people = np.repeat(np.arange(2000), random.integers(2, 31, 2000))
    condition = np.array(list("abc"))[random.integers(0, 3, people.size)]
    level = random.normal(0, 5, 2000)[people]
    table = pd.DataFrame({"who": people, "condition": condition,
                          "y": level + random.normal(0, 3, people.size)})  # fmt: skip
    robust, plain = (
        mixed_model(table, value="y", participant="who", factors=["condition"], errors=errors)
        for errors in ("cluster_robust", "model")
    )
    for term, each in robust.terms.items():  # the model is true, so both estimate one error
        assert each.standard_error == pytest.approx(plain.terms[term].standard_error, rel=0.05)
        assert each.df > 1000
