"""Simulated power is that of the formula where there is one, and of the report's own tests."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.stats import nct, ttest_1samp
from scipy.stats import t as t_distribution

from tests.support.report import build_report, carnegie_like
from vrcomfort.errors import InputError
from vrcomfort.report.plan_files import read_plan
from vrcomfort.report.power import (
    Effect,
    cells,
    draw_power,
    parse_participants,
    question_of,
    read_pilot,
    simulate_power,
)
from vrcomfort.report.tables import to_csv
from vrcomfort.stats.power import (
    PairedTest,
    ResampledDifferences,
    paired_t_p,
    smallest_effect,
    t_test_power,
)
from vrcomfort.stats.proportions import wilson_bounds
from vrcomfort.stats.signed_rank import signed_rank


@pytest.mark.parametrize("alternative", ["two-sided", "greater", "less"])
def test_the_formula_is_the_noncentral_t(alternative):
    n, effect, alpha = 17, -0.4 if alternative == "less" else 0.4, 0.05
    shift, df = effect * math.sqrt(n), n - 1
    if alternative == "two-sided":
        bound = t_distribution.isf(alpha / 2, df)
        power = nct.sf(bound, df, shift) + nct.cdf(-bound, df, shift)
    else:
        power = nct.sf(t_distribution.isf(alpha, df), df, abs(shift))
    assert t_test_power(effect, n, alpha, alternative) == pytest.approx(power, rel=1e-9)


@pytest.mark.parametrize("alternative", ["two-sided", "greater", "less"])
def test_p_of_the_t_test_is_scipys(alternative):
    values = np.random.default_rng(4).normal(0.3, 1, 15)
    p = ttest_1samp(values, 0, alternative=alternative).pvalue
    assert paired_t_p(values, alternative) == pytest.approx(p, rel=1e-12)


def test_wilsons_interval_is_that_of_his_quadratic():
    low, high = wilson_bounds(17, 20)
    for bound in (low, high):
        z = (17 / 20 - bound) / math.sqrt(bound * (1 - bound) / 20)
        assert abs(z) == pytest.approx(1.959963985)
    assert wilson_bounds(0, 20)[0] == 0
    assert wilson_bounds(20, 20)[1] == 1


@pytest.mark.slow
def test_simulated_t_tests_find_as_often_as_the_formula_says():
    question = question_of("carnegie_2015", Effect(0.6, standardised=True))
    rows = simulate_power(question, (10, 24), studies=1000, seed=5)
    for row in rows:
        assert row.t_test_formula is not None
        error = math.sqrt(row.t_test_formula * (1 - row.t_test_formula) / 1000)
        assert abs(row.t_test.share - row.t_test_formula) < 3.5 * error
        assert abs(row.power.share - row.t_test_formula) < 0.06  # ARE of normal data: 3/π
    assert rows[0].power.high < rows[1].power.low


def test_the_test_is_that_of_the_plan():
    plan = question_of("carnegie_2015_as_printed", Effect(0.6, standardised=True)).test
    assert (plan.alternative, plan.p_value) == ("greater", "asymptotic")
    values = np.array([3, 1, 0, 2, -1, 4, 2, 5])
    for zeros in ("pratt", "wilcox"):
        test = PairedTest("signed_rank", "greater", zeros=zeros)
        assert test.p(values) == signed_rank(values, zeros=zeros, alternative="greater").p


@pytest.mark.slow
@pytest.mark.smoke
def test_the_same_seed_gives_the_same_power_in_any_order_of_work():
    question = question_of("carnegie_2015", Effect(0.5, standardised=True))

    def backwards(function, items):
        return map(function, reversed(list(items)))

    one, two = (
        simulate_power(question, (8, 12), studies=510, seed=3, work=work)
        for work in (map, backwards)
    )
    assert [each.power.found for each in one] == [each.power.found for each in two]
    other = simulate_power(question, (8, 12), studies=510, seed=4)
    assert [each.power.found for each in one] != [each.power.found for each in other]


def test_holm_asks_for_a_level_of_all_tests_of_its_family():
    question = question_of("motion_blur_2020", Effect(0.8, standardised=True))
    (row,) = simulate_power(question, (16,), studies=200, seed=1)
    assert question.holm_tests == 4
    assert row.adjusted is not None
    assert row.adjusted.share < row.power.share
    assert "holm_power" in to_csv([cells(row)])
    assert "Holm" in draw_power(question, [row, row._replace(n=20)]).svg


def test_resampled_differences_have_the_mean_that_is_asked_for_in_whole_steps():
    random = np.random.default_rng(2)
    generator = ResampledDifferences((-2, 0, 0, 1, 5, 7), effect_steps=1.3)
    drawn = generator.draw(random, 40_000)
    assert drawn.dtype == np.int64
    assert drawn.mean() == pytest.approx(1.3, abs=0.08)
    as_is = ResampledDifferences((-2, 0, 0, 1, 5, 7)).draw(random, 2000)
    assert set(as_is.tolist()) == {-2, 0, 1, 5, 7}


def test_a_pilot_gives_its_own_differences_and_steps(tmp_path):
    study = carnegie_like(tmp_path / "study").folder
    _, pilot = read_pilot(study, "carnegie_2015")
    assert len(pilot.differences) == 6
    question = question_of("carnegie_2015", Effect(10.0, standardised=False), pilot=study)
    assert isinstance(question.generator, ResampledDifferences)
    assert question.generator.effect_steps == pytest.approx(10 / pilot.unit)
    as_is = question_of("carnegie_2015", None, pilot=study)
    (row,) = simulate_power(as_is, (8,), studies=200, seed=0)
    assert row.t_test_formula is None
    assert 0 <= row.power.low < row.power.high <= 1


@pytest.mark.slow
def test_the_smallest_effect_is_found_with_the_power_asked_for():
    test = PairedTest("paired_t")
    effect = smallest_effect(test, 20, power=0.8, studies=1000, seed=1)
    assert effect is not None
    assert t_test_power(effect, 20, 0.05, "two-sided") == pytest.approx(0.8, abs=0.04)
    less = smallest_effect(PairedTest("paired_t", "less"), 20, power=0.8, studies=1000, seed=1)
    assert less is not None
    assert -effect < less < 0
    assert (
        smallest_effect(PairedTest(), 4, power=0.8, studies=50, seed=1) is None
    )  # p is 1/8 at least


def test_ranges_and_effects_are_read_or_refused_in_a_sentence():
    assert parse_participants("8:12:2") == (8, 10, 12)
    assert parse_participants("8:13:2") == (8, 10, 12, 13)
    assert parse_participants("20") == (20,)
    assert parse_participants("8:60")[-1] == 60
    for text in ("x", "8:", "60:8", "1:5", "8:5000", "8:60:0"):
        with pytest.raises(InputError, match="--participants"):
            parse_participants(text)
    assert Effect.of_text(" 0.5SD") == Effect(0.5, standardised=True)
    assert Effect.of_text("-12") == Effect(-12, standardised=False)
    for text in ("much", "nan", "1e9", ""):
        with pytest.raises(InputError, match="--effect"):
            Effect.of_text(text)
    with pytest.raises(InputError, match="--sd"):
        question_of("carnegie_2015", Effect(10.0, standardised=False))
    with pytest.raises(InputError, match="--pilot"):
        question_of("carnegie_2015", None)


def test_a_test_that_is_not_simulated_is_told_with_its_place(tmp_path):
    file = tmp_path / "plan.toml"
    for line, what in (('test = "sign"', "`sign`"), ('between = "group"', "groups")):
        file.write_text(f'name = "x"\ntitle = "x"\n[[contrasts]]\na = "u"\nb = "v"\n{line}\n')
        with pytest.raises(InputError, match=what) as refusal:
            question_of(str(file), Effect(0.5, standardised=True))
        assert refusal.value.line
    file.write_text(file.read_text().replace(line, 'test = "paired_t"'))
    assert question_of(str(file), Effect(0.5, standardised=True)).test.name == "paired_t"


PLAN = """name = "asked"
title = "With the smallest effect"
outcomes = ["T"]
smallest_effect_power = 0.8
"""


@pytest.mark.slow
def test_a_page_says_the_smallest_effect_where_the_plan_asks(tmp_path):
    study = carnegie_like(tmp_path / "study").folder
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    made = build_report(study, plan=plan, out=tmp_path / "report")
    (row,) = json.loads(made.results.read_text())["smallest_effects"]
    assert row["n"] == 6
    power = t_test_power(row["effect_sd"], 6, 0.05, "two-sided")
    assert 0.75 < power < 1
    assert f"{row['effect_sd']:.2f} standard deviations" in made.index.read_text()
    assert read_plan(PLAN.replace("smallest_effect_power = 0.8\n", ""), None) != read_plan(
        PLAN, None
    )
