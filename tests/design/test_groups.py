"""How people come into groups: permuted blocks, minimisation, and chance alone."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from tests.support.protocols import COVARIATES, GROUPS, generated, grouped
from vrcomfort.design import Enrolment, build_design
from vrcomfort.errors import InputError

BY = 'by = ["sex", "age", "susceptibility"]'
BLOCKS = f'method = "permuted_blocks"\nrounds = [2]\n{BY}'


def people(number, seed):
    rng = np.random.default_rng(seed)
    return [
        {
            "sex": str(rng.choice(["female", "male"])),
            "age": str(rng.integers(18, 71)),
            "susceptibility": str(rng.choice(["low", "middle", "high"])),
        }
        for _ in range(number)
    ]


def band_of_age(age):
    return "young" if float(age) < 30 else "middle" if float(age) < 50 else "old"


def levels(known):
    return known["sex"], band_of_age(known["age"]), known["susceptibility"]


def enrolled(protocol, known, seed):
    """Return the group of each."""
    design = build_design(protocol, seed=seed)
    plan = design.plan(len(known), covariates=known)
    assert all(each.name.startswith(f"{each.group}-") for each in plan)
    return [each.group for each in plan]


def widest_margin(groups, known):
    """Return the greatest difference of groups at a level of a covariate."""
    counts = Counter(
        (factor, level, group)
        for group, each in zip(groups, known, strict=True)
        for factor, level in enumerate(levels(each))
    )
    margins = {(factor, level) for factor, level, _ in counts}
    return max(abs(counts[(*margin, "near")] - counts[(*margin, "far")]) for margin in margins)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("rounds", "most"), [([1], 1), ([2], 2), ([1, 2, 3], 3)])
def test_blocks_stay_within_half_a_block_in_every_stratum_at_every_moment(seed, rounds, most):
    known = people(120, seed)
    groups = enrolled(grouped(f"rounds = {rounds}\n{BY}"), known, seed)
    difference = Counter()
    reached = set()
    for group, each in zip(groups, known, strict=True):
        difference[levels(each)] += 1 if group == "near" else -1
        assert abs(difference[levels(each)]) <= most  # a block has 2 × rounds places
        reached.add(abs(difference[levels(each)]))
    assert reached >= {0, 1}


def test_blocks_of_one_stratum_do_not_follow_those_of_another():
    protocol = grouped('rounds = [3]\nby = ["sex"]')
    plans = {
        sex: enrolled(protocol, [{**p, "sex": sex} for p in people(24, 0)], 0)
        for sex in ("female", "male")
    }
    assert plans["female"] != plans["male"]


def test_unequal_shares_are_kept_in_every_block():
    tables = GROUPS.replace('name = "near"', 'name = "near"\nshare = 2')
    design = build_design(generated("williams", 4, "", f"{tables}[allocation]\nrounds = [1]\n"))
    groups = [each.group for each in design.plan(30)]
    for start in range(0, 30, 3):
        assert sorted(groups[start : start + 3]) == ["far", "near", "near"]


def test_minimisation_keeps_margins_together_where_chance_does_not():
    minimised, chance = grouped(f'method = "minimisation"\n{BY}'), grouped('method = "simple"')
    by_chance = []
    for seed in range(2):
        known = people(200, seed)
        assert widest_margin(enrolled(minimised, known, seed), known) <= 4
        by_chance.append(widest_margin(enrolled(chance, known, seed), known))
    assert np.mean(by_chance) > 8


def test_minimisation_by_hand():
    """Three people are there; a fourth, of their sex, must balance with certainty."""
    protocol = grouped('method = "minimisation"\np_best = 1.0\nby = ["sex"]')
    design = build_design(protocol, seed=0)
    of_sex = {"sex": "male", "age": "20", "susceptibility": "low"}
    there = [Enrolment("near-s1", covariates=of_sex), Enrolment("near-s2", covariates=of_sex)]
    women = {**of_sex, "sex": "female"}
    assert design.assign([*there, Enrolment("far-s1", covariates=women)], of_sex).group == "far"
    gone = [Enrolment("near-s1", "withdrawn", of_sex), Enrolment("near-s2", "excluded", of_sex)]
    groups = {build_design(protocol, seed=s).assign(gone, of_sex).group for s in range(30)}
    assert groups == {"near", "far"}  # nobody is left to be balanced


def test_the_worse_group_comes_sometimes_and_not_often():
    protocol = grouped('method = "minimisation"\np_best = 0.8\nby = ["sex"]')
    of_sex = {"sex": "male", "age": "20", "susceptibility": "low"}
    there = [Enrolment("near-s1", covariates=of_sex)]
    groups = [build_design(protocol, seed=s).assign(there, of_sex).group for s in range(300)]
    assert 0.7 < groups.count("far") / 300 < 0.9


@pytest.mark.parametrize(
    "allocation", [BLOCKS, f'method = "minimisation"\n{BY}', 'method = "simple"']
)
def test_allocation_depends_on_the_seed_alone(allocation):
    protocol, known = grouped(allocation), people(60, 0)
    assert enrolled(protocol, known, 5) == enrolled(protocol, known, 5)
    assert len({tuple(enrolled(protocol, known, seed)) for seed in range(5)}) > 1


def test_the_place_of_somebody_who_withdrew_in_a_block_goes_to_the_next():
    design = build_design(grouped('rounds = [2]\nby = ["sex"]'), seed=1)
    known = [{**each, "sex": "male"} for each in people(8, 0)]
    names = [each.name for each in design.plan(4, covariates=known[:4])]
    there = [Enrolment(n, covariates=k) for n, k in zip(names, known, strict=False)]
    for gone in range(4):
        now = [
            Enrolment(e.sequence, "withdrawn", e.covariates) if i == gone else e
            for i, e in enumerate(there)
        ]
        assert design.assign(now, known[4]).name == names[gone]


def test_places_stay_where_the_protocol_says_so():
    kept = build_design(generated("williams", 4, "return_places = false\n"))
    names = [each.name for each in kept.plan(4)]
    there = [Enrolment(names[0], "withdrawn"), *map(Enrolment, names[1:3])]
    assert kept.assign(there).name == names[3]
    returned = build_design(generated("williams", 4))
    assert returned.assign(there).name == names[0]


def test_every_group_meets_its_conditions_in_balanced_orders():
    design = build_design(grouped("rounds = [1]"))
    plan = design.plan(16)
    assert {(each.group, t.condition) for each in plan for t in each.trials} == {
        ("near", "c0"), ("near", "c1"), ("far", "c2"), ("far", "c3"),
    }  # fmt: skip
    assert set(Counter(each.name for each in plan).values()) == {4}


@pytest.mark.parametrize("rule", ["random", "block_random"])
def test_groups_with_orders_of_their_own(rule):
    design = build_design(grouped("rounds = [1]", rule=rule))
    plan = design.plan(6)
    for number, each in enumerate(plan, start=1):
        assert each.name == f"{each.group}-r{number}"
        assert design.sequence(each.name) == each


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (
            {"sex": "male", "age": "20"},
            "needs the covariate `susceptibility`; add .*=low|middle|high",
        ),
        ({"sex": "m", "age": "20", "susceptibility": "low"}, "must be one of female, male, got"),
        ({"sex": "male", "age": "17", "susceptibility": "low"}, "a number from 18 to 70, got `17`"),
        ({"sex": "male", "age": "٣٠", "susceptibility": "low"}, "a number from 18 to 70"),
        ({"sex": "male", "age": "nan", "susceptibility": "low"}, "a number from 18 to 70"),
        ({"sxe": "male"}, "no covariate `sxe`; did you mean `sex`"),
    ],
)
def test_covariates_that_cannot_be_are_refused(given, says):
    with pytest.raises(InputError, match=says):
        build_design(grouped(BLOCKS)).checked(given)


def test_bands_of_a_number():
    (age,) = [each for each in grouped(BLOCKS).covariates if each.name == "age"]
    assert age.bands == ("<30", "30 to <50", "50+")
    assert [age.band(x) for x in ("18", "29.9", "30", "49", "50", "70")] == [
        "<30", "<30", "30 to <50", "30 to <50", "50+", "50+",
    ]  # fmt: skip


def test_people_who_are_not_there_are_drawn_within_bounds():
    design = build_design(generated("williams", 2, "", COVARIATES), seed=3)
    drawn = [design.simulated_covariates(number) for number in range(200)]
    assert drawn == [design.simulated_covariates(number) for number in range(200)]
    ages = [int(each["age"]) for each in drawn]
    assert min(ages) >= 18
    assert max(ages) <= 70
    assert len(set(ages)) > 30
    assert {each["sex"] for each in drawn} == {"female", "male"}
