"""Practice: repeated until it goes well enough, recorded apart, and no trial of the study."""

from __future__ import annotations

import json
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.operator import Given, ScriptedDesk
from tests.support.session import run
from tests.support.study import PROTOCOL as TINY
from tests.support.study import AheadHeadset, LateFocus, Scripted, read_rows, tiny_protocol
from tests.support.tasks import PROTOCOL, doing_protocol, room
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol.session_steps import Practice
from vrcomfort.records.json_file import ManifestShape
from vrcomfort.report.study_data import read_study
from vrcomfort.report.withdrawals import EarlyEnding, early_endings
from vrcomfort.respondent import SimulatedRespondent, Withdrew
from vrcomfort.session import NoPictures, StillHeadset
from vrcomfort.session.dry_run import dry_run
from vrcomfort.session.operator_control import OperatorControl

HARD = """
[[practice]]
name = "warm_up"
trials = [
  { scene = "room.glb", condition = "plain" }, { scene = "room.glb", condition = "blur" },
]
exposure_s = 2.0
hits_at_least = 1000
at_most = 3
"""
EASY = HARD.replace("1000", "1").replace("2.0", "5.0")
FREE = """
[[practice]]
name = "look"
trials = [{ scene = "room.glb", condition = "blur" }]
exposure_s = 3.0
"""


def practise(tmp_path, more, *, person=None, text=PROTOCOL, **options):
    protocol = doing_protocol(tmp_path, text.replace("= 20.0", "= 3.0") + more)
    person = person or SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    options.setdefault("headset_for", lambda *_: AheadHeadset())
    options.setdefault("renderer", LateFocus())
    return run(
        protocol, "P01", study=tmp_path / "S", respondent=person,
        load_scene=lambda _: room(), **options,
    )  # fmt: skip


def rows(tmp_path, name="practice"):
    return read_rows(tmp_path / "S/sub-P01/ses-1" / f"{name}.csv")


def told(tmp_path):
    columns = ("repetition", "number", "condition", "status", "met", "over", "resumed")
    return [tuple(row[each] for each in columns) for row in rows(tmp_path)]


class Watching(SimulatedRespondent):
    """Notes where the targets of each exposure are."""

    def start_task(self, trial, condition):
        self.__dict__.setdefault("seen", []).append([])
        super().start_task(trial, condition)

    def act(self, demand, head, time_s):
        if demand is not None:
            self.seen[-1].append(demand.position_m)
        return super().act(demand, head, time_s)


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """Return the folder of a study with a session that nobody changes, and its participant."""
    folder = tmp_path_factory.mktemp("practised")
    settings = doing_protocol(folder, PROTOCOL).simulation
    person = Watching(settings, participant="P01", seed=0)
    practise(folder, HARD, person=person)
    return folder, person


@pytest.fixture(scope="module")
def practised(watched):
    return watched[0]


def test_a_block_is_repeated_until_it_has_been_shown_often_enough(practised):
    assert told(practised) == [
        (str(n), number, condition, "completed", met, over, "0")
        for n in (1, 2, 3)
        for number, condition, met, over in (
            ("1", "plain", "", "0"),
            ("2", "blur", "0", "1" if n == 3 else "0"),
        )
    ]
    assert all(
        float(row["end_s"]) - float(row["start_s"]) == pytest.approx(2.0) for row in rows(practised)
    )
    assert {row["task"] for row in rows(practised)} == {"shoot"}
    (event,) = [row for row in rows(practised, "events") if row["name"] == "practice_not_met"]
    assert event["detail"] == "practice warm_up was not good enough in 3 repetitions"
    assert [row["status"] for row in rows(practised, "trials")] == ["completed", "completed"]


def test_whoever_is_good_enough_goes_on_at_once(tmp_path):
    practise(tmp_path, EASY)
    assert [row[4:6] for row in told(tmp_path)] == [("", "0"), ("1", "1")]
    hits = sum(int(row["hits"]) for row in rows(tmp_path))
    assert 1 <= hits <= sum(int(row["targets"]) for row in rows(tmp_path))


def test_practice_changes_nothing_of_the_study(practised, tmp_path):
    practise(tmp_path, "")
    plain = rows(tmp_path, "questionnaires"), rows(tmp_path, "tasks")
    again = rows(practised, "questionnaires"), rows(practised, "tasks")
    assert [r["response"] for r in plain[0]] == [r["response"] for r in again[0]]
    what = ("trial", "kind", "number", "reaction_s", "hit")
    assert [[r[c] for c in what] for r in plain[1]] == [[r[c] for c in what] for r in again[1]]
    assert {row["trial"] for row in rows(practised, "tasks")} == {"1", "2"}
    assert len(read_study(practised / "S").trials) == 2
    assert not verify_study(practised / "S").faults


def test_each_repetition_has_targets_of_its_own(watched):
    folder, person = watched
    assert len(person.seen) == 8  # three times two, and the two trials
    places = [tuple(np.round(each[0], 6)) for each in person.seen]
    assert len(set(places)) == 8
    details = {row["detail"] for row in rows(folder, "events") if row["name"] == "practice"}
    assert details == {
        f"warm_up, repetition {n}: {condition} in room.glb"
        for n in (1, 2, 3)
        for condition in ("plain", "blur")
    }


def test_a_block_without_criterion_is_shown_once_and_may_be_drawn(tmp_path):
    practise(
        tmp_path,
        FREE
        + FREE.replace("look", "two").replace(
            'trials = [{ scene = "room.glb", condition = "blur" }]', "draw = 2\nbefore_trial = 2"
        ),
    )
    named = [(row["practice"], row["before_trial"], row["over"], row["met"])
             for row in rows(tmp_path)]  # fmt: skip
    assert named == [("look", "1", "1", ""), ("two", "2", "0", ""), ("two", "2", "1", "")]
    drawn = {row["condition"] for row in rows(tmp_path) if row["practice"] == "two"}
    assert drawn == {"plain", "blur"}  # of the two that the session has


@pytest.mark.parametrize(("ends", "status"), [("session", "ended"), ("study", "withdrawn")])
def test_what_never_went_well_enough_may_end_it(tmp_path, ends, status):
    practise(tmp_path, HARD + f'otherwise = "{ends}"\n')
    content = json.loads((tmp_path / "S/sub-P01/ses-1/manifest.json").read_text())
    assert content["status"] == status
    assert (content["ended"]["by"], content["ended"]["ends"]) == ("practice", ends)
    assert rows(tmp_path, "trials") == []
    assert not verify_study(tmp_path / "S").faults
    manifest = ManifestShape.model_validate(content)
    (counted,) = early_endings(SimpleNamespace(trials=[], manifests=[manifest]))
    assert counted == EarlyEnding(ends=ends, by="practice", n=1)


class Interrupting(AheadHeadset):
    """Stops the program in the n-th exposure."""

    left = 0

    def frames(self):
        Interrupting.left -= 1
        self.interrupt_at = 15 if Interrupting.left == 0 else None
        return super().frames()


@pytest.mark.parametrize("exposure", [1, 4])
def test_interrupted_practice_goes_on_with_its_next_repetition(tmp_path, exposure):
    Interrupting.left = exposure
    first = practise(tmp_path, HARD, headset_for=lambda *_: Interrupting())
    assert first.status == "aborted"
    whole = (exposure - 1) // 2
    assert told(tmp_path)[-1][3] == "aborted"
    practise(tmp_path, HARD, resume=True)
    after = [row for row in told(tmp_path) if row[6] == "1"]
    assert [row[0] for row in after[:1]] == [str(whole + 2)]
    assert sum(row[4] == "0" for row in told(tmp_path)) == 3  # three whole ones in all
    assert [row[5] for row in told(tmp_path)].count("1") == 1
    assert [row["status"] for row in rows(tmp_path, "trials")] == ["completed", "completed"]
    assert not verify_study(tmp_path / "S").faults


def test_practice_that_is_over_is_not_shown_again(tmp_path):
    Interrupting.left = 7  # in the first trial
    practise(tmp_path, HARD, headset_for=lambda *_: Interrupting())
    shown = told(tmp_path)
    practise(tmp_path, HARD, resume=True)
    assert told(tmp_path) == shown
    assert [row["status"] for row in rows(tmp_path, "trials")] == [
        "aborted",
        "completed",
        "completed",
    ]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (",warm_up,", ",other,", "the protocol has no practice 'other'"),
        (",completed,", ",done,", "'done' is no status of practice"),
        (",3,2,blur", ",1,2,blur", "repetition 1, exposure 2 of practice 'warm_up' stands too"),
        (",0,0\n", ",1,0\n", "practice 'warm_up' was over, and goes on here"),
        ("P01,1,", "P02,1,", "participant is P02, and this folder is of P01"),
    ],
)
def test_verify_finds_rows_of_practice_that_cannot_be(practised, tmp_path, old, new, says):
    shutil.copytree(practised, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "S/sub-P01/ses-1/practice.csv"
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    assert any(says in str(each) for each in verify_study(tmp_path / "S").faults)


def test_the_experimenter_may_repeat_and_end_it(tmp_path):
    class Desk(ScriptedDesk):
        given = 0

        def next_command(self):
            step = self.steps[-1]
            if not step.words.startswith("practice") or self.given == 2:
                return None
            self.given += 1
            return Given("redo" if self.given == 1 else "skip", step.number, "A", "")

    practise(tmp_path, HARD, person=Scripted(), operators=OperatorControl(Desk()))
    assert [row[:6] for row in told(tmp_path)] == [
        ("1", "1", "plain", "redone", "", "0"),
        ("2", "1", "plain", "skipped", "", "1"),
    ]
    assert len(rows(tmp_path, "trials")) == 2


def test_who_withdraws_in_practice_has_withdrawn(tmp_path):
    class Leaving(Scripted):
        def update(self, elapsed_s):
            if elapsed_s > 1:
                raise Withdrew("had enough")

    assert practise(tmp_path, HARD, person=Leaving()).status == "withdrawn"
    assert [row[3] for row in told(tmp_path)] == ["withdrawn"]
    assert not verify_study(tmp_path / "S").faults


def test_without_frames_practice_takes_its_time(tmp_path):
    practise(
        tmp_path, HARD, jumps=True, headset_for=lambda *_: StillHeadset(), renderer=NoPictures()
    )
    assert len(told(tmp_path)) == 6
    (tmp_path / "tiny").mkdir()
    protocol = tiny_protocol(tmp_path / "tiny", TINY + FREE)
    lengths = dry_run(protocol, tmp_path / "tiny")
    assert [each.training_s for each in lengths] == [4.0, 4.0]  # 1 s of training in each


def test_practice_is_handed_on_without_names(practised, tmp_path):
    anonymise(practised / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    (file,) = (tmp_path / "shared").rglob("practice.csv")
    (name,) = (each.name for each in (tmp_path / "shared").glob("sub-*"))
    told = {(f"sub-{row['participant']}", row["practice"]) for row in read_rows(file)}
    assert told == {(name, "warm_up")}


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (HARD.replace("plain", "plane"), "plane"),
        (HARD.replace('"room.glb", condition = "blur"', '"x.glb", condition = "blur"'), "x.glb"),
        (HARD + "draw = 2\n", "`trials` and `draw` exclude each other"),
        ('[[practice]]\nname = "a"\n', "`a` shows nothing"),
        (FREE + "at_most = 2\n", "`at_most` does nothing without `score_at_least`"),
        (FREE + 'otherwise = "study"\n', "`otherwise` does nothing without"),
        (FREE + FREE, "`look` is there twice"),
        (FREE.replace('"blur" }', '"blur", task = "none" }') + "hits_at_least = 1\n", "is done in"),
        (FREE.replace("3.0", "0.0"), "exposure_s"),
    ],
)
def test_practice_that_cannot_be_is_refused(tmp_path, more, says):
    with pytest.raises(InputError) as caught:
        doing_protocol(tmp_path, PROTOCOL + more)
    assert any(says in str(each) for each in (caught.value.alone, *caught.value.others))


@pytest.mark.parametrize(
    ("wanted", "scores", "hits", "met"),
    [
        ({}, [1.0], 5, None),
        ({"score_at_least": 2.0}, [1.0, 3.0], 0, True),
        ({"score_at_least": 2.01}, [1.0, 3.0], 0, False),
        ({"score_at_least": 0.0}, [], 0, False),
        ({"hits_at_least": 4}, [], 4, True),
        ({"hits_at_least": 4, "score_at_least": 2.0}, [1.0], 4, False),
    ],
)
def test_the_criterion_by_hand(wanted, scores, hits, met):
    practice = Practice(name="a", draw=1, **wanted)
    assert practice.met(scores, hits) is met
