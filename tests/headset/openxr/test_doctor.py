"""`doctor` and the timing rating where there is no runtime."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.support.waiting import WAIT_S
from vrcomfort.frame import Frame
from vrcomfort.headset.playback import PlaybackHeadset
from vrcomfort.headset.timing import TimingTrust, rate_runtime, time_frames
from vrcomfort.traces.pose_track import PoseTrack
from vrcomfort.traces.trace import Trace


def doctor(**environment: str) -> tuple[int, dict[str, dict[str, Any]]]:
    done = subprocess.run(
        [sys.executable, "-c", "from vrcomfort.cli import main; main()", "doctor", "--json"],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )
    assert done.stdout, done.stderr
    return done.returncode, {finding["part"]: finding for finding in json.loads(done.stdout)}


def fake_bindings(folder: Path, error: str) -> str:
    """Return a PYTHONPATH where the bindings cannot be imported."""
    (folder / "xr").mkdir()
    (folder / "xr" / "__init__.py").write_text(f"raise {error}\n")
    return f"{folder}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("error", "words"),
    [
        ("ModuleNotFoundError('no', name='xr')", 'pip install "pyopenxr>='),
        ("ImportError('no')", "cannot be loaded (no)"),
        (
            "OSError('libopenxr_loader.so: cannot open shared object file')",
            "a library of the OpenXR bindings cannot be loaded (libopenxr_loader.so: cannot open",
        ),
    ],
)
def test_missing_bindings_are_said_and_do_not_fail_the_rest(
    tmp_path: Path, error: str, words: str
) -> None:
    code, parts = doctor(PYTHONPATH=fake_bindings(tmp_path, error))
    bindings = parts["OpenXR bindings"]
    assert code == 0
    assert not bindings["ok"]
    assert words in bindings["remedy"]
    assert "playback" in bindings["found"]
    assert "headset" not in parts


@pytest.mark.slow
def test_no_runtime_is_said_and_does_not_fail_the_rest(tmp_path: Path) -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    nowhere = str(tmp_path / "runtime.json")
    code, parts = doctor(XR_RUNTIME_JSON=nowhere, HOME=str(tmp_path), XDG_RUNTIME_DIR=nowhere)
    runtime = parts["OpenXR runtime"]
    assert code == 0
    assert parts["OpenXR bindings"]["ok"]
    assert not runtime["ok"]
    assert "make it the active OpenXR runtime" in runtime["remedy"]


@pytest.mark.parametrize(
    ("runtime", "headset", "trust"),
    [
        ("Monado(XRT) by Collabora et al 25.0.0", "Monado: Remote HMD", TimingTrust.SIMULATED),
        ("Meta XR Simulator 72.0", "Meta Quest 3", TimingTrust.SIMULATED),
        ("SteamVR/OpenXR 2.9.6", "SteamVR/OpenXR : lighthouse", TimingTrust.RUNTIME),
        ("Oculus 1.104.0", "Oculus Quest2", TimingTrust.RUNTIME),
    ],
)
def test_names_of_simulators_lower_the_trust(
    runtime: str, headset: str, trust: TimingTrust
) -> None:
    rated = rate_runtime(runtime, headset)
    assert rated.trust is trust
    assert rated.reason


def playback(
    times_ms: list[float], kind: type[PlaybackHeadset] = PlaybackHeadset
) -> PlaybackHeadset:
    count = len(times_ms)
    still = PoseTrack(np.zeros((count, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)))
    time_ns = (np.array(times_ms) * 1e6).astype(np.int64)
    period_ns = np.full(count, 10_000_000)
    trace = Trace(time_ns=time_ns, head=still, cuts=np.zeros(count, bool), period_ns=period_ns)
    return kind(trace, image_size_px=(4, 4), loop=False)


def test_every_refresh_without_a_frame_is_a_drop(ctx: moderngl.Context) -> None:
    eyes = ctx.texture((4, 4), 4), ctx.texture((4, 4), 4)
    times_ms = [0.0, 10.0, 20.0, 40.0, 50.0, 90.0, 101.0]
    timed = time_frames(playback(times_ms), eyes, seconds=1.0)
    assert timed is not None
    assert timed.frames == 7
    assert timed.dropped == 1 + 3
    assert timed.seconds == pytest.approx(0.101)
    assert timed.period_ms == 10.0
    assert timed.interval_median_ms == pytest.approx(10.5)


def test_the_test_ends_after_its_time(ctx: moderngl.Context) -> None:
    eyes = ctx.texture((4, 4), 4), ctx.texture((4, 4), 4)
    timed = time_frames(playback([10.0 * n for n in range(100)]), eyes, seconds=0.2)
    assert timed is not None
    assert timed.frames == 21


class Asleep(PlaybackHeadset):
    """A headset that nobody wears."""

    def frames(self) -> Iterator[Frame]:
        return (replace(frame, paused=True) for frame in super().frames())


def test_frames_that_nobody_saw_do_not_count(ctx: moderngl.Context) -> None:
    eyes = ctx.texture((4, 4), 4), ctx.texture((4, 4), 4)
    assert time_frames(playback([0.0, 10.0, 20.0], Asleep), eyes, seconds=0.1) is None
