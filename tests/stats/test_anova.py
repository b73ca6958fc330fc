"""Against R's afex on O'Brien & Kaiser (1985), scipy and pingouin."""

import numpy as np
import pandas as pd
import pingouin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import f_oneway

from vrcomfort.errors import InputError
from vrcomfort.stats.anova import anova
from vrcomfort.stats.effects import partial_eta_squared

# O'Brien & Kaiser (1985): 16 people; pre, post, follow-up; five hours each.
OBK = """
control 1 2 4 2 1 3 2 5 3 2 2 3 2 4 4
control 4 4 5 3 4 2 2 3 5 3 4 5 6 4 1
control 5 6 5 7 7 4 5 7 5 4 7 6 9 7 6
control 5 4 7 5 4 2 2 3 5 3 4 4 5 3 4
control 3 4 6 4 3 6 7 8 6 3 4 3 6 4 3
A 7 8 7 9 9 9 9 10 8 9 9 10 11 9 6
A 5 5 6 4 5 7 7 8 10 8 8 9 11 9 8
A 2 3 5 3 2 2 4 8 6 5 6 6 7 5 6
A 3 3 4 6 4 4 5 6 4 1 5 4 7 5 4
B 4 4 5 3 4 6 7 6 8 8 8 8 9 7 8
B 3 3 4 2 3 5 4 7 5 4 5 6 8 6 5
B 6 7 8 6 3 9 10 11 9 6 8 7 10 8 7
B 5 5 6 8 6 4 6 6 8 6 7 7 8 10 8
B 2 2 3 1 2 5 6 7 5 2 6 7 8 6 3
B 2 2 3 4 4 6 6 7 9 7 7 7 8 6 7
B 4 5 7 5 4 7 7 8 6 7 7 8 10 8 7
"""


@pytest.fixture(scope="module")
def obk() -> pd.DataFrame:
    rows = []
    for person, line in enumerate(OBK.split("\n")[1:-1]):
        group, *values = line.split()
        for cell, value in enumerate(values):
            phase, hour = ("pre", "post", "fup")[cell // 5], str(cell % 5 + 1)
            rows.append((f"P{person:02d}", group, phase, hour, float(value)))
    return pd.DataFrame(rows, columns=["id", "treatment", "phase", "hour", "value"])


def table(groups) -> pd.DataFrame:
    rows = [(str(g), y) for g, values in enumerate(groups) for y in values]
    data = pd.DataFrame(rows, columns=["group", "y"])
    return data.assign(id=[f"P{i:05d}" for i in range(len(data))])


@pytest.mark.smoke
def test_mixed_design_is_that_of_afex(obk):
    means = obk.groupby(["id", "treatment", "phase"], as_index=False)["value"].mean()
    result = anova(means, value="value", participant="id", within=["phase"], between="treatment")
    treatment, phase, interaction = result.effects
    assert treatment.effect == "treatment"
    assert treatment.f == pytest.approx(2.9139, abs=5e-5)
    assert treatment.sphericity is None
    assert phase.f == pytest.approx(19.2939, abs=5e-5)
    assert phase.generalised_eta_squared == pytest.approx(0.21190, abs=5e-6)
    assert phase.p_greenhouse_geisser == pytest.approx(2.375e-5, rel=5e-4)
    assert interaction.effect == "treatment × phase"
    assert interaction.f == pytest.approx(5.4304, abs=5e-5)
    assert interaction.p_greenhouse_geisser == pytest.approx(0.004301, abs=5e-7)
    assert interaction.p_huynh_feldt == pytest.approx(2.640817e-3, rel=1e-6)
    assert phase.sphericity.greenhouse_geisser == pytest.approx(0.87071, abs=5e-6)
    assert phase.sphericity.huynh_feldt == pytest.approx(0.9939032, abs=5e-8)
    assert phase.sphericity.mauchly_w == pytest.approx(0.85151, abs=5e-6)
    assert phase.sphericity.mauchly_p == pytest.approx(0.38119, abs=5e-6)


def test_type_three_survives_unequal_groups(obk):
    """The main effect of phase ignores group sizes; type II would give 23.6257."""
    means = obk.groupby(["id", "treatment", "phase"], as_index=False)["value"].mean()
    result = anova(means, value="value", participant="id", within=["phase"], between="treatment")
    assert result.effects[1].sum_of_squares == pytest.approx(27.36, abs=5e-3)


def test_two_within_factors_are_those_of_afex(obk):
    result = anova(obk, value="value", participant="id", within=["phase", "hour"])
    assert [e.effect for e in result.effects] == ["phase", "hour", "phase × hour"]
    phase, hour, both = result.effects
    f = [phase.f, hour.f, both.f]
    assert f == pytest.approx([14.8522, 21.6309, 1.3525], abs=5e-5)
    gg = [e.sphericity.greenhouse_geisser for e in (phase, hour, both)]
    assert gg == pytest.approx([0.77202, 0.49842, 0.51297], abs=5e-6)
    hf = [e.sphericity.huynh_feldt for e in (phase, hour, both)]
    assert hf == pytest.approx([0.8436677, 0.5746953, 0.7303094], abs=5e-8)
    p = [e.p_huynh_feldt for e in (phase, hour, both)]
    assert p == pytest.approx([1.089130e-4, 3.161102e-7, 2.439922e-1], rel=1e-6)
    ges = [e.generalised_eta_squared for e in (phase, hour, both)]
    assert ges == pytest.approx([0.147366, 0.098838, 0.011307], abs=5e-7)
    w = [e.sphericity.mauchly_w for e in (phase, hour, both)]
    assert w == pytest.approx([0.70470, 0.11516, 0.01139], abs=5e-6)
    # R's `mauchly.test` takes the second-order term from all 15 columns, so only p = 2 agrees.
    assert phase.sphericity.mauchly_p == pytest.approx(0.086304, abs=5e-7)
    assert hour.sphericity.mauchly_p == pytest.approx(0.000718, rel=0.02)
    assert both.sphericity.mauchly_p == pytest.approx(0.027376, rel=0.01)


@given(st.lists(st.lists(st.integers(0, 30), min_size=3, max_size=6), min_size=2, max_size=4))
@settings(max_examples=30)
def test_one_way_between_is_that_of_scipy(groups):
    if all(len(set(g)) == 1 for g in groups):
        return
    effect = anova(table(groups), value="y", participant="id", between="group").effects[0]
    assert effect.f == pytest.approx(f_oneway(*groups).statistic, rel=1e-7, abs=1e-9)


@pytest.mark.filterwarnings("ignore:The inplace keyword")  # pingouin under pandas 3.1
def test_one_way_within_is_that_of_pingouin(obk):
    means = obk.groupby(["id", "hour"], as_index=False)["value"].mean()
    ours = anova(means, value="value", participant="id", within=["hour"]).effects[0]
    theirs = pingouin.rm_anova(
        data=means, dv="value", within="hour", subject="id", correction=True, effsize="ng2"
    ).iloc[0]
    assert ours.f == pytest.approx(theirs["F"], rel=1e-6)
    assert ours.p_greenhouse_geisser == pytest.approx(theirs["p_GG_corr"], rel=1e-6)
    assert ours.generalised_eta_squared == pytest.approx(theirs["ng2"], rel=1e-6)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_two_conditions_give_the_square_of_the_paired_t(seed):
    values = np.random.default_rng(seed).normal(size=(7, 2))
    long = pd.DataFrame(values, columns=["a", "b"]).assign(id=list("1234567"))
    long = long.melt("id", var_name="condition")
    effect = anova(long, value="value", participant="id", within=["condition"]).effects[0]
    d = values[:, 0] - values[:, 1]
    assert effect.f == pytest.approx(d.mean() ** 2 / (d.var(ddof=1) / 7), rel=1e-8)
    assert effect.sphericity is None


def test_an_incomplete_participant_is_named(obk):
    result = anova(obk.iloc[1:], value="value", participant="id", within=["phase", "hour"])
    assert (result.n, result.excluded) == (15, ("P00",))


def test_residuals_leave_nothing_of_people_and_cells(obk):
    residuals = anova(obk, value="value", participant="id", within=["phase", "hour"]).residuals
    assert residuals.shape == (16, 15)
    assert np.abs(residuals.mean(axis=0)).max() < 1e-12
    assert np.abs(residuals.mean(axis=1)).max() < 1e-12


def test_no_error_variance_gives_no_test():
    data = pd.DataFrame({"id": list("112233"), "c": list("ababab"), "y": [1, 2, 2, 3, 5, 6]})
    effect = anova(data, value="y", participant="id", within=["c"]).effects[0]
    assert (effect.f, effect.p) == (None, None)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: pd.concat([d, d.iloc[:1]]), "two values"),
        (lambda d: d[d["hour"] == "1"], "fewer than two levels"),
        (lambda d: d[d["id"] == "P00"], "more than 1 complete"),
    ],
)
def test_designs_that_cannot_be_analysed_say_why(obk, change, words):
    with pytest.raises(InputError, match=words):
        anova(change(obk), value="value", participant="id", within=["phase", "hour"])


def test_partial_eta_squared_of_printed_results():
    """Hillaire et al. (2008): F(1, 29) = 8.1 and F(2, 27) = 4.02."""
    assert partial_eta_squared(8.1, 1, 29).estimate == pytest.approx(0.218, abs=5e-4)
    assert partial_eta_squared(4.02, 2, 27).estimate == pytest.approx(0.229, abs=5e-4)


@given(st.floats(0.01, 100), st.integers(1, 6), st.integers(2, 60))
@settings(max_examples=40)
def test_interval_of_partial_eta_squared_contains_zero_unless_significant(f, df1, df2):
    from scipy.stats import f as f_distribution

    effect = partial_eta_squared(f, df1, df2)
    assert 0 <= effect.low <= effect.high < 1
    p = f_distribution.sf(f, df1, df2)
    if abs(p - 0.05) > 1e-6:
        assert (effect.low > 0) == (p < 0.05)


@given(st.lists(st.permutations((0, 1, 2)), min_size=3, max_size=7), st.sampled_from(["II", "III"]))
@settings(max_examples=25)
def test_an_effect_of_exactly_zero_has_no_negative_sum_of_squares(scores, sums_of_squares):
    """Both groups, of unequal size, have the same people in them: no group effect at all."""
    people = [("x", each) for each in scores] + [("y", each) for each in (*scores, *scores)]
    rows = [
        (f"P{i}", group, f"c{j}", float(score))
        for i, (group, each) in enumerate(people)
        for j, score in enumerate(each)
    ]
    data = pd.DataFrame(rows, columns=["id", "group", "condition", "y"])
    found = anova(
        data, value="y", participant="id", within=["condition"], between="group",
        sums_of_squares=sums_of_squares,
    ).effects  # fmt: skip
    assert all(effect.sum_of_squares >= 0 for effect in found)
    of_group = [effect for effect in found if "group" in effect.effect]
    assert all(effect.sum_of_squares < 1e-20 for effect in of_group)
