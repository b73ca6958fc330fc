"""`preflight` and `run` with a headset, through a runtime that follows a script."""

from __future__ import annotations

import gc
import json
import sys
from itertools import repeat
from pathlib import Path
from typing import Any

import moderngl
import pytest

from tests.cli.test_preflight import Run
from tests.support.openxr_runtime import ScriptedRuntime
from tests.support.study import read_rows
from vrcomfort.gpu.adapters import adapters
from vrcomfort.records.preflights import FILE
from vrcomfort.session.rehearsal import Rehearsal

pytest.importorskip("xr", reason="pyopenxr is not installed")

from tests.headset.openxr.test_session import run as run_session
from tests.headset.openxr.test_session import walk

pytestmark = pytest.mark.windows
HEADSET = "size 64 80\nrates 90 72\nprofile left oculus/touch_controller\n"
HEADSET += "profile right oculus/touch_controller\n"
HANDS = "start hand left -0.2 1.2 -0.4 0 0 0 1\nstart hand right 0.2 1.2 -0.4 0 0 0 1\n"
HEAD = "start head 0 1.6 0 0 0 0 1\n"
ONE_EXPOSURE = """
name = "short"
title = "One short exposure"
exposure_s = 0.3
scenes = ["temple"]
conditions = [{ name = "a" }]
order = { rule = "explicit", sequences = [
  { name = "a", sessions = [[{ scene = "temple", condition = "a" }]] }
] }
ratings = { instrument = "fms", every_s = 0.15, timeout_s = 0.1 }
"""


def preflight(run: Run, folder: Path, script: str, *more: str) -> tuple[int, dict[str, Any]]:
    """Return the exit code, and what the file has; findings by their part."""
    protocol = folder / "short.toml"
    protocol.write_text(ONE_EXPOSURE, "utf-8")
    with ScriptedRuntime(folder / "runtime", HEADSET + script):
        code, _, err = run(
            "preflight", protocol, "--out", folder / "S", "--seconds", "0.1", "-q", *more
        )
    assert "Traceback" not in err
    content = json.loads((folder / "S" / FILE).read_text())
    content["findings"] = {each["part"]: each for each in content["findings"]}
    return code, content


def test_a_headset_is_looked_at_whole(run: Run, tmp_path: Path) -> None:
    code, content = preflight(run, tmp_path, HEAD + HANDS)
    found = content["findings"]
    assert content["apparatus"]["refresh rate"] == "90 Hz"
    assert content["apparatus"]["image size of an eye"] == "64×80"
    told = "left: menu; right: A; a look 60° down for 2 s"
    assert (found["stop"]["outcome"], found["stop"]["found"]) == ("ok", told)
    assert found["floor"]["outcome"] == "ok"
    assert "1.60 m" in found["floor"]["found"]
    assert found["tracking"]["outcome"] == "ok"
    assert "64.0 mm shown" in found["IPD"]["found"]
    assert content["timing"]["frames"] > 0
    if sys.platform == "win32":
        assert adapters(), "the registry has one"
        assert all(name in found["GPU"]["found"] for name in adapters())
    refused = {part for part, each in found.items() if each["outcome"] == "refuse"}
    assert refused <= {"rate holds"}  # as fast as this machine is
    assert code == (2 if refused else 0)


@pytest.mark.slow
def test_what_is_wrong_with_a_headset_is_told(run: Run, tmp_path: Path) -> None:
    lies_on_a_table = "start head 0 0.3 0 0 0 0 1\n0-9999 untracked 50\nstart active left 0\n"
    _, content = preflight(run, tmp_path, lies_on_a_table + HANDS, "--seconds", "0.5")
    found = content["findings"]
    assert found["floor"]["outcome"] == "notice"
    assert found["tracking"]["outcome"] == "notice"
    assert found["stop"]["outcome"] == "notice"
    assert "one controller only" in found["stop"]["remedy"]


@pytest.mark.parametrize(
    ("option", "words"),
    [
        (("--refresh-hz", "91"), "does not switch to 91 Hz; it offers 90, 72 Hz"),
        (
            ("--size", "5000x80"),
            "no images of 5000x80 pixels an eye; give a --size up to 4096x4096",
        ),
    ],
)
def test_what_cannot_be_had_is_refused_with_what_can(
    run: Run, tmp_path: Path, option: tuple[str, str], words: str
) -> None:
    code, content = preflight(run, tmp_path, "", *option)
    assert code == 2
    assert words in content["findings"]["headset"]["remedy"]
    study = tmp_path / "other"
    with ScriptedRuntime(tmp_path / "runtime", HEADSET):
        session = ("run", "smoke", "--participant", "P01", "--out", study, "--headset", "openxr")
        code, _, err = run(*session, *option)
    assert code == 2
    assert words in " ".join(err.split())
    assert not study.exists()


@pytest.mark.slow
def test_a_runtime_that_goes_away_is_a_finding(run: Run, tmp_path: Path) -> None:
    # However slow its first frame is, the look ends with the loss and not with its time.
    code, content = preflight(run, tmp_path, HEAD + "1 state loss_pending\n", "--seconds", "60")
    assert code == content["outcome"].count("refuse") * 2 == 2
    assert "announced the loss" in content["findings"]["headset"]["remedy"]


def expose(ctx: moderngl.Context, folder: Path, measured_m: float) -> None:
    """Show one exposure to somebody whose eyes were measured."""
    script = "ipd_m 0.0625\nperiod_ns 20000000\n"
    with ScriptedRuntime(folder, script) as runtime, runtime.feed() as feed:
        rehearsal = Rehearsal(feed, walk(), repeat(0))
        run_session(ctx, rehearsal, folder, text=ONE_EXPOSURE, ipd_measured_m=measured_m)


@pytest.mark.parametrize(
    ("measured_m", "told"),
    [(0.0609, "62.5 mm shown, 60.9 mm measured"), (0.0645, "62.5 mm shown, 64.5 mm"), (0.0611, "")],
)
def test_eyes_that_are_shown_closer_or_wider_than_they_are_are_told(
    ctx: moderngl.Context, tmp_path: Path, measured_m: float, told: str
) -> None:
    expose(ctx, tmp_path, measured_m)
    gc.collect()  # the rehearsal and its headset held each other
    session = tmp_path / "study" / "sub-P01" / "ses-1"
    assert json.loads((session / "manifest.json").read_text())["ipd_measured_m"] == measured_m
    events = [each for each in read_rows(session / "events.csv") if each["name"] == "ipd_differs"]
    assert len(events) == bool(told)
    assert all(told in each["detail"] for each in events)
