"""Snap turns by a real controller's thumb-stick; no runtime is needed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.headset.inputs import HandInput, Inputs
from vrcomfort.headset.locomotion import Locomotion
from vrcomfort.scene.floors import Floors

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr.tracking import ParticipantPose

NOTHING = Inputs()
TO_THE_RIGHT = Inputs(right=HandInput(thumbstick=(1.0, 0.0)))


def standing(**settings: float) -> ParticipantPose:
    """Return somebody who has just arrived."""
    connection = cast("Any", SimpleNamespace(session=None, stage=None))
    where = ParticipantPose(connection, Locomotion(**settings), lambda _: None, lambda _: None)
    where.tracking.found = True
    where.send(Pose(), Floors())
    assert where.move(NOTHING, 0.01, in_scene=True)
    assert not where.snap_turned
    return where


def test_only_the_frame_of_a_snap_turn_is_told_as_one() -> None:
    where, told = standing(snap_turn_deg=30.0), []
    for inputs in (NOTHING, TO_THE_RIGHT, TO_THE_RIGHT, NOTHING, TO_THE_RIGHT):
        jumps = where.move(inputs, 0.01, in_scene=True)
        assert not jumps, "a snap turn is no cut"
        told.append(where.snap_turned)
    assert told == [False, True, False, False, True]
    expected = axis_angle([0.0, 1.0, 0.0], -np.radians(60))
    np.testing.assert_allclose(where.avatar.orientation, expected, atol=1e-12)


def test_without_a_view_of_the_scene_nobody_turns() -> None:
    where = standing(snap_turn_deg=30.0)
    where.move(NOTHING, 0.01, in_scene=True)
    where.move(TO_THE_RIGHT, 0.01, in_scene=True)
    before = where.avatar
    where.move(TO_THE_RIGHT, 0.01, in_scene=False)
    assert not where.snap_turned
    assert where.avatar == before


def test_smooth_turns_are_never_told_as_snap_turns() -> None:
    where = standing()
    for inputs in (NOTHING, TO_THE_RIGHT, TO_THE_RIGHT):
        where.move(inputs, 0.01, in_scene=True)
        assert not where.snap_turned
