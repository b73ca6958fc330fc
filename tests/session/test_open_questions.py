"""What an interruption cut off is asked first; what it is too late for is said to be missed."""

from __future__ import annotations

import json
import os
import time
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import pytest

from tests.support import resume
from tests.support.resume import attempts, folder, manifest, rows
from tests.support.study import PROTOCOL, Scripted, tiny_protocol
from vrcomfort.protocol import Protocol
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.session import WallClock

go = partial(resume.go, exposure_s=1.0)

SSQ = shipped_instruments()["ssq"]

ITEMS = [item.name for item in SSQ.items]


def at_once(tmp_path: Path, text: str = PROTOCOL) -> Protocol:
    """Return the small protocol without its rest, which would pass on the wall clock."""
    return tiny_protocol(tmp_path, text.replace("wait_s = 60.0", "wait_s = 0.0"))


def cut_at(tmp_path: Path, item: str, **more):
    outcome = go(tmp_path, Scripted(interrupt_at_item=item), **more)
    assert outcome.status == "aborted"


def post_rows(tmp_path: Path, trial: int) -> list[dict[str, str]]:
    return [
        row
        for row in rows(tmp_path, "questionnaires")
        if row["timepoint"] == "post" and row["trial"] == str(trial)
    ]


def age(tmp_path: Path, minutes: float) -> None:
    """Let the exposure have ended so long ago."""
    file = folder(tmp_path) / "manifest.json"
    content = json.loads(file.read_text())
    content["exposure_ended"]["at"] = (datetime.now(UTC) - timedelta(minutes=minutes)).isoformat()
    file.write_text(json.dumps(content))


@pytest.mark.parametrize("item", [ITEMS[0], ITEMS[-1]])
def test_the_open_items_are_asked_first_and_only_they(tmp_path, item):
    cut_at(tmp_path, item)
    assert go(tmp_path, resume=True).status in {"enrolled", "completed"}
    answered = post_rows(tmp_path, 1)
    assert [row["item"] for row in answered] == ITEMS, "each item once, in its order"
    cut = ITEMS.index(item)
    assert [row["resumed"] for row in answered] == ["0"] * cut + ["1"] * (16 - cut)
    assert [row["order"] for row in answered] == [str(n) for n in range(1, 17)]
    assert [row[3] for row in attempts(tmp_path)] == ["completed", "completed"]
    names = [row["name"] for row in rows(tmp_path, "events")]
    again = names.index("session_resumed")
    assert names[again + 1] == "questionnaire_resumed", "before the new baseline"
    later = [r["timepoint"] for r in rows(tmp_path, "questionnaires") if r["resumed"] == "1"]
    assert later[16 - cut] == "baseline", "and that before the next exposure"


def test_nothing_is_asked_again_when_nothing_was_open(tmp_path):
    go(tmp_path, interrupt=(2, 3))
    go(tmp_path, resume=True)
    assert len(post_rows(tmp_path, 1)) == 16
    assert "questionnaire_resumed" not in {row["name"] for row in rows(tmp_path, "events")}


def test_what_was_cut_after_the_last_exposure_is_finished_without_a_baseline(tmp_path):
    def cut():
        class Cut(Scripted):
            def ask(self, form, heard):
                if form.timepoint == "recovery":
                    for each in form.instrument.items[:3]:
                        heard(each.name, 1, 2.0)
                    raise KeyboardInterrupt
                super().ask(form, heard)

        return Cut()

    assert go(tmp_path, cut()).status == "aborted"
    go(tmp_path, resume=True)
    recovery = [r for r in rows(tmp_path, "questionnaires") if r["timepoint"] == "recovery"]
    assert [row["item"] for row in recovery] == ITEMS
    baselines = [r for r in rows(tmp_path, "questionnaires") if r["timepoint"] == "baseline"]
    assert len(baselines) == 16


@pytest.mark.parametrize(("minutes", "asked"), [(9.0, True), (11.0, False)])
def test_symptoms_fade_so_the_protocol_says_until_when(tmp_path, minutes, asked):
    cut_at(tmp_path, ITEMS[4], clock=WallClock(), protocol=at_once(tmp_path))
    age(tmp_path, minutes)
    outcome = go(tmp_path, resume=True, clock=WallClock(), protocol=at_once(tmp_path))
    assert len(post_rows(tmp_path, 1)) == (16 if asked else 4)
    missed = [r for r in rows(tmp_path, "events") if r["name"] == "questionnaire_missed"]
    assert len(missed) == len(manifest(tmp_path)["missed_questions"]) == (0 if asked else 1)
    if not asked:
        assert all(item in missed[0]["detail"] for item in ITEMS[4:])
        assert any("12 of 16 items of ssq (post) after trial 1" in w for w in outcome.warnings)


def test_without_a_note_of_the_end_the_rows_own_age_counts(tmp_path):
    cut_at(tmp_path, ITEMS[4], clock=WallClock(), protocol=at_once(tmp_path))
    file = folder(tmp_path) / "manifest.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "exposure_ended": None}))
    long_ago = time.time() - 3600
    os.utime(folder(tmp_path) / "trials.csv", (long_ago, long_ago))
    go(tmp_path, resume=True, clock=WallClock(), protocol=at_once(tmp_path))
    assert len(post_rows(tmp_path, 1)) == 4
    assert "60 min ago" in manifest(tmp_path)["missed_questions"][0]


def test_who_was_stopped_by_a_rating_is_not_exposed_again(tmp_path):
    outcome = go(tmp_path, Scripted(rates=16, interrupt_at_item=ITEMS[2]))
    assert outcome.status == "aborted"
    outcome = go(tmp_path, resume=True)
    assert outcome.status == "withdrawn"
    assert [row[3] for row in attempts(tmp_path)] == ["stopped"]
    assert [row["item"] for row in post_rows(tmp_path, 1)] == ITEMS, "how it was is still asked"


def test_the_limit_is_the_protocols(tmp_path):
    protocol = at_once(tmp_path, "resumed_questions_within_s = 30.0\n" + PROTOCOL)
    cut_at(tmp_path, ITEMS[4], clock=WallClock(), protocol=protocol)
    age(tmp_path, 1.0)
    go(tmp_path, resume=True, clock=WallClock(), protocol=protocol)
    assert len(post_rows(tmp_path, 1)) == 4
