"""What a protocol may say of orders, groups and factors, and what it is told where it may not."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tests.support.protocols import COVARIATES, GROUPS, generated, grouped
from tests.support.study import PROTOCOL, tiny_protocol
from vrcomfort.design import build_design
from vrcomfort.errors import InputError
from vrcomfort.protocol import load_protocol
from vrcomfort.resources import data_folder

FACTORS = """
[[factors]]
name = "blur"
[[factors.levels]]
name = "sharp"
[[factors.levels]]
name = "dof"
label = "Depth of field"
[factors.levels.depth_of_field]
law = "dioptre"
[[factors]]
name = "streaks"
[[factors.levels]]
name = "still"
[[factors.levels]]
name = "moving"
[factors.levels.motion_blur]
mode = "full"
[factors.levels.depth_of_field]
max_radius_percent = 1.0
"""


def test_the_former_word_for_all_orders_is_understood():
    assert generated("full", 3).order.rule == "all_orders"


def test_a_latin_square_differs_by_seed_and_is_found_again():
    protocol = generated("latin_square", 6)
    squares = [build_design(protocol, seed=seed).sequences for seed in range(4)]
    assert len(set(squares)) == 4
    assert build_design(protocol, seed=2).sequences == squares[2]
    for square in squares:
        assert len(square) == 6
        columns = zip(*(each.trials for each in square), strict=True)
        assert all(len({trial.condition for trial in column}) == 6 for column in columns)


def test_block_random_shows_every_block_and_keeps_its_limits():
    design = build_design(generated("block_random", 3, "blocks = 4\nsessions = 2\n"), seed=1)
    plan = design.plan(10)
    assert len({tuple(each.trials) for each in plan}) == 10
    for each in plan:
        names = [trial.condition for trial in each.trials]
        assert [len(session) for session in each.sessions] == [6, 6]
        assert all(len(set(names[start : start + 3])) == 3 for start in range(0, 12, 3))
        assert all(before != after for before, after in pairwise(names))


def crossed(folder, factors=FACTORS, order='rule = "williams"'):
    conditions = PROTOCOL[PROTOCOL.index("[[conditions]]") : PROTOCOL.index("[order]")]
    text = PROTOCOL.replace(conditions, factors)
    explicit = text[text.index('rule = "explicit"') : text.index("[[questionnaires]]")]
    return tiny_protocol(folder, text.replace(explicit, f"{order}\n"))


def test_a_quality_may_say_something_in_one_of_a_levels_conditions_alone(tmp_path):
    factors = FACTORS.replace('name = "still"', 'name = "still"\nquality = "fast"')
    qualities = [each.quality for each in crossed(tmp_path, factors).conditions]
    assert qualities == ["fast", None, "fast", None]


def test_factors_are_crossed_to_conditions(tmp_path):
    protocol = crossed(tmp_path)
    assert [each.name for each in protocol.conditions] == [
        "sharp_still", "sharp_moving", "dof_still", "dof_moving",
    ]  # fmt: skip
    both = protocol.condition("dof_moving")
    assert both.levels == {"blur": "dof", "streaks": "moving"}
    assert both.label == "Depth of field + moving"
    assert (both.depth_of_field.law, both.depth_of_field.max_radius_percent) == ("dioptre", 1.0)
    assert both.motion_blur.mode == "full"
    neither = protocol.condition("sharp_still")
    assert neither.depth_of_field is None
    assert neither.motion_blur is None
    assert len(build_design(protocol).sequences) == 4


def test_limits_may_name_a_factor(tmp_path):
    order = 'rule = "block_random"\nblocks = 3\nmax_run = { blur = 1 }\nstrata = "streaks"'
    for each in build_design(crossed(tmp_path, order=order)).plan(5):
        blur = [trial.condition.split("_")[0] for trial in each.trials]
        streaks = [trial.condition.split("_")[1] for trial in each.trials]
        assert all(before != after for before, after in pairwise(blur))
        assert all(len(set(streaks[n : n + 2])) == 2 for n in range(0, 12, 2))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("max_radius_percent = 1.0", 'law = "dioptre"', "factor `blur` sets `depth_of_field.law`"),
        ('name = "sharp"', 'name = "dof"', "`dof_still` is there twice"),
        ('law = "dioptre"', "pupil_mm = 3.0", '`pupil_mm` does nothing with law = "linear"'),
        ('mode = "full"', 'mod = "full"', "did you mean `mode`?"),
    ],
)  # fmt: skip
def test_factors_that_cannot_be_crossed_are_told(tmp_path, old, new, says):
    assert old in FACTORS
    with pytest.raises(InputError) as caught:
        crossed(tmp_path, FACTORS.replace(old, new, 1))
    assert says in str(caught.value)
    assert caught.value.line is not None
    assert caught.value.line > 6


def test_conditions_beside_factors_are_refused(tmp_path):
    with pytest.raises(InputError, match="conditions are written down and crossed"):
        crossed(tmp_path, f'[[conditions]]\nname = "x"\n{FACTORS}')


def test_a_study_without_conditions_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is nothing to show"):
        crossed(tmp_path, "")


def test_levels_that_make_an_impossible_condition(tmp_path):
    level = FACTORS.replace("max_radius_percent = 1.0", "peripheral = {}").replace(
        'law = "dioptre"', 'law = "dioptre"\nviews = 4'
    )
    with pytest.raises(InputError, match="these levels cannot be combined: views > 1 cannot be"):
        crossed(tmp_path, level)


@pytest.mark.parametrize(
    ("rule", "extra", "says"),
    [
        ("williams", "blocks = 2\n", '`blocks` does nothing with rule = "williams"'),
        ("block_random", 'assignment = "in_turn"\n', "`assignment` does nothing with rule"),
        ("block_random", "max_run = { sceen = 1 }\n", "no `sceen`; did you mean `scene`"),
        ("block_random", 'strata = "conditon"\n', "no `conditon`; did you mean `condition`"),
        ("block_random", "max_run = { scene = 1 }\n", "4 of 4 trials have scene `room.gltf`"),
        ("block_random", "blocks = 3\nsessions = 5\n", "12 condition-scene pairs cannot be dealt"),
    ],
)
def test_orders_that_cannot_be_are_told(rule, extra, says):
    with pytest.raises(InputError) as caught:
        generated(rule, 4, extra)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("tables", "says"),
    [
        (GROUPS.replace('"c3"', '"c9"'), "no condition `c9`"),
        ('[[groups]]\nname = "one"\n', "one group is no factor"),
        (GROUPS.replace("far", "near"), "`near` is there twice"),
        ('[allocation]\nmethod = "simple"\n', "no groups to divide people among"),
        (f'{GROUPS}[allocation]\nby = ["sex"]\n', "no covariate `sex`"),
        (f'{GROUPS}[allocation]\nmethod = "minimisation"\n', "minimisation needs covariates"),
        (f'{GROUPS}{COVARIATES}[allocation]\nmethod = "simple"\nby = ["sex"]\n', "`by` does noth"),
        (f"{GROUPS}[allocation]\np_best = 0.8\n", "`p_best` does nothing with method ="),
        (f'{GROUPS}{COVARIATES.replace("cuts = [30, 50]", "")}[allocation]\nby = ["age"]\n',
         "`age` is a number without `cuts`"),
        (COVARIATES.replace("[30, 50]", "[50, 30]"), "`cuts`: must rise"),
        (COVARIATES.replace("[30, 50]", "[10, 50]"), "the cut 10 is outside of the range"),
        (COVARIATES.replace('"sex"', '"sequence"'), "a column of participants.csv already"),
        (COVARIATES.replace('["female", "male"]', '["female"]'), "needs at least two levels"),
        (COVARIATES.replace('["female", "male"]', '["x", "y"]\ncuts = [1]'), "divide numbers"),
        (COVARIATES.replace("low = 18", "low = 80"), "`low` must be less than `high`"),
    ],
)  # fmt: skip
def test_groups_and_covariates_that_cannot_be_are_told(tables, says):
    with pytest.raises(InputError) as caught:
        generated("williams", 4, "", tables)
    assert says in str(caught.value)
    assert caught.value.line is not None


def test_explicit_sequences_name_their_groups(tmp_path):
    groups = '[[groups]]\nname = "x"\n[[groups]]\nname = "y"\n'
    x_alone = '[[groups]]\nname = "x"\n'
    with pytest.raises(InputError, match="has no group; with") as caught:
        tiny_protocol(tmp_path, PROTOCOL + x_alone)
    assert "2 more problems" in str(caught.value)
    with pytest.raises(InputError, match="no group `x`"):
        tiny_protocol(tmp_path, PROTOCOL.replace('name = "ab"', 'name = "ab"\ngroup = "x"'))
    named = PROTOCOL.replace("[order]", f"{groups}[order]")
    named = named.replace('name = "ab"', 'name = "ab"\ngroup = "x"')
    with pytest.raises(InputError, match="no sequence is group `y`'s"):
        tiny_protocol(tmp_path, named)


@pytest.mark.smoke
def test_every_shipped_protocol_has_a_design():
    for path in data_folder("protocols").glob("*.toml"):
        protocol = load_protocol(path)
        assert len(build_design(protocol).plan(protocol.participants or 20)) > 3


def test_allocation_without_a_table_is_by_blocks_of_the_whole_study():
    groups = [each.group for each in build_design(generated("williams", 4, "", GROUPS)).plan(40)]
    for start in range(0, 40, 4):
        assert sorted(groups[start : start + 4]) == ["far", "far", "near", "near"]
    assert grouped("rounds = [1]").allocation is not None
