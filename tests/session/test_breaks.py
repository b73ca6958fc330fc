"""Breaks: ended by whoever rests, within a minimum and a maximum that are recorded."""

from __future__ import annotations

import re
from functools import partial

import pytest

from tests.session.test_panel import ScriptedScreen, choose
from tests.support import resume
from tests.support.operator import Given, ScriptedDesk
from tests.support.resume import rows
from tests.support.study import PROTOCOL, Scripted, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.protocol.texts import ENGLISH
from vrcomfort.respondent import InstructionContent, SimulatedRespondent, Withdrew
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.respondent.panel_layout import Act
from vrcomfort.session import NoPictures, StillHeadset
from vrcomfort.session.dry_run import dry_run
from vrcomfort.session.operator_control import OperatorControl

go = partial(resume.go, exposure_s=1.0)

BREAKS = "\n[breaks]\nmin_s = 30.0\nmax_s = 100.0\n"


def resting(tmp_path, more=BREAKS):
    return tiny_protocol(tmp_path, PROTOCOL + more)


def events(tmp_path, name):
    found = [row for row in rows(tmp_path, "events") if row["name"] == name]
    return [(float(row["duration_s"]), row["detail"]) for row in found]


class Lingering(Scripted):
    """Rests for so long in all, then goes on."""

    lingers_s = 50.0

    def read(self, content, _elapsed_s, **_more):
        assert content.away
        self.told.append(content)
        left_s = self.lingers_s - 30.0 - _elapsed_s
        return left_s if left_s > 1e-6 else None


def breaks(tmp_path):
    return [each for each in events(tmp_path, "rest") if each[1].startswith("break")]


def test_a_break_that_is_too_long_is_told_once_and_goes_on(tmp_path):
    class Sleeping(Lingering):
        lingers_s = 500.0

    told = []
    go(tmp_path, Sleeping(), protocol=resting(tmp_path), progress=told.append)
    assert breaks(tmp_path)[0][0] == pytest.approx(500.0)
    (late,) = (row for row in rows(tmp_path, "events") if row["name"] == "break_too_long")
    (rest,) = (
        row for row in rows(tmp_path, "events") if row["detail"].startswith("break after trial 1;")
    )
    assert float(late["onset_s"]) - float(rest["onset_s"]) == pytest.approx(100.0)
    assert [each.text for each in told if each.step == "notice"] == [
        "break after trial 1: longer than 100 s"
    ]


def test_only_the_experimenter_can_skip_the_minimum_and_it_is_recorded(tmp_path):
    class Desk(ScriptedDesk):
        waited = 0

        def next_command(self):
            step = self.steps[-1]
            self.waited += step.words.startswith("break")
            return Given("skip", step.number, "A", "") if self.waited == 26 else None

    person = Lingering()
    go(tmp_path, person, protocol=resting(tmp_path), operators=OperatorControl(Desk()))
    assert breaks(tmp_path) == [(pytest.approx(5.0), "break after trial 1; ended by experimenter")]
    assert events(tmp_path, "break_cut_short")[0][1] == (
        "break after trial 1: 5.0 s, at least 30 s were meant"
    )
    assert person.told == []  # the participant was offered nothing before


def test_breaks_come_after_named_trials_and_last_as_long_as_the_participant_wants(tmp_path):
    text = PROTOCOL.replace(
        '{ scene = "room.glb", condition = "blur" }]',
        '{ scene = "room.glb", condition = "blur" }, { scene = "room.glb", condition = "plain" }]',
        1,
    )
    protocol = tiny_protocol(tmp_path, text + BREAKS + "after_trials = [2]\n")
    go(tmp_path, Lingering(), protocol=protocol)
    assert breaks(tmp_path) == [(pytest.approx(50.0), "break after trial 2; ended by participant")]
    assert events(tmp_path, "break_too_long") == []
    assert not verify_study(tmp_path / "S").faults


def test_an_interrupted_break_goes_on_with_what_is_left_of_it(tmp_path):
    class Interrupted(Scripted):
        def resting(self, left_s):
            if left_s < 20.0 and self.exposures:
                raise KeyboardInterrupt
            return False

    protocol = resting(tmp_path)
    assert go(tmp_path, Interrupted(), protocol=protocol).status == "aborted"
    assert breaks(tmp_path)[0][1] == "break after trial 1; ended by interruption"
    go(tmp_path, Lingering(), protocol=protocol, resume=True)
    assert breaks(tmp_path)[1][1] == "break after trial 1; ended by participant"
    assert breaks(tmp_path)[1][0] < 50.0  # the questions of the new baseline took a part of it
    assert [row["status"] for row in rows(tmp_path, "trials")] == ["completed", "completed"]
    assert not verify_study(tmp_path / "S").faults


def test_a_break_that_was_over_is_not_held_again(tmp_path):
    protocol = resting(tmp_path)
    go(tmp_path, Lingering(), protocol=protocol, interrupt=(2, 3))
    go(tmp_path, Lingering(), protocol=protocol, resume=True)
    assert len(breaks(tmp_path)) == 1


@pytest.mark.parametrize(("more", "in_a_row"), [("", 2), (f"{BREAKS}after_trials = [1]\n", 1)])
def test_a_dry_run_counts_the_exposures_between_breaks(tmp_path, more, in_a_row):
    first, second = dry_run(resting(tmp_path, more), tmp_path / "dry")
    for each in (first, second):
        assert (each.in_a_row, each.in_a_row_s) == (in_a_row, pytest.approx(10.0 * in_a_row))


def test_simulated_participants_rest_longer_than_they_must_and_answer_alike(tmp_path):
    protocol = resting(tmp_path, BREAKS.replace("30.0", "30.0\nafter_trials = [1]"))
    person = SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    go(
        tmp_path, person, protocol=protocol, jumps=True,
        headset_for=lambda *_: StillHeadset(), renderer=NoPictures(),
    )  # fmt: skip
    ((lasted_s, detail),) = breaks(tmp_path)
    assert lasted_s > 30.0
    assert detail.endswith("ended by participant")
    words = len((ENGLISH.rest_ready).split()) * 0.3
    first, _ = dry_run(protocol, tmp_path / "dry")
    assert first.rest_s == pytest.approx(60.0 + 30.0 + words)  # and who checks rests no longer


def test_whoever_stops_in_a_break_has_withdrawn(tmp_path):
    class Leaving(Scripted):
        def read(self, *_, **_more):
            raise Withdrew("enough")

    assert go(tmp_path, Leaving(), protocol=resting(tmp_path)).status == "withdrawn"


def test_the_panel_lets_the_headset_be_taken_off_in_a_break():
    screen = ScriptedScreen([choose(Act.CONFIRM)])
    person = PanelRespondent(screen, watch=screen.watch)
    content = InstructionContent("Rest", ENGLISH.rest_ready, away=True)
    assert person.read(content, 0.0, may_go_on=True) is None
    assert screen.absences_s


@pytest.mark.parametrize(
    ("more", "head", "says"),
    [
        (BREAKS, "break_s = 60.0\n", "`break_s` is a rest of a fixed length"),
        (BREAKS.replace("100", "10"), "", "`max_s` is less than `min_s`"),
        (BREAKS + "after_trials = [2]\n", "", "there is no trial 2 before another: at most 1"),
        (
            '[[instructions]]\nname = "a"\nwhen = "before_trial"\ntext = "x"\ntrials = [1, 3]\n',
            "",
            "there is no trial 3 at all: at most 2 come",
        ),
        (
            '[[practice]]\nname = "a"\ndraw = 1\nbefore_trial = 3\nsessions = [3]\n',
            "",
            "there is no session 3 at all: at most 2 come",
        ),
        ('[[practice]]\nname = "a"\ndraw = 3\n', "", "at most 2 trials to draw from"),
    ],
)
def test_breaks_that_cannot_be_are_refused(tmp_path, more, head, says):
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, head + PROTOCOL + more)
    assert any(says in str(each) for each in (caught.value.alone, *caught.value.others))


def test_an_order_without_any_trial_is_all_that_is_told(tmp_path):
    """And not every break, practice and instruction that has no trial then."""
    text = re.sub(r"\[\[order\.sequences\]\]\n.+?\n\]\n", "", PROTOCOL, flags=re.DOTALL)
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, text + BREAKS + "after_trials = [1]\n")
    assert "needs at least one [[order.sequences]]" in caught.value.message
    assert caught.value.others == ()
