"""Parts of a study: orders that do not depend on each other, and a column in what is recorded."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.support.resume import go, rows
from tests.support.study import PROTOCOL, Scripted, tiny_protocol
from vrcomfort.design import Enrolment, audit, audit_study, build_design
from vrcomfort.design.audit import AdministeredOrder, cannot_balance
from vrcomfort.errors import InputError
from vrcomfort.exchange.status import status_of
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol import load_protocol
from vrcomfort.records import read_participants
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.schema import columns_of_version
from vrcomfort.report.facts import Facts
from vrcomfort.report.plan import Plan
from vrcomfort.report.planned import planned_exposures
from vrcomfort.report.study_data import read_study

PLAN = Plan(name="usual", title="Usual")
A = '{ scene = "room.glb", condition = "plain" }'
B = '{ scene = "room.glb", condition = "blur" }'
ORDERS = f"""
[[parts.orders]]
name = "ab"
trials = [{A}, {B}]
[[parts.orders]]
name = "ba"
trials = [{B}, {A}]
"""
PARTS = f"""
[[parts]]
name = "single"
{ORDERS}
[[parts]]
name = "in_turn"
repeats = 2
{ORDERS}
"""
_start, _end = PROTOCOL.index("[order]"), PROTOCOL.index("[[questionnaires]]")
TEXT = f'{PROTOCOL[:_start]}[order]\nrule = "parts"\nassignment = "shuffled"\n{PROTOCOL[_end:]}'


GROUPS = '\n[[groups]]\nname = "calm"\n[[groups]]\nname = "wild"\n'
OWN = f"""
[[parts]]
name = "common"
{ORDERS}
[[parts]]
name = "own"
orders = [
  {{ name = "one", group = "calm", trials = [{A}, {B}] }},
  {{ name = "two", group = "calm", trials = [{B}, {A}] }},
  {{ name = "long", group = "wild", trials = [{B}, {B}, {B}, {A}] }},
]
"""


def in_parts(folder, more=PARTS):
    return tiny_protocol(folder, TEXT + more)


def test_each_part_is_balanced_and_says_nothing_of_the_other(tmp_path):
    design = build_design(in_parts(tmp_path), seed=4)
    plan = design.plan(400)
    for start in range(0, 400, 2):  # as soon as it can be
        pair = plan[start : start + 2]
        for first in (0, 2):
            assert {each.trials[first].condition for each in pair} == {"plain", "blur"}
    crossed = Counter((each.trials[0].condition, each.trials[2].condition) for each in plan)
    assert len(crossed) == 4
    assert all(abs(count - 100) < 40 for count in crossed.values())  # 4 standard deviations
    whole = [trial.condition for trial in plan[0].trials]
    assert whole[2:4] == whole[4:6]  # met twice, one after the other
    assert [trial.part for trial in plan[0].trials] == ["single"] * 2 + ["in_turn"] * 4


def test_the_next_participant_fills_what_a_withdrawn_one_left(tmp_path):
    design = build_design(in_parts(tmp_path), seed=1)
    before = [Enrolment("ab-ab", "withdrawn"), Enrolment("ba-ab"), Enrolment("ab-ba")]
    assert design.assign(before).name in {"ab-ab", "ba-ba", "ab-ba", "ba-ab"}
    alone = design.assign([Enrolment("ab-ab", "withdrawn"), Enrolment("ba-ab")])
    assert alone.name == "ab-ba"


def test_the_balance_is_that_of_each_part(tmp_path):
    design = build_design(in_parts(tmp_path))
    assert cannot_balance(design, 30) is None  # 30 do not divide by four combinations
    assert cannot_balance(design, 31) == (
        "31 participants do not divide by the 2 and 2 orders of the parts, so that some orders "
        "are met by more people; choose 30 or 32"
    )
    found = audit(design, design.plan(6))
    assert found.remainder == (
        "The parts' orders are dealt by themselves, evenly: ab × 3, ba × 3; ab × 3, ba × 3."
    )
    people = [AdministeredOrder("P01", Enrolment("ab-ab"), design.sequence("ab-ab"))]
    assert audit_study(design, people).next_orders == ("ba-ba",)


def test_rules_make_orders_and_parts_may_be_in_different_sessions(tmp_path):
    made = '\n[[parts]]\nname = "a"\nrule = "all_orders"\n'
    late = '\n[[parts]]\nname = "b"\nsession = 2\nrule = "latin_square"\nconditions = ["blur"]\n'
    protocol = in_parts(tmp_path, made + late)
    design = build_design(protocol)
    assert [each.name for each in design.sequences] == ["a_1-b_1", "a_2-b_1"]
    first, second = design.sequences[0].sessions
    assert [trial.part for trial in (*first, *second)] == ["a", "a", "b"]


def test_each_group_has_its_own_orders_dealt_within_it(tmp_path):
    design = build_design(in_parts(tmp_path, GROUPS + OWN), seed=2)
    assert {each.name for each in design.sequences} == {
        *(f"calm-{a}-{b}" for a in ("ab", "ba") for b in ("one", "two")),
        "wild-ab-long", "wild-ba-long",
    }  # fmt: skip
    plan = design.plan(80)
    for group, length in (("calm", 4), ("wild", 6)):
        own = [each for each in plan if each.group == group]
        assert len(own) == 40
        assert {each.name.split("-")[0] for each in own} == {group}
        assert {len(each.trials) for each in own} == {length}
        for start in range(0, 40, 2):  # balanced in the group as soon as it can be
            pair = own[start : start + 2]
            assert {each.trials[0].condition for each in pair} == {"plain", "blur"}
    crossed = Counter(each.name for each in plan if each.group == "calm")
    assert len(crossed) == 4


def test_orders_that_a_rule_makes_are_of_the_groups_conditions(tmp_path):
    groups = GROUPS.replace('"wild"', '"wild"\nconditions = ["blur"]')
    design = build_design(
        in_parts(tmp_path, groups + '\n[[parts]]\nname = "a"\nrule = "williams"\n')
    )
    met = {each.name: [trial.condition for trial in each.trials] for each in design.sequences}
    assert met == {
        "calm-a_1": ["plain", "blur"], "calm-a_2": ["blur", "plain"], "wild-a_1": ["blur"]
    }  # fmt: skip


def test_the_balance_of_groups_is_that_of_each_of_their_parts(tmp_path):
    design = build_design(in_parts(tmp_path, GROUPS + OWN))
    assert cannot_balance(design, 32) is None
    assert cannot_balance(design, 31) == (
        "31 participants cannot be divided among 2 equal groups; choose 30 or 32"
    )
    assert cannot_balance(design, 30) == (
        "30 participants do not divide by the 2 and 2, or 2 and 1 orders of the parts of 2 groups, "
        "so that some orders are met by more people; choose 28 or 32"
    )
    assert audit(design, design.plan(8)).remainder == (
        "The parts' orders of group calm are dealt by themselves, evenly: ab × 2, ba × 2; one × 2, "
        "two × 2. The parts' orders of group wild are dealt by themselves, evenly: ab × 2, ba × 2; "
        "long × 4."
    )
    people = [
        AdministeredOrder("P01", Enrolment("calm-ab-one"), design.sequence("calm-ab-one")),
        AdministeredOrder("P02", Enrolment("wild-ba-long"), design.sequence("wild-ba-long")),
    ]
    assert audit_study(design, people).next_orders == ("calm-ba-two", "wild-ab-long")


def test_groups_and_parts_are_run_recorded_and_planned(tmp_path):
    protocol = in_parts(tmp_path, GROUPS + OWN.replace('"one"', f'"{"o" * 70}"'))
    for participant in ("P01", "P02", "P03", "P04"):
        assert go(tmp_path, protocol=protocol, participant=participant).status == "completed"
    assert not verify_study(tmp_path / "S").faults
    rows_of = {row.participant: row for row in read_participants(tmp_path / "S")}
    groups = Counter(row.group for row in rows_of.values())
    assert groups == {"calm": 2, "wild": 2}
    study = read_study(tmp_path / "S")
    parts = {
        who: [trial["part"] for trial in study.trials if trial["participant"] == who]
        for who in rows_of
    }
    length = {"calm": 2, "wild": 4}
    for who, row in rows_of.items():
        assert row.sequence.startswith(f"{row.group}-")
        assert parts[who] == ["common"] * 2 + ["own"] * length[row.group]
    posts = [sheet for sheet in study.sheets if sheet.timepoint == "post"]
    # Both groups met plain twice; blur as often as each has it.
    assert planned_exposures(study, PLAN, posts[:2], "ssq")["plain"] == 2
    state = status_of(tmp_path / "S")
    assert state.next_sequence in {each.name for each in build_design(protocol).sequences}


def test_files_have_the_part_of_each_exposure_and_reports_plan_those_of_all_parts(tmp_path):
    protocol = in_parts(tmp_path)
    assert go(tmp_path, Scripted(), protocol=protocol).status == "completed"
    assert [row["part"] for row in rows(tmp_path, "trials")] == ["single"] * 2 + ["in_turn"] * 4
    answers = rows(tmp_path, "questionnaires")
    assert {row["part"] for row in answers if row["trial"] in {"1", "2"}} == {"single"}
    assert {row["part"] for row in answers if row["trial"] == "5"} == {"in_turn"}
    assert {row["part"] for row in answers if not row["trial"]} == {""}  # of both
    assert not verify_study(tmp_path / "S").faults
    study = read_study(tmp_path / "S")
    posts = [sheet for sheet in study.sheets if sheet.timepoint == "post"]
    facts = Facts.of(study, PLAN)
    assert [facts.row(sheet)["part"] for sheet in posts] == ["single"] * 2 + ["in_turn"] * 4
    few = posts[:2]  # of whoever stopped early
    assert planned_exposures(study, PLAN, few, "ssq") == {"plain": 3, "blur": 3}


def test_answers_about_a_session_of_one_part_have_it(tmp_path):
    only = PARTS[: PARTS.index('[[parts]]\nname = "in_turn"')]
    go(tmp_path, Scripted(), protocol=in_parts(tmp_path, only))
    assert {row["part"] for row in rows(tmp_path, "questionnaires")} == {"single"}


def test_an_interrupted_session_keeps_its_parts(tmp_path):
    protocol = in_parts(tmp_path)
    go(tmp_path, Scripted(), protocol=protocol, interrupt=(4, 20))
    go(tmp_path, Scripted(), protocol=protocol, resume=True)
    told = [(row["trial"], row["status"], row["part"]) for row in rows(tmp_path, "trials")]
    assert told[3:5] == [("4", "aborted", "in_turn"), ("4", "completed", "in_turn")]
    assert not verify_study(tmp_path / "S").faults


def test_trials_that_are_written_down_may_name_their_part(tmp_path):
    text = PROTOCOL.replace('condition = "plain" }', 'condition = "plain", part = "calm" }')
    go(tmp_path, Scripted(), protocol=tiny_protocol(tmp_path, text))
    assert [row["part"] for row in rows(tmp_path, "trials")] == ["calm", ""]


def test_studies_of_older_versions_lack_the_column():
    columns = TrialRow.columns()
    third, fourth = (set(columns_of_version(v, "trials.csv", columns)) for v in (3, 4))
    assert fourth - third == {"part"}


def test_hillaires_parts_are_those_of_the_paper():
    protocol = load_protocol("hillaire_2008")
    plan = build_design(protocol, seed=7).plan(30)
    for each in plan:
        assert [trial.part for trial in each.trials] == ["single"] * 2 + ["in_turn"] * 6
    crossed = Counter((each.trials[0].condition, each.trials[2].condition) for each in plan)
    assert len(crossed) == 4


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (TEXT, "needs [[parts]] with their orders; add them"),
        (PROTOCOL + PARTS, '[[parts]] do nothing with rule = "explicit"'),
        (TEXT + PARTS.replace(', condition = "blur"', ', condition = "blurr"', 1), "blurr"),
        (TEXT + PARTS.replace("in_turn", "single"), "`single` is there twice"),
        (TEXT + PARTS.replace('"ba"', '"ab"', 1), "`ab` is there twice"),
        (TEXT + PARTS.replace(f"[{B}, {A}]", f"[{B}]", 1), "are not of the same length"),
        (TEXT + PARTS.replace("repeats = 2", "session = 3"), "count sessions from 1, without gaps"),
        (TEXT + '\n[[parts]]\nname = "a"\n', "`explicit` needs at least one [[parts.orders]]"),
        (TEXT + PARTS + 'rule = "williams"\n', None),
        (
            TEXT + "".join(f'\n[[parts]]\nname = "p{n}"\nrule = "williams"\n' for n in range(14)),
            "the parts' orders have more than 10000 combinations; give them fewer orders",
        ),
        (TEXT + '\n[[parts]]\nname = "a"\nrule = "williams"\n' + ORDERS, "makes its own orders"),
        (TEXT + PARTS.replace("repeats = 2", 'scenes = ["room.glb"]'), "`scenes` does nothing"),
        (TEXT + PARTS.replace('"ba"', '"ba"\ngroup = "calm"', 1), "there are no [[groups]]"),
        (TEXT + GROUPS + PARTS.replace('"ba"', '"ba"\ngroup = "clam"', 1), "did you mean `calm`?"),
        (
            TEXT
            + GROUPS
            + '\n[[parts]]\nname = "a"\n'
            + ORDERS.replace('"ab"', '"ab"\ngroup = "calm"').replace(
                '"ba"', '"ba"\ngroup = "calm"'
            ),
            "group `wild` has no order of part `a`",
        ),
        (
            TEXT + GROUPS.replace('"wild"', '"wild"\nconditions = ["blur"]') + PARTS,
            "group `wild` does not meet condition `plain`",
        ),
        (
            TEXT
            + GROUPS.replace('"wild"', '"wild"\nconditions = ["blur"]')
            + '\n[[parts]]\nname = "a"\nrule = "williams"\nconditions = ["plain"]\n',
            "group `wild` meets no condition of part `a`",
        ),
    ],
)
def test_parts_that_cannot_be_met_are_refused(tmp_path, text, says):
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text)
    assert says is None or any(
        says in str(each) for each in (caught.value.alone, *caught.value.others)
    )


def test_a_session_questionnaire_inherits_a_condition_that_all_its_trials_share(tmp_path):
    """Two sessions, each asked about as a whole alone."""
    start, end = PROTOCOL.index("sessions = ["), PROTOCOL.index("[[questionnaires]]")
    text = f"{PROTOCOL[:start]}sessions = [[{A}, {A}], [{A}, {B}]]\n{PROTOCOL[end:]}"
    text = text.replace('when = "after_trial"', 'when = "session_end"')
    go(tmp_path, Scripted(), protocol=tiny_protocol(tmp_path, text), sessions=[1, 2])
    study = read_study(tmp_path / "S")
    facts = Facts.of(study, PLAN)
    asked = [sheet for sheet in study.sheets if sheet.timepoint == "post"]
    assert {sheet.condition for sheet in asked} == {""}
    found = {sheet.session: facts.row(sheet)["condition"] for sheet in asked}
    assert found == {"1": "plain", "2": ""}
