"""What the manifest says of a headset that tells more when it has shown something."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.support.session import go, manifest
from tests.support.study import AheadHeadset, Scripted, read_rows
from vrcomfort.cli import main
from vrcomfort.frame import Frame


def test_what_a_headset_tells_late_is_noted_and_what_was_noted_first_stays(tmp_path: Path) -> None:
    class Late(AheadHeadset):
        def frames(self) -> Iterator[Frame]:
            for frame in super().frames():
                self.details = {"ipd_m": 0.0642, "space": "local"}
                self.refresh_hz = 90.0
                yield frame

    headset = Late(details={"space": "stage"})
    headset.refresh_hz = 0.0  # before the first frame, a runtime need not tell
    go(tmp_path, Scripted(), headset=lambda: headset, sessions=[1])
    noted = manifest(tmp_path)["headset"]
    assert noted["ipd_m"] == 0.0642
    assert noted["refresh_hz"] == 90.0
    assert noted["space"] == "stage"


@pytest.mark.slow
def test_the_eyes_distance_is_what_is_shown_and_what_was_measured_stands_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("run", "smoke", "--participant", "P01", "--out", tmp_path / "S", "--ipd-mm", 61.5)
    small = ("--respondent", "simulated", "--size", "16x16", "--quiet")
    monkeypatch.setattr("sys.argv", ["vrcomfort", *map(str, words), *small])
    with pytest.raises(SystemExit) as ended:
        main()
    assert not ended.value.code
    noted = json.loads((tmp_path / "S/sub-P01/ses-1/manifest.json").read_text())
    assert noted["ipd_measured_m"] == 0.0615
    frame = read_rows(tmp_path / "S/sub-P01/ses-1/frames.csv")[0]
    left, right = (
        np.array([float(frame[f"{eye}_{axis}_m"]) for axis in "xyz"]) for eye in ("left", "right")
    )
    assert noted["headset"]["ipd_m"] == pytest.approx(np.linalg.norm(right - left))
