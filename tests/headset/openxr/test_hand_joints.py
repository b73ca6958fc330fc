"""The joints of hands are recorded where a runtime tracks them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr_runtime import ScriptedRuntime
from tests.support.resume import folder, go, rows
from tests.support.study import AheadHeadset
from vrcomfort.exchange.verifying import verify_study
from vrcomfort.frame import HAND_JOINTS, Frame, HandJoints
from vrcomfort.records import HandJointsRow, Session

PALM, TIP = HAND_JOINTS.index("palm"), HAND_JOINTS.index("index_tip")


def test_joints_come_from_the_runtime(ctx: moderngl.Context, tmp_path: Path) -> None:
    pytest.importorskip("xr", reason="pyopenxr is not installed")
    from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

    script = "start hand right 0.3 1.2 -0.4 0 0 0 1\nstart active left 0\nspeed 0\n"
    with (
        ScriptedRuntime(tmp_path, script),
        OpenXrHeadset(ctx, OpenXrSettings(image_size_px=(16, 16))) as made,
    ):
        frames = []
        for frame in islice(made.frames(), 8):
            made.submit(frame, None)
            frames.append(frame)
        assert made.details["hand_joints"] == "yes"
    left, right = frames[-1].joints
    assert left is None
    assert right is not None
    assert right.tracked
    assert right.positions_m[PALM] == pytest.approx([0.3, 1.2, -0.4], abs=1e-6)
    assert right.positions_m[TIP] == pytest.approx([0.28, 1.2, -0.49], abs=1e-6)
    assert np.isfinite(right.positions_m).all()
    first = frames[4].joints[1]
    assert first is not None
    assert first.positions_m is not right.positions_m  # each frame has its own


class SeesHands(AheadHeadset):
    """A headset that sees the right hand, all but the tip of its little finger, at times both."""

    def frames(self) -> Iterator[Frame]:
        for frame in super().frames():
            positions = np.full((26, 3), 0.1234567, np.float32)
            positions[-1] = np.nan
            right = HandJoints(positions, tracked=False)
            yield replace(frame, joints=(right if frame.index % 2 else None, right))


def test_each_frame_has_a_row_for_each_hand_that_is_seen(tmp_path: Path) -> None:
    go(tmp_path, headset_for=lambda *_: SeesHands())
    recorded = list(Session(folder(tmp_path)).rows(HandJointsRow))
    frames = [row for row in rows(tmp_path, "frames") if row["paused"] != "1"]
    times = [int(row["xr_time_ns"]) for row in frames]
    assert [row["xr_time_ns"] for row in recorded if row["hand"] == "right"] == times
    left = [row["xr_time_ns"] for row in recorded if row["hand"] == "left"]
    assert 0 < len(left) < len(times)
    assert set(left) < set(times)
    assert {row["tracked"] for row in recorded} == {0}
    assert {row["palm_x_m"] for row in recorded} == {0.12346}
    assert {row["little_tip_z_m"] for row in recorded} == {None}
    assert verify_study(tmp_path / "S").faults == []


def test_a_session_without_tracked_hands_has_no_such_file(tmp_path: Path) -> None:
    go(tmp_path)
    assert not (folder(tmp_path) / HandJointsRow.FILE).exists()
