"""Seated and standing: the height of the eyes is measured, and the scene's floor moves with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest

from tests.support import resume
from tests.support.operator import Given, ScriptedDesk
from tests.support.resume import folder, manifest, rows
from tests.support.study import PROTOCOL, AheadHeadset, Scripted, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.frame import Frame
from vrcomfort.geometry import Pose
from vrcomfort.records import read_manifest
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.session import NoPictures, StillHeadset
from vrcomfort.session.dry_run import dry_run
from vrcomfort.session.operator_control import OperatorControl
from vrcomfort.traces.trace import read_trace

go = partial(resume.go, exposure_s=1.0)

SEATED = '\n[posture]\nmode = "seated"\n'


@dataclass
class Sitting(AheadHeadset):
    """A head at a height; each pass of frames takes the next of `heights_m`, then the last."""

    heights_m: tuple[float, ...] = (1.2,)
    sways_m: float = 0.0
    tracked: bool = True
    passes: int = 0

    def frames(self) -> Iterator[Frame]:
        height_m = self.heights_m[min(self.passes, len(self.heights_m) - 1)]
        self.passes += 1
        for frame in super().frames():
            up_m = height_m + self.sways_m * (frame.index % 2)
            head = Pose(np.array([0.0, up_m, 0.0]))
            yield replace(frame, head_pose=head, head_tracked=self.tracked)


def sit(tmp_path, more=SEATED, *, headset=None, **options):
    protocol = tiny_protocol(tmp_path, PROTOCOL + more)
    headset = headset or Sitting()
    return go(
        tmp_path, options.pop("respondent", Scripted()), protocol=protocol,
        headset_for=lambda *_: headset, **options,
    )  # fmt: skip


def events(tmp_path, name="eye_height"):
    return [row["detail"] for row in rows(tmp_path, "events") if row["name"] == name]


def seen_from_m(tmp_path) -> set[float]:
    """Return how high the eyes were in the scene, in the frames of exposures."""
    return {
        round(float(row["avatar_y_m"]) + float(row["head_y_m"]), 6)
        for row in rows(tmp_path, "frames")
        if row["trial"] != "0"
    }


def test_seated_people_see_from_the_height_that_the_scene_is_meant_for(tmp_path):
    sit(tmp_path)
    assert seen_from_m(tmp_path) == {1.6}
    assert events(tmp_path) == ["seated: 1.200 m, the scene is seen from 1.600 m"]
    assert manifest(tmp_path)["eye_heights"] == [
        {"before_trial": 1, "measured_m": 1.2, "offset_m": 0.4}
    ]
    assert not verify_study(tmp_path / "S").faults
    trace = read_trace(folder(tmp_path) / "frames.csv")
    head = trace.head.pose(len(trace) - 1)
    assert head.position[1] == pytest.approx(1.2)  # and a replay stands as high as they did


def test_people_may_see_from_their_own_height_which_is_recorded(tmp_path):
    sit(tmp_path, SEATED + 'eyes = "own"\n')
    assert seen_from_m(tmp_path) == {1.2}
    assert manifest(tmp_path)["eye_heights"][0]["offset_m"] == 0.0


def test_nothing_happens_without_the_table(tmp_path):
    sit(tmp_path, "")
    assert seen_from_m(tmp_path) == {1.2}
    assert events(tmp_path) == []
    assert manifest(tmp_path)["eye_heights"] == []


@pytest.mark.parametrize("again", [True, False])
def test_it_is_measured_again_after_a_break(tmp_path, again):
    more = f"{SEATED}after_breaks = {str(again).lower()}\n[breaks]\n"
    # measured, trained and exposed at 1.2 m; then somebody leans back
    sit(tmp_path, more, headset=Sitting(heights_m=(1.2, 1.2, 1.1)))
    assert len(events(tmp_path)) == 1 + again
    second = next(row for row in rows(tmp_path, "frames") if row["trial"] == "2")
    high_m = float(second["avatar_y_m"]) + float(second["head_y_m"])
    assert high_m == pytest.approx(1.6 if again else 1.5)


def test_whoever_moves_is_measured_again_and_the_experimenter_is_told(tmp_path):
    told = []
    sit(tmp_path, headset=Sitting(sways_m=0.2), progress=told.append)
    (doubt,) = events(tmp_path, "eye_height_doubtful")
    assert doubt == "the eyes moved up or down by 0.20 m while they were measured"
    assert doubt in [each.text for each in told if each.step == "notice"]
    trained = sum(row["trial"] == "0" for row in rows(tmp_path, "frames"))
    assert trained == 3 * 30 + 1  # three times 3 s at 10 Hz, and 0.1 s of training


def test_a_headset_without_a_floor_is_told(tmp_path):
    sit(tmp_path, headset=Sitting(heights_m=(0.02,)))
    assert (
        "does not know where the floor is; set up its room"
        in events(tmp_path, "eye_height_doubtful")[0]
    )
    assert seen_from_m(tmp_path) == {1.6}


def test_a_head_that_is_not_tracked_moves_nothing(tmp_path):
    sit(tmp_path, headset=Sitting(tracked=False))
    assert "not tracked" in events(tmp_path, "eye_height_doubtful")[0]
    assert manifest(tmp_path)["eye_heights"] == []
    assert seen_from_m(tmp_path) == {1.2}


def test_the_experimenter_may_repeat_and_leave_it_out(tmp_path):
    class Desk(ScriptedDesk):
        given = 0

        def next_command(self):
            step = self.steps[-1]
            if not step.words.startswith("height") or self.given == 2:
                return None
            self.given += 1
            return Given("redo" if self.given == 1 else "skip", step.number, "A", "")

    sit(tmp_path, operators=OperatorControl(Desk()))
    assert events(tmp_path) == []
    assert len(events(tmp_path, "eye_height_skipped")) == 1
    assert seen_from_m(tmp_path) == {1.2}


def test_a_resumed_session_measures_again_and_keeps_what_was_measured(tmp_path):
    class Stops(Sitting):
        def frames(self):
            for frame in super().frames():
                if self.passes == 2 and frame.index == 5:
                    raise KeyboardInterrupt
                yield frame

    sit(tmp_path, headset=Stops())
    assert manifest(tmp_path)["status"] == "aborted"
    sit(tmp_path, headset=Sitting(heights_m=(1.25,)), resume=True)
    assert [each["measured_m"] for each in manifest(tmp_path)["eye_heights"]] == [1.2, 1.25]
    assert seen_from_m(tmp_path) == {1.6}
    assert not verify_study(tmp_path / "S").faults


def test_an_interrupted_measurement_is_made_again(tmp_path):
    sit(tmp_path, headset=Sitting(interrupt_at=5))
    assert manifest(tmp_path)["eye_heights"] == []
    sit(tmp_path, resume=True)
    assert seen_from_m(tmp_path) == {1.6}


def test_simulated_participants_are_measured_without_frames(tmp_path):
    protocol = tiny_protocol(tmp_path, PROTOCOL + SEATED)
    person = SimulatedRespondent(protocol.simulation, participant="P01", seed=0)
    go(
        tmp_path, person, protocol=protocol, jumps=True,
        headset_for=lambda *_: StillHeadset(), renderer=NoPictures(),
    )  # fmt: skip
    assert manifest(tmp_path)["eye_heights"][0]["measured_m"] == 1.6


def test_check_counts_the_measurement_as_training(tmp_path):
    first, _ = dry_run(tiny_protocol(tmp_path, PROTOCOL + SEATED), tmp_path)
    assert first.training_s == pytest.approx(1.0 + 3.0, abs=0.1)  # by frames of 20 Hz


def test_how_tall_somebody_is_is_not_handed_on(tmp_path):
    sit(tmp_path)
    anonymise(tmp_path / "S", tmp_path / "shared", AnonymisingOptions(seed=1))
    (session,) = (tmp_path / "shared").glob("sub-*/ses-1")
    (height,) = read_manifest(session)["eye_heights"]
    assert (height["measured_m"], height["offset_m"]) == (None, None)
    assert "1.200" not in (session / "events.csv").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (SEATED.replace("seated", "lying"), "seated"),
        (SEATED + "eye_height_m = 160\n", "eye_height_m"),
        ("[posture]\n", "mode"),
        (SEATED + 'eyes = "own"\neye_height_m = 1.2\n', "`eye_height_m` does nothing"),
    ],
)
def test_a_posture_that_cannot_be_is_refused(tmp_path, more, says):
    with pytest.raises(InputError, match=says):
        tiny_protocol(tmp_path, PROTOCOL + more)
