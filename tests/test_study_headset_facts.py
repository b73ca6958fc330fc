"""What the manifest says of a headset that tells more when it has shown something."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tests.support.session import go, manifest
from tests.support.study import AheadHeadset, Scripted
from vrcomfort.frame import Frame


def test_what_a_headset_tells_late_is_noted_and_what_was_noted_first_stays(tmp_path: Path) -> None:
    class Late(AheadHeadset):
        def frames(self) -> Iterator[Frame]:
            for frame in super().frames():
                self.details = {"ipd_m_of_runtime": 0.0642, "space": "local"}
                yield frame

    headset = Late(details={"space": "stage"})
    go(tmp_path, Scripted(), headset=lambda: headset, sessions=[1])
    noted = manifest(tmp_path)["headset"]
    assert noted["ipd_m_of_runtime"] == 0.0642
    assert noted["space"] == "stage"
