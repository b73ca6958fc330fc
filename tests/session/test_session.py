"""Sessions of the small study: what is shown and asked when, and what of it is on the disk."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.session import go, manifest, rows, status
from tests.support.study import AheadHeadset, LateFocus, Scripted, frame, read_rows, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.operator_interface import SessionProgress
from vrcomfort.records import Recorder, session_folder
from vrcomfort.respondent import SimulatedRespondent
from vrcomfort.session import RunOutcome, VirtualClock
from vrcomfort.session.frame_log import FrameLog
from vrcomfort.traces.trace import read_trace

SHORTENED = "motion blur: half streaks of up to 40.0 px were shortened to 20.0 px"


class Whole(NamedTuple):
    """A participant's two sessions, and what was told and drawn meanwhile."""

    folder: Path
    outcome: RunOutcome
    respondent: Scripted
    renderer: LateFocus
    progress: list[SessionProgress]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder, respondent, told = tmp_path_factory.mktemp("whole"), Scripted(), []
    renderer = LateFocus(shortened=(SHORTENED,))
    outcome = go(folder, respondent, renderer=renderer, progress=told.append)
    return Whole(folder, outcome, respondent, renderer, told)


@pytest.mark.smoke
def test_a_whole_participant(whole):
    assert (whole.outcome.status, whole.outcome.sessions) == ("completed", (1, 2))
    assert whole.renderer.begun == [
        ("scene room.glb", condition) for condition in ("plain", "blur", "blur", "plain")
    ]
    trials = [*rows(whole.folder, "trials.csv"), *rows(whole.folder, "trials.csv", 2)]
    assert [(row["session"], row["period"], row["trial"], row["condition"]) for row in trials] == [
        ("1", "1", "1", "plain"),
        ("1", "2", "2", "blur"),
        ("2", "3", "1", "blur"),
        ("2", "4", "2", "plain"),
    ]
    assert {(row["status"], row["abort_code"], row["frames"]) for row in trials} == {
        ("completed", "", "100")
    }
    assert status(whole.folder) == ("completed", "")
    assert whole.respondent.perceived_s == [10.0] * 4
    assert manifest(whole.folder)["status"] == "completed"
    assert manifest(whole.folder)["headset"]["refresh_hz"] == 10.0
    gaze = session_folder(whole.folder / "S", "P01", 1) / "gaze.csv"
    assert not gaze.exists()  # without an eye tracker


def test_what_a_limit_has_shortened_is_told_once_per_exposure(whole):
    events = rows(whole.folder, "events.csv")
    (told,) = (row for row in events if row["name"] == "blur_limited")
    assert told["detail"] == SHORTENED  # one of the two conditions blurs
    (exposure,) = (
        row for row in events if row["detail"] == "blur in room.glb" and row["name"] == "exposure"
    )
    assert float(told["onset_s"]) >= float(exposure["onset_s"]) + float(exposure["duration_s"])
    assert f"blur in room.glb: {SHORTENED}" in manifest(whole.folder)["clamps"]


def test_questionnaires_by_timepoint(whole):
    found = rows(whole.folder, "questionnaires.csv")
    assert [(row["timepoint"], row["trial"], row["condition"]) for row in found[::16]] == [
        ("baseline", "", ""),
        ("post", "1", "plain"),
        ("post", "2", "blur"),
        ("recovery", "", ""),
    ]
    first, second = rows(whole.folder, "trials.csv")
    assert [float(first[name]) for name in ("start_s", "end_s")] == [33.0, 43.0]
    assert float(second["start_s"]) == 43.0 + 32.0
    assert [row["order"] for row in found[:16]] == [str(n) for n in range(1, 17)]
    assert (found[0]["asked_s"], found[0]["answered_s"]) == ("0.0", "2.0")
    # 32 s baseline, 1 s training, 2 × (10 s exposure + 32 s post), 60 s rest
    assert float(found[-16]["asked_s"]) == pytest.approx(32 + 1 + 2 * 42 + 60)


def test_every_answer_is_on_the_disk_before_the_next_is_asked(tmp_path, monkeypatch):
    synced: list[int] = []
    for name in ("fsync", "fdatasync"):
        monkeypatch.setattr(f"os.{name}", synced.append)
    seen: list[int] = []

    class Watcher(Scripted):
        def ask(self, form, heard):
            def then_look(*answer):
                before = len(synced)
                heard(*answer)
                seen.append(len(synced) - before)

            super().ask(form, then_look)

    go(tmp_path, Watcher(), sessions=[1], exposure_s=1.0)
    assert len(seen) == 64  # four questionnaires
    assert min(seen) >= 1
    assert rows(tmp_path, "events.csv")[1]["detail"] == "baseline ssq general_discomfort: 1"
    assert status(tmp_path) == ("enrolled", "")  # there is a second session


def test_frames_have_their_own_focus_and_time_runs_forwards(whole):
    frames = rows(whole.folder, "frames.csv")
    assert [row["trial"] for row in frames] == ["0"] * 10 + ["1"] * 100 + ["2"] * 100
    plain, blur = frames[10:110], frames[110:]
    assert {row["focus_m"] for row in plain} == {""}
    assert {(row["focus_m"], row["ray_9_m"], row["rays_used"]) for row in blur} == {
        ("2.5", "30000.0", "111111110")
    }
    times = [int(row["xr_time_ns"]) for row in frames]
    assert times == sorted(set(times))
    assert {row["dropped"] for row in frames} == {"0"}
    seconds = [float(row["session_s"]) for row in frames]
    assert seconds == sorted(seconds)


def test_a_recorded_session_is_a_trace(whole):
    trace = read_trace(session_folder(whole.folder / "S", "P01", 1) / "frames.csv")
    assert len(trace.time_ns) == 210
    assert trace.cuts.nonzero()[0].tolist() == [0, 10, 110]


def test_ratings_are_scheduled_and_answered(whole):
    first = [row for row in rows(whole.folder, "ratings.csv") if row["trial"] == "1"]
    assert [(float(row["onset_s"]), row["response"], row["missed"]) for row in first] == [
        (pytest.approx(33 + due), "4", "0") for due in (3, 6)
    ]
    assert {row["latency_s"] for row in first} == {"0.5"}


def test_ratings_that_do_not_come_are_missed(tmp_path):
    go(tmp_path, Scripted(rates=None), sessions=[1], exposure_s=1.0)
    found = rows(tmp_path, "ratings.csv")
    assert {(row["response"], row["latency_s"], row["missed"]) for row in found} == {("", "", "1")}
    assert len(found) == 4


def test_ratings_carry_the_session_clock(tmp_path):
    class SlowClock(VirtualClock):
        """The machine takes three times as long as the display would."""

        def advance(self, duration_s: float) -> None:
            super().advance(3 * duration_s)

    go(tmp_path, Scripted(rates=4), clock=SlowClock(), sessions=[1])
    (trial, _), ratings = rows(tmp_path, "trials.csv"), rows(tmp_path, "ratings.csv")
    first = ratings[0]
    assert float(first["onset_s"]) == pytest.approx(float(trial["start_s"]) + 3 * 3.0)
    assert float(first["latency_s"]) == pytest.approx(3 * 0.5)


def test_a_shortened_exposure_is_recorded_and_felt_in_full(tmp_path):
    respondent = Scripted()
    go(tmp_path, respondent, sessions=[1], exposure_s=1.0)
    assert rows(tmp_path, "trials.csv")[0]["frames"] == "10"
    assert respondent.perceived_s == [10.0, 10.0]
    assert [exposure.duration_s for exposure in respondent.exposures] == [10.0, 10.0]
    assert manifest(tmp_path)["exposure_override_s"] == 1.0
    assert len(rows(tmp_path, "ratings.csv")) == 4


def test_sessions_are_not_repeated_and_a_study_keeps_its_seed(tmp_path):
    go(tmp_path, Scripted(), sessions=[1], exposure_s=1.0, seed=3)
    with pytest.raises(InputError, match="never overwritten"):
        go(tmp_path, Scripted(), sessions=[1])
    with pytest.raises(InputError, match="begun with seed 3, not 4"):
        go(tmp_path, Scripted(), seed=4)
    assert go(tmp_path, Scripted(), exposure_s=1.0).sessions == (2,)
    assert [manifest(tmp_path, session)["seed"] for session in (1, 2)] == [3, 3]
    with pytest.raises(InputError, match="all 2 sessions of P01 are recorded"):
        go(tmp_path, Scripted())
    with pytest.raises(InputError, match="no session 3; this protocol has 2, and none is left"):
        go(tmp_path, Scripted(), sessions=[3])


@pytest.mark.parametrize("exposure_s", [0.0, -1.0, 10.1, math.inf, math.nan])
def test_an_exposure_that_cannot_be_shown_is_refused_before_anything_is_recorded(
    tmp_path, exposure_s
):
    with pytest.raises(InputError, match="cannot be shown"):
        go(tmp_path, Scripted(), exposure_s=exposure_s)
    assert not (tmp_path / "S").exists()


@pytest.mark.smoke
def test_the_same_seed_gives_the_same_bytes(tmp_path):
    protocol = tiny_protocol(tmp_path)
    for study in ("A", "B"):
        respondent = SimulatedRespondent(protocol.simulation, participant="P01", seed=5)
        go(tmp_path, respondent, study=study, seed=5, sessions=[1])
    for name in ("trials", "questionnaires", "ratings", "frames", "events"):
        one, two = (
            (session_folder(tmp_path / study, "P01", 1) / f"{name}.csv").read_bytes()
            for study in ("A", "B")
        )
        assert one == two


def test_dropped_frames_are_counted(tmp_path):
    with Recorder(tmp_path, "P01", 1) as recorder:
        log = FrameLog(recorder)
        for index, time_ns in enumerate((0, 100, 219, 340, 440)):
            shown = frame(index, period_ns=100, time_ns=time_ns)
            log.add(shown, None, trial=1, session_s=0.0)
        log.finish()
    assert (log.frames, log.dropped) == (5, 1)
    found = read_rows(recorder.folder / "frames.csv")
    assert [row["dropped"] for row in found] == ["0", "0", "0", "1", "0"]


def test_progress_is_told(whole):
    assert {each.step for each in whole.progress} == {
        "session", "questionnaire", "training", "exposure", "rest", "end",
    }  # fmt: skip
    last = [each for each in whole.progress if each.step == "exposure"][-1]
    assert (last.session, last.trial, last.condition, last.total) == (2, 2, "plain", 10.0)


def test_a_jump_in_a_frame_that_is_not_drawn_is_told_with_the_next_one(tmp_path):
    """The runtime skips the frames of a cut and of a snap turn; their rows have the marks."""
    jumps = {40: {"discontinuity": True}, 60: {"snap_turn": True}}

    class Skips(AheadHeadset):
        def frames(self):
            for index in range(self.frames_left):
                yield replace(
                    frame(index), should_render=index not in jumps, **jumps.get(index, {})
                )

    class Notes(LateFocus):
        def render(self, frame, scene_time_s):
            if frame.discontinuity or frame.snap_turn:
                told.append((frame.index, frame.discontinuity, frame.snap_turn))
            return super().render(frame, scene_time_s)

    told = []
    go(tmp_path, Scripted(), headset=Skips, renderer=Notes(), sessions=[1])
    assert (41, True, False) in told
    assert (61, False, True) in told
    assert {index for index, *_ in told} <= {0, 41, 61}
    marks = {row["xr_time_ns"]: row["discontinuity"] for row in rows(tmp_path, "frames.csv")}
    assert (marks[str(frame(40).predicted_display_time_ns)]) == "1"
    assert (marks[str(frame(60).predicted_display_time_ns)]) == "2"
