"""How regularly frames came, and what they cost: counted always, flagged where it is too much."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.resume import attempts, go, manifest, rows
from tests.support.study import (
    PROTOCOL,
    AheadHeadset,
    LateFocus,
    Picture,
    frame,
    read_rows,
    tiny_protocol,
)
from vrcomfort.errors import InputError
from vrcomfort.frame import FrameWaits, GpuTime, PartTime
from vrcomfort.records import Recorder, read_participants
from vrcomfort.session.frame_log import Durations, FrameLog


def test_a_flagged_trial_keeps_its_status_and_its_note(tmp_path):
    class Stutters(AheadHeadset):
        """Every fifth frame lasts twice as long."""

        def frames(self):
            for index in range(self.frames_left):
                yield frame(index, time_ns=(index + index // 5) * 100_000_000)

    outcome = go(tmp_path, headset_for=lambda *_: Stutters())
    assert {row[3] for row in attempts(tmp_path)} == {"completed"}
    first, second = rows(tmp_path, "timing")
    assert (first["flagged"], second["flagged"]) == ("1", "1")
    assert first["dropped"] == rows(tmp_path, "trials")[0]["dropped"]
    assert 15 < float(first["dropped_percent"]) < 25
    assert (first["interval_median_ms"], first["interval_p95_ms"]) == ("100.0", "200.0")
    flags = [row for row in rows(tmp_path, "events") if row["name"] == "timing_flag"]
    assert len(flags) == len(manifest(tmp_path)["timing_flags"]) == len(outcome.warnings) == 2
    (person,) = read_participants(tmp_path / "S")
    assert "session 1, trial 1, attempt 1" in person.note


def test_slow_drawing_drops_frames_and_never_lengthens_an_exposure(tmp_path):
    class Slow(AheadHeadset):
        """A display that has gone on by three refreshes whenever a frame is ready."""

        def frames(self):
            for index in range(self.frames_left):
                yield frame(index, time_ns=3 * index * 100_000_000)

    go(tmp_path, headset_for=lambda *_: Slow())
    for trial in rows(tmp_path, "trials"):
        assert float(trial["end_s"]) - float(trial["start_s"]) == pytest.approx(10.0)
        assert (trial["frames"], trial["dropped"]) == ("34", "33")


def test_the_protocol_says_how_much_may_be_dropped(tmp_path):
    assert tiny_protocol(tmp_path).max_dropped_percent == 5.0
    with pytest.raises(InputError, match="max_dropped_percent"):
        tiny_protocol(tmp_path, "max_dropped_percent = 101\n" + PROTOCOL)


@given(st.lists(st.integers(0, 50_000), min_size=1), st.integers(1, 100))
def test_percentiles_are_nearest_ranks(hundredths, percent):
    durations = Durations()
    for value in hundredths:
        durations.add(value / 100)
    expected = np.percentile(np.array(hundredths) / 100, percent, method="inverted_cdf")
    assert durations.percentile_ms(percent) == pytest.approx(expected)


def test_nothing_has_no_percentiles():
    assert Durations().percentile_ms(50) is None


@dataclass(frozen=True)
class TimedPicture(Picture):
    gpu_times: tuple[GpuTime, ...] = ()


@dataclass
class LateTimes(LateFocus):
    """A renderer whose GPU times arrive five frames late."""

    waiting: list[GpuTime] = field(default_factory=list)

    def render(self, frame, scene_time_s):
        self.waiting.append(GpuTime(frame.index, 1.0 + frame.index))
        late, self.waiting = self.waiting[:-5], self.waiting[-5:]
        return TimedPicture(
            focus_samples=super().render(frame, scene_time_s).focus_samples, gpu_times=tuple(late)
        )


def test_each_frame_gets_its_own_gpu_time(tmp_path):
    renderer = LateTimes()
    renderer._focus, renderer._late = True, []
    with Recorder(tmp_path, "P1", 1) as recorder:
        log = FrameLog(recorder)
        for index in range(30):
            shown = replace(frame(index), discontinuity=index == 0)
            log.add(shown, renderer.render(shown, 0.0), trial=1, session_s=index / 10)
        log.finish(renderer.drain(), renderer.waiting)
    found = read_rows(recorder.folder / "frames.csv")
    assert [float(row["gpu_ms"]) for row in found] == [1.0 + index for index in range(30)]
    assert {row["focus_m"] for row in found} == {"2.5"}
    assert log.timing.gpu.percentile_ms(50) == 15.0
    assert log.timing.gpu.percentile_ms(100) == 30.0


@dataclass(frozen=True)
class PartlyTimed(Picture):
    times_parts: bool = False
    part_times: tuple[PartTime, ...] = ()


def test_parts_of_sampled_frames_and_waits_for_the_runtime_have_their_rows(tmp_path):
    with Recorder(tmp_path, "P1", 1) as recorder:
        log = FrameLog(recorder)
        for index in range(12):
            late = (PartTime(4, "scene", 1.5, 2.5), PartTime(4, "vignette", 0.25, None))
            drawn = PartlyTimed((), times_parts=index == 4, part_times=late if index == 9 else ())
            waits = FrameWaits(8.0 + index, 0.5) if index else None
            log.add(frame(index), drawn, trial=1, session_s=index / 10, waits=waits)
        log.finish()
    parts = read_rows(recorder.folder / "part_times.csv")
    assert [(row["session_s"], row["part"], row["cpu_ms"], row["gpu_ms"]) for row in parts] == [
        ("0.4", "scene", "1.5", "2.5"),
        ("0.4", "vignette", "0.25", ""),
    ]
    assert {row["trial"] for row in parts} == {"1"}
    rows = read_rows(recorder.folder / "frames.csv")
    assert [row["wait_ms"] for row in rows] == ["", *(f"{8.0 + index}" for index in range(1, 12))]
    assert [row["swapchain_wait_ms"] for row in rows] == ["", *["0.5"] * 11]
    assert rows[4]["xr_time_ns"] == parts[0]["xr_time_ns"]
