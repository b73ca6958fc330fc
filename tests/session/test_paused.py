"""Time in which nobody looks is no exposure, and what happens to the headset is kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from tests.support.resume import go, rows
from tests.support.session import run
from tests.support.study import AheadHeadset, LateFocus, Scripted, read_rows, tiny_protocol
from vrcomfort.frame import Frame, HeadsetEvent
from vrcomfort.records import session_folder
from vrcomfort.respondent import Withdrew


@dataclass
class TakenOff(AheadHeadset):
    """Off the head from frame 30 to 49; the frames that follow start afresh."""

    def frames(self) -> Iterator[Frame]:
        for frame in super().frames():
            off = 30 <= frame.index < 50
            if frame.index in {30, 50}:
                self.events.append(HeadsetEvent("headset_off" if off else "headset_on"))
            yield replace(frame, paused=off, discontinuity=frame.index == 50)


def test_a_headset_taken_off_stops_the_exposure_clock(tmp_path: Path) -> None:
    respondent = Scripted()
    outcome = run(
        tiny_protocol(tmp_path),
        "P01",
        study=tmp_path / "S",
        load_scene=lambda source: source,
        headset_for=lambda *_: TakenOff(),
        renderer=LateFocus(),
        respondent=respondent,
        sessions=[1],
    )
    assert outcome.sessions == (1,)
    folder = session_folder(tmp_path / "S", "P01", 1)
    trials = read_rows(folder / "trials.csv")
    assert [(row["status"], row["frames"], row["dropped"]) for row in trials] == [
        ("completed", "100", "0"),
        ("completed", "100", "0"),
    ]
    assert respondent.perceived_s == [10.0, 10.0]
    names = [row["name"] for row in read_rows(folder / "events.csv")]
    assert names.count("headset_off") == names.count("headset_on") == 2


def test_a_wish_to_stop_in_a_rest_is_heard_at_once(tmp_path: Path) -> None:
    class Rests(Scripted):
        def resting(self, left_s: float) -> bool:
            if left_s < 58.0:
                raise Withdrew("enough")
            return False

    assert go(tmp_path, Rests()).status == "withdrawn"
    (rest,) = (row for row in rows(tmp_path, "events") if row["name"] == "rest")
    assert float(rest["duration_s"]) == pytest.approx(2.2, abs=0.2)
