"""What ends an exposure, a session or the study; what of it is on the disk; who may come back."""

from __future__ import annotations

import json
from datetime import datetime

import pytest

from tests.support.session import run
from tests.support.study import (
    PROTOCOL,
    AheadHeadset,
    LateFocus,
    Scripted,
    read_rows,
    tiny_protocol,
)
from vrcomfort.errors import InputError
from vrcomfort.exchange.anonymising import DateShift, of_manifest
from vrcomfort.exchange.verifying.study import verify_study
from vrcomfort.records import read_participants, session_folder
from vrcomfort.report.notices import _ended_early
from vrcomfort.report.study_data import read_study
from vrcomfort.report.withdrawals import EarlyEnding, count_withdrawals, find_withdrawals

RISE = '[[stop.score_rise]]\ninstrument = "ssq"\nscale = "T"\nby = 100.0\n'


class Answering(Scripted):
    """Answers every item of a timepoint alike."""

    def __init__(self, **answers: int) -> None:
        super().__init__()
        self.answers = answers

    def ask(self, form, heard):
        for item in form.instrument.items:
            heard(item.name, self.answers.get(form.timepoint, 0), 2.0)


def go(tmp_path, respondent, more: str, *, text=PROTOCOL, exposure_s=1.0, **options):
    return run(
        tiny_protocol(tmp_path, f"{text}\n{more}"),
        "P01",
        study=tmp_path / "S",
        exposure_s=exposure_s,
        load_scene=lambda _: None,
        headset_for=lambda *_: AheadHeadset(),
        renderer=LateFocus(),
        respondent=respondent,
        **options,
    )


def session_of(tmp_path, number: int = 1):
    folder = session_folder(tmp_path / "S", "P01", number)
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    return manifest, read_rows(folder / "trials.csv"), read_rows(folder / "events.csv")


def whole(tmp_path) -> bool:
    return not verify_study(tmp_path / "S").faults


def test_a_participant_who_ends_a_session_may_come_back(tmp_path):
    """And a copy for others keeps who ended it, without the words."""
    stop = '[stop]\nparticipant = "session"\n'
    outcome = go(tmp_path, Scripted(withdraw_at_s=5.0), stop, sessions=[1])
    assert outcome.status == "enrolled"
    manifest, (trial,), events = session_of(tmp_path)
    assert manifest["status"] == "ended"
    assert manifest["ended"] == {"by": "participant", "ends": "session", "reason": "had enough"}
    assert (trial["status"], trial["abort_code"]) == ("withdrawn", "participant_session")
    assert events[-1]["name"] == "ended"
    began = datetime.fromisoformat(manifest["started_at"])
    shared = of_manifest(manifest, "X01", DateShift(began, all_one=True))
    assert shared["ended"] == {"by": "participant", "ends": "session", "reason": "left out"}
    (person,) = read_participants(tmp_path / "S")
    assert (person.status, person.note) == ("enrolled", "session 1 ended: had enough")
    assert whole(tmp_path)
    assert go(tmp_path, Scripted(), stop).status == "completed"
    assert session_of(tmp_path, 2)[0]["status"] == "completed"
    assert whole(tmp_path)


def test_a_rise_of_a_score_ends_the_session_after_its_questions(tmp_path):
    outcome = go(tmp_path, Answering(baseline=0, post=2), RISE, sessions=[1])
    assert outcome.status == "enrolled"
    manifest, trials, _ = session_of(tmp_path)
    assert [(row["status"], row["abort_code"]) for row in trials] == [("completed", "")]
    assert manifest["ended"]["by"] == "score"
    assert manifest["ended"]["reason"] == "ssq T rose from 0 to 157.08; the limit is 100"
    assert whole(tmp_path)


def test_it_is_the_rise_that_counts_and_not_the_score(tmp_path):
    assert go(tmp_path, Answering(baseline=1, post=2), RISE).status == "completed"


def test_a_score_may_end_the_study(tmp_path):
    rule = f'{RISE}ends = "study"\n'
    assert go(tmp_path, Answering(post=3), rule).status == "withdrawn"
    with pytest.raises(InputError, match="is withdrawn from this study"):
        go(tmp_path, Scripted(), rule)


def test_a_program_killed_after_the_trial_ends_the_session_alone_when_it_goes_on(tmp_path):
    stop = '[stop]\nparticipant = "session"\n'

    class Killed(Scripted):
        def ask(self, form, heard):
            if form.after_withdrawal:
                raise KeyboardInterrupt
            super().ask(form, heard)

    assert go(tmp_path, Killed(withdraw_at_s=5.0), stop, sessions=[1]).status == "aborted"
    outcome = go(tmp_path, Scripted(), stop, sessions=[1], resume=True)
    assert outcome.status == "enrolled"
    manifest, trials, _ = session_of(tmp_path)
    assert manifest["status"] == "ended"
    assert len(trials) == 1  # nobody was exposed again
    answered = read_rows(session_folder(tmp_path / "S", "P01", 1) / "questionnaires.csv")
    assert sum(row["timepoint"] == "post" for row in answered) == 16


def test_reports_count_each_kind_and_who_came_back_is_no_withdrawal(tmp_path):
    text = PROTOCOL.replace("stop_at = 15", 'stop_at = 15\nstop_ends = "exposure"')
    stop = '[stop]\nparticipant = "session"\n'
    go(tmp_path, Scripted(rates=16), stop, sessions=[1], text=text)
    go(tmp_path, Scripted(withdraw_at_s=2.0), stop, text=text)
    study = read_study(tmp_path / "S")
    assert find_withdrawals(study) == []
    assert count_withdrawals(study, []).early_endings == (
        EarlyEnding(ends="exposure", by="rating", n=2),
        EarlyEnding(ends="session", by="participant", n=1),
    )
    assert _ended_early(study) == [
        "ended before their time: 2 exposures by a rating, 1 session by the participant"
    ]


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (RISE.replace('"ssq"', '"vrsq"'), "`vrsq` is not asked both at session_start and"),
        (RISE.replace('"T"', '"total"'), "the SSQ has no scale `total`"),
        ('[stop]\nparticipant = "exposure"', "should be 'session' or 'study'"),
    ],
)
def test_rules_that_cannot_be_are_refused(tmp_path, more, told):
    with pytest.raises(InputError) as caught:
        tiny_protocol(tmp_path, f"{PROTOCOL}\n{more}")
    assert told in str(caught.value)


def test_a_task_that_is_done_ends_the_exposure_where_the_protocol_says_so(tmp_path, monkeypatch):
    from vrcomfort.session.task_run import TaskRun

    monkeypatch.setattr(TaskRun, "done", property(lambda self: self.elapsed_s > 3.0))
    task = '[[tasks]]\nname = "look"\nkind = "exploration"\n'
    head, table, rest = PROTOCOL.partition("[[conditions]]")
    ended = f'task = "look"\nexposure_ends = "task"\n{table}'
    go(tmp_path, Scripted(), task, sessions=[1], text=f"{head}{ended}{rest}", exposure_s=None)
    _, trials, _ = session_of(tmp_path)
    assert [(row["status"], row["abort_code"]) for row in trials] == [("completed", "task")] * 2
    for row in trials:
        assert float(row["end_s"]) - float(row["start_s"]) == pytest.approx(3.2, abs=0.15)
