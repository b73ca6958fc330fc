from __future__ import annotations

import pytest

from tests.support.protocols import generated
from vrcomfort.design import Enrolment, audit, build_design
from vrcomfort.errors import InputError
from vrcomfort.protocol import load_protocol


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_twenty_participants_of_carnegie_2015(seed):
    design = build_design(load_protocol("carnegie_2015"), seed=seed)
    found = audit(design, design.plan(20))
    assert found.conditions.first == {"dof_off": 10, "dof_on": 10}
    assert set(found.sequences.values()) == {5}
    assert found.crossing == {
        (condition, scene): 5
        for condition in ("dof_off", "dof_on")
        for scene in ("mountain", "temple")
    }
    assert found.conditions.positions == {"dof_off": (20, 20), "dof_on": (20, 20)}
    assert found.scenes.positions == {"mountain": (20, 20), "temple": (20, 20)}
    assert "divide evenly" in found.remainder


def test_what_happens_when_the_number_does_not_divide():
    design = build_design(load_protocol("carnegie_2015"), seed=3)
    found = audit(design, design.plan(23))
    assert sorted(found.sequences.values()) == [5, 6, 6, 6]
    assert "do not divide by 4" in found.remainder
    assert "1 further participant would" in found.remainder


def test_shuffled_assignment_fills_round_by_round_and_depends_on_the_seed_alone():
    protocol = load_protocol("carnegie_2015")
    plans = [[each.name for each in build_design(protocol, seed=s).plan(24)] for s in range(6)]
    assert len({tuple(plan) for plan in plans}) > 1
    assert plans[0] == [each.name for each in build_design(protocol, seed=0).plan(24)]
    for plan in plans:
        for start in range(0, 24, 4):
            assert len(set(plan[start : start + 4])) == 4


def test_the_place_of_somebody_who_withdrew_goes_to_the_next():
    design = build_design(load_protocol("carnegie_2015"), seed=0)
    names = [sequence.name for sequence in design.plan(4)]
    enrolled = [Enrolment(name, "completed") for name in names]
    enrolled[2] = Enrolment(names[2], "withdrawn")
    assert design.assign(enrolled).name == names[2]
    enrolled[2] = Enrolment(names[2], "excluded")
    assert design.assign(enrolled).name == names[2]


def test_generated_rules_order_every_pair_and_deal_it_over_sessions():
    design = build_design(generated("williams", 4, "sessions = 2\n"))
    assert len(design.sequences) == 4
    assert all([len(session) for session in each.sessions] == [2, 2] for each in design.sequences)
    assert len(build_design(generated("full", 4)).sequences) == 24


def test_random_orders_are_seeded_and_found_again_by_name():
    design = build_design(generated("random", 5), seed=7)
    plan = design.plan(3)
    assert [each.name for each in plan] == ["r1", "r2", "r3"]
    assert design.sequence("r2") == plan[1]
    assert plan != build_design(generated("random", 5), seed=8).plan(3)
    assert all(len({trial.condition for trial in each.trials}) == 5 for each in plan)
    assert "no number has to divide" in audit(design, plan).remainder


def test_an_unknown_sequence_is_refused():
    with pytest.raises(InputError, match="no sequence `zz`"):
        build_design(load_protocol("carnegie_2015")).sequence("zz")


def test_rules_that_cannot_be_followed_are_refused():
    with pytest.raises(InputError, match="at most 6"):
        generated("full", 7)
    remedies = "choose 2 or 4, or show all of them in each .*`unbalanced = true`"
    with pytest.raises(InputError, match=f"cannot be dealt evenly over 3 sessions: {remedies}"):
        generated("williams", 4, "sessions = 3\n")
    with pytest.raises(InputError, match=r"over 5 sessions: choose 4, or show .*\[\[parts\]\]$"):
        generated("williams", 4, "sessions = 5\nunbalanced = true\n")


def test_sessions_differ_by_an_exposure_where_that_is_allowed():
    for rule in ("williams", "random"):
        design = build_design(generated(rule, 5, "sessions = 3\nunbalanced = true\n"))
        for person in design.plan(10):
            assert [len(session) for session in person.sessions] == [2, 2, 1]
            assert len({trial.condition for trial in person.trials}) == 5


def test_audit_counts_carry_over_within_sessions():
    design = build_design(generated("williams", 4))
    pairs = audit(design, design.plan(4)).conditions.carry_over
    assert len(pairs) == 12
    assert set(pairs.values()) == {1}
