"""`preflight` and `run` with a headset, through a runtime that follows a script."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.openxr_runtime import ScriptedRuntime
from tests.test_preflight import Run
from vrcomfort.records.preflights import FILE

pytest.importorskip("xr", reason="pyopenxr is not installed")

HEADSET = "size 64 80\nrates 90 72\nprofile left oculus/touch_controller\n"
HEADSET += "profile right oculus/touch_controller\n"
HANDS = "start hand left -0.2 1.2 -0.4 0 0 0 1\nstart hand right 0.2 1.2 -0.4 0 0 0 1\n"
HEAD = "start head 0 1.6 0 0 0 0 1\n"


def preflight(run: Run, folder: Path, script: str, *more: str) -> tuple[int, dict[str, Any]]:
    """Return the exit code, and what the file has; findings by their part."""
    with ScriptedRuntime(folder / "runtime", HEADSET + script):
        code, _, err = run(
            "preflight", "smoke", "--out", folder / "S", "--seconds", "0.5", "-q", *more
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
    refused = {part for part, each in found.items() if each["outcome"] == "refuse"}
    assert refused <= {"rate holds"}  # as fast as this machine is
    assert code == (2 if refused else 0)


def test_what_is_wrong_with_a_headset_is_told(run: Run, tmp_path: Path) -> None:
    lies_on_a_table = "start head 0 0.3 0 0 0 0 1\n0-9999 untracked 50\nstart active left 0\n"
    _, content = preflight(run, tmp_path, lies_on_a_table + HANDS)
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


def test_a_runtime_that_goes_away_is_a_finding(run: Run, tmp_path: Path) -> None:
    code, content = preflight(run, tmp_path, HEAD + "1 state loss_pending\n")
    assert code == content["outcome"].count("refuse") * 2 == 2
    assert "announced the loss" in content["findings"]["headset"]["remedy"]
