"""LabStreamingLayer: what happens in a session is received by another process, with its times."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

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
from tests.support.waiting import WAIT_S
from vrcomfort.cli.session_devices import Outlets, open_outlets
from vrcomfort.errors import InputError
from vrcomfort.frame import Frame
from vrcomfort.geometry import Gaze
from vrcomfort.session.clock import WallClock

pylsl = pytest.importorskip("pylsl", reason="pylsl is not installed")

RECEIVER = """
import json, sys, time
import pylsl

study, patience_s = sys.argv[1], float(sys.argv[2])
inlets = {}
for name in ("markers", "ratings", "head", "gaze"):
    found = pylsl.resolve_byprop("source_id", f"vrcomfort-{study}-P01-{name}", 1, patience_s)
    inlets[name] = pylsl.StreamInlet(found[0], max_buflen=600)
    inlets[name].open_stream(timeout=patience_s)
give_up_s = time.monotonic() + patience_s
offset_s = inlets["markers"].time_correction(timeout=patience_s)
while abs(offset_s) > 0.01 and time.monotonic() < give_up_s:  # the way there was interrupted
    time.sleep(0.5)
    offset_s = inlets["markers"].time_correction(timeout=patience_s)
print("ready", flush=True)
samples = {name: [] for name in inlets}
wanted = {}
give_up_s = time.monotonic() + patience_s
while time.monotonic() < give_up_s:
    for name, inlet in inlets.items():
        values, stamps = inlet.pull_chunk(timeout=0.02)
        here_s = pylsl.local_clock()
        samples[name] += [[value, stamp, here_s] for value, stamp in zip(values, stamps)]
    if not wanted and any("session_end" in each[0][0] for each in samples["markers"]):
        wanted = json.loads(sys.stdin.readline())
    if wanted and all(len(samples[name]) >= count for name, count in wanted.items()):
        break
labels = pylsl.StreamInlet(found[0]).info(timeout=patience_s).get_channel_labels()
print(json.dumps({"offset_s": offset_s, "samples": samples, "labels": labels}), flush=True)
"""
OFFSET_NS = 3_000_000_000


class Tells(AheadHeadset):
    """A headset with eyes; its display clock is 3 s behind the system's, its frames 50 ms ahead."""

    def display_now_ns(self) -> int:
        return time.monotonic_ns() - OFFSET_NS

    def frames(self) -> Iterator[Frame]:
        start_ns = self.display_now_ns() + 50_000_000
        for each in super().frames():
            seen_ns = start_ns + each.predicted_display_time_ns
            gaze = Gaze(each.head_pose, valid=each.index % 5 != 2)
            yield replace(each, predicted_display_time_ns=seen_ns, gaze=gaze)


@pytest.fixture(scope="module", autouse=True)
def loopback(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep LabStreamingLayer on this machine."""
    settings = tmp_path_factory.mktemp("lsl") / "lsl_api.cfg"
    settings.write_text(
        "[ports]\nIPv6 = disable\n[multicast]\nResolveScope = machine\n"
        "[lab]\nKnownPeers = {127.0.0.1}\n"
    )
    before = os.environ.get("LSLAPICFG")
    os.environ["LSLAPICFG"] = str(settings)
    yield
    if before is None:
        del os.environ["LSLAPICFG"]
    else:
        os.environ["LSLAPICFG"] = before


def go(folder: Path, outlet: Outlets) -> None:
    text = PROTOCOL.replace("wait_s = 60.0", "wait_s = 0.0")
    run(
        tiny_protocol(folder, text),
        "P01",
        study=folder / "S",
        respondent=Scripted(),
        headset_for=lambda *_: Tells(),
        load_scene=lambda source: source,
        renderer=LateFocus(),
        clock=WallClock(),
        sessions=[1],
        outlet=outlet,
    )


@pytest.fixture(scope="module")
def received(tmp_path_factory: pytest.TempPathFactory, loopback: None) -> tuple[Path, Any]:
    """Run a session while another process listens."""
    folder = tmp_path_factory.mktemp("streamed")
    study = f"test{os.getpid()}"
    words = [sys.executable, "-c", RECEIVER, study, str(WAIT_S)]
    with (
        open_outlets(study, "P01", lsl=True, ttl=None, simulated=False) as outlet,
        subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other,
    ):
        assert other.stdout is not None
        assert other.stdout.readline() == "ready\n"
        go(folder, outlet)
        recorded = folder / "S" / "sub-P01" / "ses-1"
        kinds = {"head": "frames", "gaze": "gaze", "ratings": "ratings"}
        counts = {kind: len(read_rows(recorded / f"{kinds[kind]}.csv")) for kind in kinds}
        content = json.loads(other.communicate(f"{json.dumps(counts)}\n", timeout=WAIT_S)[0])
        assert other.returncode == 0
    return recorded, content


@pytest.mark.smoke
def test_another_process_gets_each_event_and_the_clocks_agree(received: tuple[Path, Any]) -> None:
    folder, content = received
    markers = [json.loads(value[0]) for value, _, _ in content["samples"]["markers"]]
    events = read_rows(folder / "events.csv")
    told = [each for each in markers if "onset_s" in each]
    assert [(each["name"], each["onset_s"], each["detail"]) for each in told] == [
        (row["name"], float(row["onset_s"]), row["detail"]) for row in events
    ]
    late_s = [here_s - stamp for _, stamp, here_s in content["samples"]["markers"]]
    offset_s = content["offset_s"]
    print(f"\nclocks differ by {1e6 * offset_s:.0f} µs; markers: {1e3 * max(late_s):.1f} ms late")
    assert abs(offset_s) < 0.01  # one machine, one clock: what is left is the way there and back
    assert max(late_s) < WAIT_S


def test_exposures_begin_when_their_first_frame_is_seen(received: tuple[Path, Any]) -> None:
    folder, content = received
    frames = read_rows(folder / "frames.csv")
    first = {row["trial"]: row for row in reversed(frames)}
    clocks = read_rows(folder / "clocks.csv")
    row = clocks[0]
    lsl_minus_xr_s = float(row["lsl_s"]) - int(row["xr_time_ns"]) / 1e9
    begun = [
        (json.loads(value[0]), stamp)
        for value, stamp, _ in content["samples"]["markers"]
        if "exposure_begins" in value[0]
    ]
    assert [each["trial"] for each, _ in begun] == [0, 1, 2]
    each, stamp = begun[0]
    assert each["condition"] == "plain"
    seen_s = int(first["0"]["xr_time_ns"]) / 1e9 + lsl_minus_xr_s
    took_s = int(row["took_ns"]) / 1e9  # of reading all clocks
    assert stamp == pytest.approx(seen_s, abs=2e-3 + took_s)


def test_head_gaze_and_ratings_are_those_on_record(received: tuple[Path, Any]) -> None:
    folder, content = received
    samples, frames = content["samples"], read_rows(folder / "frames.csv")
    assert len(samples["head"]) == len(samples["gaze"]) == len(frames)
    for (values, _, _), row in zip(samples["head"], frames, strict=True):
        assert values[:3] == [float(row[f"head_{axis}_m"]) for axis in "xyz"]
        assert values[7] == 1.0
    gaze = read_rows(folder / "gaze.csv")
    assert [values[6] for values, _, _ in samples["gaze"]] == [float(row["valid"]) for row in gaze]
    ratings = read_rows(folder / "ratings.csv")
    assert [value[0] for value, _, _ in samples["ratings"]] == [
        float(row["response"]) for row in ratings
    ]
    assert content["labels"] == ["x", "y", "z", "dx", "dy", "dz", "valid"]


def test_without_pylsl_a_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with (
        pytest.raises(InputError, match=r"pip install pylsl$"),
        open_outlets("s", "P01", lsl=True, ttl=None, simulated=False),
    ):
        pass
