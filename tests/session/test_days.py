"""Sessions on different days: none begins too soon after the one before."""

from __future__ import annotations

import json
import re
from datetime import UTC, datetime, timedelta

import pytest

from tests.support.session import run
from tests.support.study import PROTOCOL, AheadHeadset, LateFocus, Scripted, tiny_protocol
from vrcomfort.errors import InputError
from vrcomfort.records import session_folder


def go(tmp_path, respondent=None, *, hours=20, **more):
    return run(
        tiny_protocol(tmp_path, f"hours_between_sessions = {hours}.0\n{PROTOCOL}"),
        "P01",
        study=tmp_path / "S",
        load_scene=lambda _: None,
        headset_for=lambda *_: AheadHeadset(),
        renderer=LateFocus(),
        respondent=respondent or Scripted(),
        exposure_s=1.0,
        **more,
    )


def ended_hours_ago(tmp_path, hours: float) -> None:
    file = session_folder(tmp_path / "S", "P01", 1) / "manifest.json"
    manifest = json.loads(file.read_text(encoding="utf-8"))
    ended = datetime.now(UTC) - timedelta(hours=hours)
    manifest["finished_at"] = ended.isoformat(timespec="seconds")
    file.write_text(json.dumps(manifest), encoding="utf-8")


@pytest.mark.parametrize(("hours", "begins"), [(19.9, False), (20.1, True)])
def test_the_next_session_waits_for_its_hours(tmp_path, hours, begins):
    assert go(tmp_path, sessions=[1]).status == "enrolled"
    ended_hours_ago(tmp_path, hours)
    if begins:
        assert go(tmp_path, sessions=[2]).status == "completed"
        return
    told = f"session 1 of P01 ended {hours} h ago, and the protocol wants 20 h between sessions"
    with pytest.raises(InputError, match=re.escape(told)):
        go(tmp_path, sessions=[2])
    assert not session_folder(tmp_path / "S", "P01", 2).exists()


def test_a_clock_that_was_set_back_counts_as_no_time(tmp_path):
    go(tmp_path, sessions=[1])
    ended_hours_ago(tmp_path, -100)
    with pytest.raises(InputError, match=r"ended 0\.0 h ago"):
        go(tmp_path, sessions=[2])


def test_an_interrupted_session_goes_on_at_once(tmp_path):
    class Interrupting(Scripted):
        def ask(self, form, heard):
            if form.timepoint == "post":
                raise KeyboardInterrupt
            super().ask(form, heard)

    go(tmp_path, sessions=[1])
    ended_hours_ago(tmp_path, 21)
    assert go(tmp_path, Interrupting(), sessions=[2]).status == "aborted"
    ended_hours_ago(tmp_path, 1)
    assert go(tmp_path, sessions=[2], resume=True).status == "completed"


def test_simulated_participants_have_waited(tmp_path):
    simulated = Scripted()
    simulated.name = "simulated"
    assert go(tmp_path, simulated).status == "completed"
