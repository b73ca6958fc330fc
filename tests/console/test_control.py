"""What an operator asks of a session happens, is recorded, and what is stale is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.operator import ScriptedDesk, Wanted
from tests.support.report import build_report
from tests.support.resume import attempts, folder, go, manifest, rows
from tests.support.study import Scripted
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.records import read_participants
from vrcomfort.records.events import shared_detail
from vrcomfort.session.operator_control import ALLOWED, OperatorControl


def steered(tmp_path: Path, *script: Wanted, starts: bool = False, **more) -> ScriptedDesk:
    desk = ScriptedDesk(script, starts)
    desk.outcome = go(tmp_path, operators=OperatorControl(desk), **more)
    assert desk.done == len(script)
    return desk


def events(tmp_path: Path, prefix: str = "operator_") -> list[tuple[str, str]]:
    found = [(row["name"], row["detail"]) for row in rows(tmp_path, "events")]
    return [each for each in found if each[0].startswith(prefix)]


def assert_whole(tmp_path: Path) -> None:
    assert [str(each) for each in verify_study(tmp_path / "S").faults] == []


def test_a_pause_stops_the_clock_and_is_recorded_with_its_duration(tmp_path):
    """Nothing is rendered meanwhile, and the desk goes on seeing."""
    respondent = Scripted()
    desk = steered(
        tmp_path,
        Wanted("exposure", "pause", after=30),
        Wanted("exposure", "go_on", after=25),
        respondent=respondent,
    )
    assert sum(frame.paused for frame, *_ in desk.seen) == pytest.approx(25, abs=1)
    assert [response for _, response in desk.ratings] == [4, 4, 4, 4]
    assert attempts(tmp_path)[0] == ("1", "1", "0", "completed", "")
    trial = rows(tmp_path, "trials")[0]
    assert (trial["frames"], trial["live_s"]) == ("100", "10.0")
    assert float(trial["hidden_s"]) == pytest.approx(2.5, abs=0.11)
    assert respondent.perceived_s == [10.0, 10.0]
    (pause,) = (row for row in rows(tmp_path, "events") if row["name"] == "pause")
    assert float(pause["duration_s"]) == pytest.approx(2.5, abs=0.11)
    assert pause["detail"].startswith("exposure 1 of 2, attempt 1: plain")
    exposure = [row for row in rows(tmp_path, "frames") if row["trial"] == "1"]
    shown = [row for row in exposure if row["paused"] == "0"]
    assert [row["should_render"] for row in exposure if row["paused"] == "1"] == ["0"]
    cuts = [index for index, row in enumerate(shown) if row["discontinuity"] == "1"]
    assert len(shown) == 100
    assert cuts == [30]  # the frame after it has nothing to do with the one before
    times = [int(row["xr_time_ns"]) for row in shown]
    assert (times[30] - times[29]) / 1e9 == pytest.approx(2.6, abs=0.11)
    assert_whole(tmp_path)


@pytest.mark.smoke
def test_a_redone_exposure_is_shown_again_as_the_next_attempt(tmp_path):
    steered(tmp_path, Wanted("exposure", "redo", after=40))
    assert attempts(tmp_path) == [
        ("1", "1", "0", "aborted", "redone"),
        ("1", "2", "0", "completed", ""),
        ("2", "1", "0", "completed", ""),
    ]
    assert [row["name"] for row in rows(tmp_path, "events")].count("training") == 1
    asked = [r["timepoint"] for r in rows(tmp_path, "questionnaires") if r["trial"] == "1"]
    assert asked == ["post"] * 16
    assert_whole(tmp_path)


def test_a_skipped_exposure_is_not_asked_about_and_the_next_one_comes(tmp_path):
    steered(tmp_path, Wanted("exposure", "skip", after=40))
    assert attempts(tmp_path) == [
        ("1", "1", "0", "skipped", "operator"),
        ("2", "1", "0", "completed", ""),
    ]
    asked = {row["trial"] for row in rows(tmp_path, "questionnaires")}
    assert asked == {"", "2"}
    assert manifest(tmp_path)["status"] == "completed"
    assert_whole(tmp_path)


def test_training_can_be_redone_and_skipped(tmp_path):
    desk = steered(
        tmp_path, Wanted("training", "redo", after=5), Wanted("training", "skip", after=4)
    )
    assert [step.kind for step in desk.steps][1:4] == ["training", "training", "exposure"]
    lengths = [r["duration_s"] for r in rows(tmp_path, "events") if r["name"] == "training"]
    assert [float(length) for length in lengths] == pytest.approx([0.6, 0.5], abs=0.11)
    assert attempts(tmp_path)[0] == ("1", "1", "0", "completed", "")
    assert_whole(tmp_path)


def test_a_skipped_questionnaire_keeps_what_was_answered_and_says_what_is_missed(tmp_path):
    steered(tmp_path, Wanted("questionnaire", "skip", after=5))
    asked = [r["timepoint"] for r in rows(tmp_path, "questionnaires")]
    assert asked.count("baseline") == 6
    (missed,) = manifest(tmp_path)["missed_questions"]
    left = "10 of 16 items of ssq (baseline) of the session are missed"
    assert missed == f"{left}: skipped by an operator"
    ((_, detail),) = events(tmp_path, "questionnaire_skipped")
    assert detail.startswith("baseline ssq: sweating, nausea, ")
    assert_whole(tmp_path)


def test_a_redone_questionnaire_replaces_the_answers_given(tmp_path):
    desk = steered(tmp_path, Wanted("questionnaire", "redo", after=5))
    assert [step.kind for step in desk.steps][:2] == ["questionnaire"] * 2
    baseline = [r for r in rows(tmp_path, "questionnaires") if r["timepoint"] == "baseline"]
    assert [int(row["order"]) for row in baseline] == list(range(1, 17))
    assert len(events(tmp_path, "answer")) == 16 * 4 + 6
    assert_whole(tmp_path)


def test_a_rest_can_be_paused_and_skipped(tmp_path):
    steered(
        tmp_path,
        Wanted("rest", "pause", after=10),
        Wanted("rest", "go_on", after=50),
        Wanted("rest", "skip", after=20),
    )
    (rest,) = (row for row in rows(tmp_path, "events") if row["name"] == "rest")
    assert float(rest["duration_s"]) == pytest.approx(0.2 * 80, abs=0.7)
    assert_whole(tmp_path)


def test_an_abort_keeps_its_reason_and_the_session_can_be_resumed(tmp_path):
    desk = steered(tmp_path, Wanted("exposure", "abort", "fire alarm", after=40))
    assert (desk.outcome.status, desk.outcome.note) == ("aborted", "stopped by A: fire alarm")
    assert attempts(tmp_path) == [("1", "1", "0", "aborted", "operator")]
    (person,) = read_participants(tmp_path / "S")
    assert person.status == "enrolled"
    assert person.note == "session 1 aborted: stopped by A: fire alarm"
    assert_whole(tmp_path)
    assert go(tmp_path, resume=True).status == "enrolled"
    assert attempts(tmp_path)[1:] == [
        ("1", "2", "1", "completed", ""),
        ("2", "1", "1", "completed", ""),
    ]
    assert_whole(tmp_path)


@pytest.mark.parametrize("first", ["skip", "redo", "pause"])
def test_a_session_that_was_steered_and_interrupted_goes_on_after_it(tmp_path, first):
    kind = "exposure"
    script = [Wanted(kind, first, after=30)]
    if first == "pause":
        script.append(Wanted(kind, "go_on"))
    steered(tmp_path, *script, Wanted("rest", "abort", "lunch", after=5))
    before = attempts(tmp_path)
    assert go(tmp_path, resume=True).status == "enrolled"
    assert attempts(tmp_path) == before  # nothing is shown again: both are over
    asked = {row["trial"] for row in rows(tmp_path, "questionnaires")}
    assert asked == ({"", "2"} if first == "skip" else {"", "1", "2"})
    assert manifest(tmp_path)["status"] == "completed"
    assert_whole(tmp_path)


def test_a_skipped_exposure_is_over_where_the_session_goes_on_at_the_next(tmp_path):
    steered(
        tmp_path,
        Wanted("exposure", "skip", after=30),
        Wanted("exposure", "abort", "lunch", after=30),
    )
    assert go(tmp_path, resume=True).status == "enrolled"
    assert [row[:2] for row in attempts(tmp_path)] == [("1", "1"), ("2", "1"), ("2", "2")]
    assert_whole(tmp_path)


def test_a_withdrawal_is_asked_once_more_and_can_be_taken_back(tmp_path):
    desk = steered(
        tmp_path,
        Wanted("exposure", "withdraw_surely"),
        Wanted("exposure", "withdraw"),
        Wanted("exposure", "withdraw_not"),
        Wanted("exposure", "withdraw"),
        Wanted("exposure", "withdraw_surely", "felt ill"),
    )
    assert desk.asked == [True, False, True, False]
    assert desk.replies[0][1] == "nobody has asked for a withdrawal, or it was taken back"
    assert desk.outcome.status == "withdrawn"
    assert attempts(tmp_path) == [("1", "1", "0", "withdrawn", "participant")]
    (person,) = read_participants(tmp_path / "S")
    assert (person.status, person.note) == ("withdrawn", "session 1: withdrawn by A: felt ill")
    post = [row for row in rows(tmp_path, "questionnaires") if row["timepoint"] == "post"]
    assert len(post) == 16  # asked, and may be refused
    assert_whole(tmp_path)


def test_what_was_meant_for_a_step_that_is_over_is_refused_in_a_sentence(tmp_path):
    desk = steered(tmp_path, Wanted("exposure", "skip", number=1))
    ((action, refusal),) = desk.replies
    assert action == "skip"
    assert refusal.startswith(
        "skip was meant for step 1, which is over; now it is step 3, exposure"
    )
    assert [row[3] for row in attempts(tmp_path)] == ["completed", "completed"]
    ((name, detail),) = events(tmp_path)
    assert name == "operator_refused"
    assert detail == f"A, step 1, skip: {refusal}"


def test_a_note_is_kept_whatever_it_was_meant_for(tmp_path):
    steered(
        tmp_path,
        Wanted("exposure", "note", "laughs, a lot", number=1),
        Wanted("exposure", "note", " "),
    )
    kept, refused = events(tmp_path)
    assert kept == ("operator_note", "A, step 1: laughs, a lot")
    assert refused[1].endswith("note: note needs a note; enter it")


def test_what_has_no_meaning_is_refused_in_a_sentence(tmp_path):
    meant = {
        ("questionnaire", "pause"): "pause has no meaning in this step: questionnaire ssq",
        ("exposure", "go_on"): "nothing is paused",
        ("exposure", "recentre"): "this headset cannot be recentred",
        ("exposure", "abort"): "abort needs the reason; enter it",
        ("exposure", "explode"): "there is no action 'explode'",
        ("rest", "redo"): "redo has no meaning in this step: rest of 60 s",
    }
    desk = steered(tmp_path, *(Wanted(kind, action) for kind, action in meant))
    assert [action for action, _ in desk.replies] == [action for _, action in meant]
    for (_, refusal), words in zip(desk.replies, meant.values(), strict=True):
        assert refusal.startswith(words)
    assert desk.outcome.status == "enrolled"


def test_a_session_waits_for_its_start_and_everything_is_one_step_after_another(tmp_path):
    desk = steered(tmp_path, Wanted("ready", "start"), starts=True)
    assert [step.number for step in desk.steps] == list(range(1, len(desk.steps) + 1))
    assert [step.kind for step in desk.steps] == [
        "ready", "questionnaire", "training", "exposure", "questionnaire", "exposure",
        "questionnaire", "rest", "questionnaire",
    ]  # fmt: skip
    assert [name for name in desk.order.timeline if name.startswith("exposure")] == [
        "exposure 1: plain in room.glb", "exposure 2: blur in room.glb",
    ]  # fmt: skip
    assert desk.order.position() == len(desk.order.timeline) == len(desk.steps) - 1
    assert events(tmp_path) == [("operator_start", "A, step 1 (waiting for the start)")]
    for step in desk.steps:
        assert step.kind in ALLOWED


def test_every_event_of_an_operator_has_its_time_and_order(tmp_path):
    steered(
        tmp_path,
        Wanted("exposure", "note", "sits", after=10),
        Wanted("exposure", "pause", after=10),
        Wanted("exposure", "go_on", after=10),
    )
    names = [name for name, _ in events(tmp_path)]
    assert names == ["operator_note", "operator_pause", "operator_go_on"]
    times = [float(row["onset_s"]) for row in rows(tmp_path, "events") if "operator" in row["name"]]
    assert times == sorted(times)
    assert all("step 3 (exposure 1 of 2" in detail for _, detail in events(tmp_path))
    assert folder(tmp_path).is_dir()


def test_an_anonymous_copy_keeps_what_was_done_and_not_what_was_typed():
    assert shared_detail("operator_note", "A, step 3 (exposure 1): knows Anna") == ""
    written = "exposure 1 of 2, attempt 1: plain in temple"
    assert shared_detail("pause", written) == written


@pytest.mark.slow
def test_a_report_reads_a_study_that_was_skipped_redone_and_paused_in(tmp_path):
    for name, first in (("P01", "skip"), ("P02", "redo"), ("P03", "pause")):
        script = [Wanted("exposure", first, after=30)]
        if first == "pause":
            script.append(Wanted("exposure", "go_on"))
        steered(tmp_path, *script, participant=name)
    written = build_report(tmp_path / "S", out=tmp_path / "report")
    assert written.index.exists()
    assert_whole(tmp_path)
