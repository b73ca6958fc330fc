"""The visibility mask: recorded as the runtime gives it, said by `doctor`, and read back."""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import moderngl
import pytest

from tests.headset.openxr.test_doctor import doctor
from tests.support.openxr_runtime import ScriptedRuntime
from vrcomfort.cli.doctor import _visibility_mask
from vrcomfort.geometry import hidden_areas_of

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr import OpenXrHeadset

LACKING = "without XR_KHR_visibility_mask\n"


def test_the_mask_is_recorded_as_it_is(ctx: moderngl.Context, tmp_path: Path) -> None:
    with ScriptedRuntime(tmp_path), OpenXrHeadset(ctx) as headset:
        given, details = headset.hidden_areas, headset.details
    read = hidden_areas_of(json.loads(json.dumps(details)))
    for area, found in zip(given, read, strict=True):
        assert area is not None
        assert found is not None
        assert (area.vertices == found.vertices).all()
        assert (area.triangles == found.triangles).all()
        # Four corners of a fifth of half the sides: 4 · 0.18² / 2 of 1.8².
        assert area.percent == pytest.approx(2.0, abs=1e-4)


def test_without_a_mask_the_record_says_so(ctx: moderngl.Context, tmp_path: Path) -> None:
    with ScriptedRuntime(tmp_path, LACKING), OpenXrHeadset(ctx) as headset:
        assert headset.hidden_areas == (None, None)
        assert headset.details["visibility_mask"].startswith("none: the runtime lacks XR_KHR_")
        assert hidden_areas_of(headset.details) == (None, None)
        facts: Any = SimpleNamespace(details=headset.details)
    told = "none: the runtime lacks XR_KHR_visibility_mask; all of each image is drawn"
    assert _visibility_mask(facts).found == told


def test_doctor_says_what_is_hidden(tmp_path: Path) -> None:
    code, parts = doctor(**ScriptedRuntime(tmp_path).environment)
    assert code == 0
    told = "hides 2.0 % (left) and 2.0 % (right), which is not drawn"
    assert parts["visibility mask"]["found"] == told


@pytest.mark.parametrize(
    "mask",
    [
        [{"vertices": [[0, 0]], "triangles": [[0, 0, 1]]}, None],
        [{"vertices": [[0, float("nan")]], "triangles": []}, None],
        [{"vertices": [[0, 0]]}, None],
        [None],
    ],
)
def test_a_damaged_mask_is_refused(mask: list[object]) -> None:
    with pytest.raises((ValueError, KeyError)):
        hidden_areas_of({"visibility_mask": mask})


def test_sessions_of_before_have_none() -> None:
    assert hidden_areas_of({"name": "openxr"}) == (None, None)


def test_a_mask_that_changes_is_told(ctx: moderngl.Context, tmp_path: Path) -> None:
    script = "speed 0\n2 mask 1\n"
    with ScriptedRuntime(tmp_path, script), OpenXrHeadset(ctx) as headset:
        for frame in islice(headset.frames(), 6):
            headset.submit(frame, None)
        events = headset.take_events()
    told = [each.detail for each in events if each.name == "visibility_mask_changed"]
    assert told == ["right"]
