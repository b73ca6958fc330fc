"""Kaplan–Meier, log-rank and Cox: every number of R's survival, and what has no estimate."""

from functools import cache
from itertools import combinations, product

import numpy as np
import pandas as pd
import pytest

from tests.support.places import ROOT
from vrcomfort.errors import InputError
from vrcomfort.stats.rating_courses import RatingCourse
from vrcomfort.stats.survival import cox, kaplan_meier, log_rank

DATA = ROOT / "tests" / "data"
OUTPUT = pd.read_csv(DATA / "survival" / "r_output.csv")
EXACT = pd.read_csv(DATA / "survival" / "exact_output.csv")
RELATIVE = 1e-6


@cache
def data_set(name):
    if name == "fms_two":
        whole = data_set("fms")
        return whole[whole["condition"].isin(["base", "rof_forward_whiteline"])]
    if name != "fms":
        table = pd.read_csv(DATA / "survival" / "data.csv")
        return table[table["dataset"] == name].reset_index(drop=True)
    rows = []
    for _, run in pd.read_csv(DATA / "fms" / "ratings.csv").groupby("run"):
        found = RatingCourse.of(run["time_s"], run["fms"]).time_to(10)
        who, condition = run["participant"].iloc[0], run["condition"].iloc[0]
        rows.append((who, condition, found.time_s, found.reached))
    return pd.DataFrame(rows, columns=["participant", "condition", "time_s", "event"])


def ours(analysis, name):
    set_ = data_set(name)
    times, events = set_["time_s"], set_["event"]
    if analysis.startswith("kaplan_meier"):
        people = set_["participant"] if analysis.endswith("robust") else None
        return of_curve(kaplan_meier(times, events, people=people))
    if analysis.startswith("log_rank"):
        strata = set_["participant"] if analysis.endswith("stratified") else None
        return of_log_rank(log_rank(times, events, set_["condition"], strata=strata))
    levels = sorted(set_["condition"].unique())[1:]
    covariates = {level: set_["condition"] == level for level in levels}
    if analysis.endswith("position"):
        covariates["position"] = set_["position"]
    people = None if analysis == "cox" else set_["participant"]
    return of_cox(cox(times, events, covariates, people=people), robust=people is not None)


def of_curve(curve):
    found = {}
    parts = {"n.risk": curve.at_risk, "n.event": curve.events, "surv": curve.survival,
             "std.err": curve.standard_errors, "lower": curve.low, "upper": curve.high}  # fmt: skip
    for part, values in parts.items():
        found |= {
            f"{part} at {t:g}": v for t, v in zip(curve.times_s, values, strict=True)
        }  # R writes times as %g does
    names = ("median", "median lower", "median upper")
    return found | dict(zip(names, curve.median_s(), strict=True))


def of_log_rank(test):
    found = {"chi_square": test.chi_square, "df": test.df, "p": test.p_asymptotic}
    for group, observed, expected in zip(test.groups, test.observed, test.expected, strict=True):
        found |= {f"observed {group}": observed, f"expected {group}": expected}
    return found


def of_cox(model, *, robust):
    found = {
        "log_likelihood": model.log_likelihood,
        "likelihood_ratio": model.likelihood_ratio,
        "wald": model.wald,
    }
    for name, effect in model.effects.items():
        values = {
            "coefficient": effect.coefficient, "standard_error": effect.standard_error,
            "p": effect.p, "low": effect.low, "high": effect.high,
        }  # fmt: skip
        values |= {"robust_error": effect.robust_error} if robust else {}
        found |= {f"{name} {key}": value for key, value in values.items()}
    return found


@pytest.mark.parametrize("analysis", OUTPUT["analysis"].unique())
def test_is_what_r_says(analysis):
    for name, there in OUTPUT[OUTPUT["analysis"] == analysis].groupby("dataset"):
        found = ours(analysis, name)
        for quantity, value in zip(there["quantity"], there["value"], strict=True):
            mine, of = found[quantity], (name, quantity)
            no_error = quantity.startswith("std.err") and value == 0 and np.isnan(mine)
            if no_error:  # of a robust curve that is at 0: R says 0 there, for Greenwood's NaN
                assert found[quantity.replace("std.err", "surv")] == 0, of
            elif np.isnan(value):
                assert mine is None or np.isnan(mine), of
            else:
                assert mine == pytest.approx(value, rel=RELATIVE, abs=1e-12), of


def test_nobody_had_the_event():
    curve = kaplan_meier([10, 20, 30], [0, 0, 0])
    assert (curve.survival == 1).all()
    assert np.isnan(curve.low).all()
    assert curve.median_s() == (None, None, None)
    with pytest.raises(InputError, match="there were no events"):
        log_rank([10, 20], [0, 0], ["a", "b"])
    with pytest.raises(InputError, match="there were no events"):
        cox([10, 20], [0, 0], {"b": [0, 1]})


def test_everybody_had_it_at_once():
    curve = kaplan_meier([5, 5, 5, 5], [1, 1, 1, 1])
    (row,) = curve.at([5])
    assert (row.at_risk, row.events, row.survival) == (4, 4, 0)
    assert row.standard_error is row.low is row.high is None
    assert curve.median_s()[0] == 5
    with pytest.raises(InputError, match="nothing is compared"):
        log_rank([5, 5], [1, 1], ["a", "b"])
    assert cox([5] * 4, [1] * 4, {"b": [0, 0, 1, 1]}).effects["b"].ratio == pytest.approx(1)


def test_a_curve_says_nothing_after_its_end_and_everything_before_its_start():
    curve = kaplan_meier([10, 20], [1, 0])
    before, first, end = curve.at([0, 10, 20, 30])
    assert (before.at_risk, before.survival, before.events) == (2, 1, 0)
    assert (first.at_risk, first.survival, first.events) == (2, 0.5, 1)
    assert (end.at_risk, end.survival, end.events) == (1, 0.5, 0)


def test_times_that_differ_by_rounding_are_one_time():
    assert kaplan_meier([0.1 + 0.2, 0.3, 0.4], [1, 1, 0]).times_s.size == 2


def test_people_who_all_say_the_same_leave_no_robust_error():
    """Two people had the event under both conditions at one time: their scores are 0."""
    with pytest.raises(InputError, match="too few, or too alike, for robust errors"):
        cox([10, 10, 20, 20], [1, 1, 1, 1], {"b": [0, 1, 0, 1]}, people=[1, 1, 2, 2])


def test_an_event_under_one_condition_alone_has_no_hazard_ratio():
    times, events = [3, 5, 9, 9, 9, 9], [1, 1, 0, 0, 0, 0]
    with pytest.raises(InputError, match="the hazard ratio of b has no estimate"):
        cox(times, events, {"b": [1, 1, 0, 0, 0, 1]})
    with pytest.raises(InputError, match="x and y cannot be told apart"):
        cox(times, events, {"x": [1, 0, 1, 0, 1, 0], "y": [0, 1, 0, 1, 0, 1]})


@pytest.mark.smoke
def test_one_group_and_one_course():
    with pytest.raises(InputError, match="one group only"):
        log_rank([3, 5], [1, 1], ["a", "a"])
    curve = kaplan_meier([7], [1], people=["P1"])
    assert curve.n == 1
    assert curve.survival[-1] == 0


@pytest.mark.parametrize(
    ("times", "events", "message"),
    [
        ([], [], "no course"),
        ([1, -1], [0, 1], "missing, infinite or negative"),
        ([1, 2], [0, 2], "neither 0"),
        ([1, 2], [0], "one value for each course"),
    ],
)
def test_refuses_what_is_no_time_to_an_event(times, events, message):
    with pytest.raises(InputError, match=message):
        kaplan_meier(times, events)


def test_intervals_of_a_curve_hold_the_truth_as_often_as_they_say():
    random = np.random.default_rng(7)
    held = []
    for _ in range(400):
        time, left = random.exponential(100, 60), random.uniform(30, 200, 60)
        curve = kaplan_meier(np.minimum(time, left), time <= left)
        (row,) = curve.at([60])
        held.append(row.low <= np.exp(-0.6) <= row.high)
    assert 0.92 <= np.mean(held) <= 0.98


def enumerated_p(times, events, groups, strata):
    """Exact p by its definition: the score of every labelling within strata, one by one."""
    times, events = np.asarray(times, dtype=float), np.asarray(events)
    expected = np.zeros(times.size)
    for layer in set(strata):
        here = np.flatnonzero(np.asarray(strata) == layer)
        for i in here:
            expected[i] = sum(
                events[j] / (times[here] >= times[j]).sum() for j in here if times[j] <= times[i]
            )
    scores, places = events - expected, []
    for layer in dict.fromkeys(strata):
        here = np.flatnonzero(np.asarray(strata) == layer)
        count = sum(groups[i] == "b" for i in here)
        places.append([scores[list(chosen)].sum() for chosen in combinations(here, count)])
    sums = np.abs([sum(each) for each in product(*places)])
    return np.mean(sums >= abs(scores[np.asarray(groups) == "b"].sum()) - 1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_exact_log_rank_test_is_that_over_every_labelling(seed):
    random = np.random.default_rng(seed)
    strata = np.repeat(np.arange(5), 2) if seed % 3 else np.zeros(9, dtype=int)
    groups = np.array(["a", "b"] * 5)[: strata.size]
    if seed % 3 == 2:
        strata, groups = np.append(strata, [0, 1, 1]), np.append(groups, ["a", "b", "b"])
    times = random.integers(1, 6, strata.size)
    events = (random.random(strata.size) < 0.7).astype(int)
    found = log_rank(times, events, groups, strata=strata)
    assert found.p == found.p_exact == pytest.approx(enumerated_p(times, events, groups, strata))


def test_of_pairs_it_is_a_sign_test_of_who_left_first():
    """Eight of nine people left earlier under b; the tenth stayed under both."""
    times = [300, 100, 200, 250, *[400, 90] * 7, 600, 600]
    events = [1, 1, 1, 1, *[1, 1] * 7, 0, 0]
    people = np.repeat(np.arange(10), 2)
    found = log_rank(times, events, ["a", "b"] * 10, strata=people)
    assert found.p_exact == pytest.approx(2 * (1 + 9) / 2**9)


@pytest.mark.parametrize("name", EXACT["dataset"].unique())
def test_r_has_the_same_exact_p(name):
    """Of every labelling in R, and of coin where that has the test (``exact.R``)."""
    rows = EXACT[EXACT["dataset"] == name]
    found = log_rank(rows["time"], rows["event"], rows["group"], strata=rows["stratum"])
    assert found.p_exact == pytest.approx(rows["p"].iloc[0], rel=1e-9)


def test_more_sums_than_can_be_listed_leave_the_asymptotic_test():
    random = np.random.default_rng(8)
    times = random.exponential(100, 60)
    found = log_rank(times, np.ones(60), np.repeat(["a", "b"], 30))
    assert found.p_exact is None
    assert found.p == found.p_asymptotic
