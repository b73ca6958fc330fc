"""clocks.csv: every time on record can be put on the system's clock."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.support.doc_blocks import blocks
from tests.support.exchange import cell
from tests.support.resume import go
from tests.support.study import PROTOCOL, AheadHeadset, read_rows, tiny_protocol
from vrcomfort.exchange.anonymising import AnonymisingOptions, anonymise
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.frame import Frame
from vrcomfort.session.clock import WallClock

SESSION = "S/sub-P01/ses-1"


class Tells(AheadHeadset):
    """A headset whose display clock counts from when it was made, and goes on afterwards."""

    def __init__(self, **settings: object) -> None:
        super().__init__(**settings)
        self.zero_ns = time.monotonic_ns()

    def display_now_ns(self) -> int:
        return time.monotonic_ns() - self.zero_ns

    def frames(self) -> Iterator[Frame]:
        start_ns = self.display_now_ns()
        for each in super().frames():
            yield replace(each, predicted_display_time_ns=start_ns + each.predicted_display_time_ns)


class Paced(Tells):
    """A headset with a hundred frames a second, each of which is waited for, as in a display."""

    refresh_hz = 100.0

    def frames(self) -> Iterator[Frame]:
        for each in AheadHeadset.frames(self):
            time.sleep(0.01)
            now_ns = self.display_now_ns()
            yield replace(each, predicted_display_time_ns=now_ns, period_ns=10_000_000)


def record(folder: Path) -> None:
    text = PROTOCOL.replace("wait_s = 60.0", "wait_s = 0.0")
    text = text.replace("exposure_s = 10.0", "exposure_s = 0.5")
    text = text.replace("training_s = 1.0", "training_s = 0.2")
    text = text.partition("[ratings]")[0]
    protocol = tiny_protocol(folder, text)
    go(folder, protocol=protocol, headset_for=lambda *_: Paced(), clock=WallClock())


class Recorded(NamedTuple):
    """A session that nobody changes, and the machine's clocks before and after it."""

    folder: Path
    before_ns: int
    unix_ns: int
    after_ns: int


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    folder = tmp_path_factory.mktemp("clocks")
    before_ns, unix_ns = time.monotonic_ns(), time.time_ns()
    record(folder)
    return Recorded(folder, before_ns, unix_ns, time.monotonic_ns())


def test_each_exposure_has_readings_from_its_first_frame_on(recorded: Recorded) -> None:
    folder, before_ns, unix_ns, after_ns = recorded
    rows = read_rows(folder / SESSION / "clocks.csv")
    assert len(rows) == 3  # training, and two exposures
    for row in rows:
        assert before_ns < int(row["monotonic_ns"]) < after_ns
        assert abs(int(row["unix_ns"]) - unix_ns) < 60e9 + after_ns - before_ns
        assert 0 < int(row["took_ns"]) < after_ns - before_ns
        assert row["lsl_s"] == ""
    seconds = [float(row["session_s"]) for row in rows]
    monotonic = [int(row["monotonic_ns"]) / 1e9 for row in rows]
    apart_s = [m - s for s, m in zip(seconds, monotonic, strict=True)]
    took_s = sum(int(row["took_ns"]) for row in rows) / 1e9
    assert max(apart_s) - min(apart_s) < 0.02 + took_s
    assert verify_study(folder / "S").findings == []


def test_display_times_on_record_go_on_through_an_interruption(tmp_path: Path) -> None:
    """A headset that starts anew tells smaller times; those on record, and the bridge, do not."""
    text = PROTOCOL.replace("wait_s = 60.0", "wait_s = 0.0")
    stops = Tells(interrupt_at=95)
    headsets = iter([Tells(), stops])
    protocol = tiny_protocol(tmp_path, text)
    go(tmp_path, protocol=protocol, headset_for=lambda *_: next(headsets), clock=WallClock())
    before_ns = time.monotonic_ns()
    again = Tells()
    go(
        tmp_path,
        protocol=protocol,
        headset_for=lambda *_: again,
        clock=WallClock(),
        resume=True,
    )
    took_ns = time.monotonic_ns() - before_ns
    frames = read_rows(tmp_path / SESSION / "frames.csv")
    times = [int(row["xr_time_ns"]) for row in frames]
    assert times == sorted(times)
    last = read_rows(tmp_path / SESSION / "clocks.csv")[-1]
    first = next(row for row in frames if row["resumed"] == "1")
    monotonic_minus_xr_ns = int(last["monotonic_ns"]) - int(last["xr_time_ns"])
    seen_ns = int(first["xr_time_ns"]) + monotonic_minus_xr_ns
    assert abs(seen_ns - int(last["monotonic_ns"])) < 2e9 + took_ns
    assert last["resumed"] == "1"


def test_a_headset_that_does_not_tell_leaves_display_time_blank(tmp_path: Path) -> None:
    text = PROTOCOL.replace("wait_s = 60.0", "wait_s = 0.0")
    go(tmp_path, protocol=tiny_protocol(tmp_path, text), clock=WallClock())
    rows = read_rows(tmp_path / SESSION / "clocks.csv")
    assert rows
    assert {row["xr_time_ns"] for row in rows} == {""}


def test_the_python_of_the_documentation_puts_frames_on_the_systems_clock(
    recorded: Recorded,
) -> None:
    (block,) = (each.text for each in blocks("python") if each.page == "timing.md")
    space: dict[str, Any] = {}
    code = block.replace("my_study/sub-P01/ses-1", (recorded.folder / SESSION).as_posix())
    exec(compile(code, "timing.md", "exec"), space)  # noqa: S102
    seen_ns = space["seen_ns"].iloc[-1]
    assert abs(seen_ns - space["clocks"].monotonic_ns.iloc[-1]) < 60e9


def test_a_simulated_session_has_no_clocks(tmp_path: Path) -> None:
    go(tmp_path)
    assert not (tmp_path / SESSION / "clocks.csv").exists()


def test_verify_finds_a_clock_that_goes_back_and_a_copy_has_none(
    recorded: Recorded, tmp_path: Path
) -> None:
    shutil.copytree(recorded.folder / "S", tmp_path / "S")
    anonymise(
        tmp_path / "S", tmp_path / "out", AnonymisingOptions(keep_motion=True, keep_gaze=True)
    )
    assert not list((tmp_path / "out").rglob("clocks.csv"))
    cell(tmp_path / SESSION / "clocks.csv", 4, "monotonic_ns", "17")
    told = [str(each) for each in verify_study(tmp_path / "S").faults]
    assert any("clocks.csv, line 4: monotonic_ns 17 is before" in each for each in told)


def test_readings_come_every_ten_seconds(tmp_path: Path) -> None:
    text = PROTOCOL.replace("wait_s = 60.0", "wait_s = 0.0").replace(
        "exposure_s = 10.0", "exposure_s = 25.0"
    )
    protocol = tiny_protocol(tmp_path, text)
    go(tmp_path, protocol=protocol, headset_for=lambda *_: Tells(), clock=WallClock())
    assert len(read_rows(tmp_path / SESSION / "clocks.csv")) == 1 + 2 * 3
