"""Sessions that end before their last exposure: by the participant, by a limit, by a fault."""

from __future__ import annotations

import pytest

from tests.support.session import go, manifest, rows, status
from tests.support.study import AheadHeadset, LateFocus, Scripted
from vrcomfort.errors import InputError, RuntimeLostError


def test_a_high_rating_stops_the_exposure_and_the_study(tmp_path):
    outcome = go(tmp_path, Scripted(rates=15))
    (trial,) = rows(tmp_path, "trials.csv")
    assert (trial["status"], trial["abort_code"]) == ("stopped", "rating")
    assert int(trial["frames"]) < 40
    assert outcome.status == "withdrawn"
    assert "fms 15 reached the limit 15" in status(tmp_path)[1]
    assert [row["timepoint"] for row in rows(tmp_path, "questionnaires.csv")[::16]] == [
        "baseline",
        "post",
    ]


def test_withdrawing_during_exposure_keeps_everything(tmp_path):
    outcome = go(tmp_path, Scripted(withdraw_at_s=4.0))
    (trial,) = rows(tmp_path, "trials.csv")
    assert (trial["status"], trial["abort_code"], trial["frames"]) == (
        "withdrawn", "participant", "41",
    )  # fmt: skip
    assert len(rows(tmp_path, "frames.csv")) == 10 + 41
    assert len(rows(tmp_path, "questionnaires.csv")) == 32
    assert (outcome.status, outcome.sessions) == ("withdrawn", (1,))
    assert status(tmp_path) == ("withdrawn", "session 1: had enough")
    assert manifest(tmp_path)["status"] == "withdrawn"


def test_withdrawing_in_training_is_an_exposure_of_no_time(tmp_path):
    outcome = go(tmp_path, Scripted(withdraw_at_s=0.5))
    assert (outcome.status, outcome.note) == ("withdrawn", "had enough")
    (trial,) = rows(tmp_path, "trials.csv")
    assert (trial["status"], trial["abort_code"], trial["frames"]) == (
        "withdrawn",
        "participant",
        "0",
    )
    assert trial["start_s"] == trial["end_s"]
    assert {row["trial"] for row in rows(tmp_path, "frames.csv")} == {"0"}


def test_somebody_who_withdrew_may_refuse_the_questionnaire(tmp_path):
    go(tmp_path, Scripted(withdraw_at_s=4.0, refuses=True))
    assert {row["timepoint"] for row in rows(tmp_path, "questionnaires.csv")} == {"baseline"}
    assert status(tmp_path) == ("withdrawn", "session 1: had enough")
    assert "questionnaire_refused" in [row["name"] for row in rows(tmp_path, "events.csv")]


def test_withdrawing_at_a_question_keeps_the_answers_before(tmp_path):
    go(tmp_path, Scripted(withdraw_at_item="sweating"))
    post = [r for r in rows(tmp_path, "questionnaires.csv") if r["timepoint"] == "post"]
    assert len(post) == 6
    assert rows(tmp_path, "trials.csv")[0]["status"] == "completed"
    assert status(tmp_path)[0] == "withdrawn"


@pytest.mark.parametrize(
    ("headset", "respondent", "trials", "frames"),
    [
        (lambda: AheadHeadset(interrupt_at=30), Scripted(), 1, 30),
        (lambda: AheadHeadset(interrupt_at=5), Scripted(), 1, 5),
        (AheadHeadset, Scripted(interrupt_at_item="nausea"), 1, 110),
    ],
)
def test_control_c_keeps_everything(tmp_path, headset, respondent, trials, frames):
    outcome = go(tmp_path, respondent, headset=headset)
    assert outcome.status == "aborted"
    assert len(rows(tmp_path, "trials.csv")) == trials
    assert len(rows(tmp_path, "frames.csv")) == frames
    assert manifest(tmp_path)["status"] == "aborted"
    assert status(tmp_path) == ("enrolled", "session 1 aborted")
    if headset is not AheadHeadset:
        (trial,) = rows(tmp_path, "trials.csv")
        assert (trial["status"], trial["abort_code"]) == ("aborted", "operator")


def test_an_error_while_drawing_leaves_an_aborted_trial(tmp_path):
    class Broken(LateFocus):
        def render(self, frame, scene_time_s):
            if frame.index == 20:
                raise InputError("the scene broke")
            return super().render(frame, scene_time_s)

    with pytest.raises(InputError, match="the scene broke"):
        go(tmp_path, Scripted(), renderer=Broken())
    (trial,) = rows(tmp_path, "trials.csv")
    assert (trial["status"], trial["abort_code"], trial["frames"]) == ("aborted", "error", "10")
    assert manifest(tmp_path)["status"] == "aborted"


def test_a_headset_that_ends_in_an_exposure_leaves_a_session_to_resume(tmp_path):
    with pytest.raises(RuntimeLostError, match="in the middle of an exposure"):
        go(tmp_path, Scripted(), headset=lambda: AheadHeadset(frames_left=50), sessions=[1])
    (trial,) = rows(tmp_path, "trials.csv")
    assert (trial["status"], trial["abort_code"], trial["frames"]) == (
        "aborted",
        "headset_ended",
        "40",
    )
    assert manifest(tmp_path)["status"] == "aborted"
    assert go(tmp_path, Scripted(), sessions=[1], resume=True).sessions == (1,)
    assert manifest(tmp_path)["status"] == "completed"
