"""Which of two: pairs of stimuli, preferences, and what a plan counts of them; sliders."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest

from tests.report.test_designs import results_of
from tests.support.protocols import NOBODY_LEAVES, explicit_order, protocol_text
from tests.support.session import rows, run
from tests.support.study import AheadHeadset, LateFocus, Scripted, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol import Simulation
from vrcomfort.questionnaire import score, shipped_instruments
from vrcomfort.report.analyses.preference import choices_of
from vrcomfort.report.study_data import read_study
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.respondent.base import Form
from vrcomfort.respondent.panel_layout import Act, cell_at, question_cells

PROTOCOL = protocol_text(
    """\
[[questionnaires]]
instrument = "two_intervals"
timepoint = "pair"
when = "after_trial"
compares = "pair"

[[questionnaires]]
instrument = "preference"
timepoint = "end"
when = "session_end"
compares = "session"
""",
    f"{NOBODY_LEAVES}liking = {{ blur = 20.0 }}\n",
    name="pairs",
    order=explicit_order(
        ab=[["plain", "blur", "blur", "plain"]], ba=[["blur", "plain", "plain", "blur"]]
    ),
)

PLAN = """
name = "liked"
title = "Liked"
exposure_timepoint = "pair"
outcomes = []
anova = []
mixed_model = []

[[preferences]]
name = "comfort"
item = "two_intervals.more_comfortable"
a = "blur"
b = "plain"

[[preferences]]
name = "fun"
item = "preference.prefer_fun"
a = "blur"
b = "plain"
"""


def do(folder, text=PROTOCOL, *, participant="P01", respondent=None, **more):
    folder.mkdir(exist_ok=True)
    protocol = tiny_protocol(folder, text)
    who = respondent or SimulatedRespondent(protocol.simulation, participant=participant, seed=0)
    return run(
        protocol,
        participant,
        study=folder / "S",
        respondent=who,
        load_scene=lambda _: "room",
        headset_for=lambda *_: AheadHeadset(),
        renderer=LateFocus(),
        **more,
    )


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pairs")
    for number in (1, 2):
        assert do(folder, participant=f"P{number:02d}").status == "completed"
    return folder / "S"


def test_a_pair_is_asked_about_after_its_second_exposure(study):
    found = rows(study.parent, "questionnaires.csv")
    asked = [(row["instrument"], row["trial"]) for row in found]
    assert asked == [
        ("two_intervals", "2"),
        ("two_intervals", "4"),
        *[("preference", "")] * 4,
    ]
    # Who likes blur chooses the second of plain, blur, the first of blur, plain, and at the end
    # the second that they had met.
    assert [row["response"] for row in found] == ["2", "1", "2", "2", "2", "2"]
    assert not verify_study(study).faults


def test_choices_are_conditions_whatever_the_order(study):
    read = read_study(study)
    assert {row["sequence"] for row in read.participants} == {"ab", "ba"}
    chosen = choices_of(read, "two_intervals.more_comfortable")
    assert chosen == {f"P{n:02d}": ["blur", "blur"] for n in (1, 2)}
    assert choices_of(read, "preference.prefer_fun")["P02"] == ["blur"]
    with pytest.raises(InputError, match=r"no question `preference.fun`.*prefer_fun"):
        choices_of(read, "preference.fun")


def test_a_plan_counts_who_preferred_what(study, tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN, encoding="utf-8")
    for row in results_of(study, plan)["preferences"]:
        assert (row["a"], row["b"], row["none"], row["n"]) == (2, 0, 0, 2)


def test_somebody_who_sees_no_difference_has_no_preference_where_that_may_be_said():
    settings = Simulation(indifference=1e6, question_hazard=0.0)
    person = SimulatedRespondent(settings, participant="P01", seed=0)
    heard = []
    for name in ("preference", "two_intervals"):
        form = Form(shipped_instruments()[name], "end", compared=("plain", "blur"))
        person.ask(form, lambda item, response, _: heard.append((item, response)))
    assert [response for _, response in heard[:4]] == [0] * 4
    assert heard[4][1] in (1, 2)


def test_choices_follow_thurstones_law():
    settings = Simulation(liking={"blur": 1.0}, question_hazard=0.0)
    form = Form(shipped_instruments()["two_intervals"], "end", compared=("plain", "blur"))
    counts: Counter[int | None] = Counter()
    for number in range(1500):
        person = SimulatedRespondent(settings, participant=f"P{number}", seed=0)
        person.ask(form, lambda _item, response, _s: counts.update([response]))
    # P(second) = Φ(1 / √2) = .7602
    assert counts[2] / 1500 == pytest.approx(0.7602, abs=0.035)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"two_intervals"', '"ssq"', r"item general_discomfort.*needs 1 and 2, or 0 to 2"),
        ('when = "after_trial"', 'when = "session_end"', "after its second exposure"),
        ("liking = { blur", "liking = { blurr", "no condition `blurr`"),
        ('compares = "pair"', 'compares = "pairs"', "did you mean `pair`"),
    ],
)
def test_faults_are_told_before_anybody_is_asked(tmp_path, old, new, told):
    with pytest.raises(InputError, match=told) as refusal:
        tiny_protocol(tmp_path, PROTOCOL.replace(old, new, 1))
    assert refusal.value.line is not None


def test_a_pair_of_the_same_condition_is_told(tmp_path):
    twice = PROTOCOL.replace('condition = "blur" }, {', 'condition = "plain" }, {')
    with pytest.raises(InputError, match="are both in condition `plain`"):
        do(tmp_path, twice)


def test_an_interrupted_session_asks_about_its_pair_and_no_single_exposure(tmp_path):
    text = PROTOCOL.replace(
        '"two_intervals"\ntimepoint = "pair"', '"preference"\ntimepoint = "post"'
    )
    quits = Scripted(interrupt_at_item="prefer_depth")
    assert do(tmp_path, text, respondent=quits).status == "aborted"
    assert do(tmp_path, text, respondent=Scripted(), resume=True).status == "completed"
    found = rows(tmp_path, "questionnaires.csv")
    of_pairs = [(row["trial"], row["item"]) for row in found if row["timepoint"] == "post"]
    items = ["prefer_realism", "prefer_fun", "prefer_depth", "prefer_presence"]
    assert of_pairs == [(trial, item) for trial in ("2", "4") for item in items]


def test_a_slider_is_a_line_that_is_chosen_from_at_any_place():
    (item,) = shipped_instruments()["dof_realism"].asked
    cells = [cell for cell in question_cells(item.answers, first=True) if cell.act is Act.ANSWER]
    assert [cell.value for cell in cells] == list(range(101))
    assert {cell.text for cell in cells} == {""}
    assert all(a.box[2] == b.box[0] for a, b in pairwise(cells))
    left, right = cells[0].box[0], cells[-1].box[2]
    for share, value in ((0.001, 0), (0.5, 50), (0.999, 100)):
        x = left + share * (right - left)
        found = cell_at(cells, (x / 1024, cells[0].center[1]))
        assert found is not None
        assert found.value == value


def test_susceptibility_counts_what_was_never_travelled_in_as_the_mean_of_the_others():
    child = shipped_instruments()["mssq_child"]
    names = [item.name for item in child.items]
    told = dict.fromkeys(names, 2) | {names[0]: None, names[1]: None, names[2]: 3}
    # Golding 2006: sum × 9 / (9 − types not experienced) = (3 + 6 × 2) × 9 / 7
    assert score(child, told)["msa"].points == pytest.approx(15 * 9 / 7)


def test_presence_items_are_turned_round():
    ipq = shipped_instruments()["ipq"]
    found = score(ipq, dict.fromkeys([item.name for item in ipq.items], 6))
    assert found["general"].points == 6.0
    assert found["spatial"].points == pytest.approx(4.8)
    assert found["involvement"].points == pytest.approx(4.5)
    assert found["realism"].points == pytest.approx(4.5)
