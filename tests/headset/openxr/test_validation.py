"""The validation layers can complain here, and have nothing to complain about in our calls."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr import (
    Participant,
    fresh_monado,
    needs_monado,
    validation,
)
from vrcomfort.geometry import Pose, Quad
from vrcomfort.gpu import gl
from vrcomfort.headset.monado import RemoteState
from vrcomfort.protocol.viewing import DepthMode

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.support.openxr_best_practices import BestPractices
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

SIZE_PX = (16, 16)
STANDING = RemoteState(Pose([0.0, 1.6, 0.0]))


def complaints(headset: OpenXrHeadset) -> list[str]:
    names = "openxr_warning", "openxr_error"
    return [event.detail for event in headset.take_events() if event.name in names]


def errors(report: Path) -> list[str]:
    lines = report.read_text().splitlines()
    return [line for line in lines if "VALID_DEBUG" not in line]


def test_both_layers_complain_about_bad_calls(ctx: moderngl.Context, tmp_path: Path) -> None:
    report, practices = tmp_path / "validation.txt", BestPractices()
    with fresh_monado(tmp_path) as monado, monado.feed() as feed, validation(report) as layers:
        settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=layers)
        participant = Participant(feed, lambda _: STANDING)
        with OpenXrHeadset(ctx, settings, before_wait=participant) as headset:
            for frame in islice(headset.frames(), 8):
                headset.submit(frame, None)
            before = practices.counts()
            next(headset.frames())
            headset._xr.actions.sync()  # once more, and inside of the frame
            after = practices.counts()
            assert complaints(headset) == []
            with pytest.raises(xr.exception.ValidationFailureError):
                xr.locate_views(headset._xr.session, xr.ViewLocateInfo(type=xr.StructureType(0)))
            told = complaints(headset)
    said = [text for text in after if after[text] > before.get(text, 0)]
    assert any("multiple times in the frame" in text for text in said)
    assert any("between xrBeginFrame and xrEndFrame" in text for text in said)
    assert any("xrLocateViews" in each for each in told)
    assert errors(report) != []


@pytest.mark.parametrize("mode", ["off", "scene", "blur_aware"])
def test_a_session_with_panel_and_depth_is_spotless(
    ctx: moderngl.Context, tmp_path: Path, mode: DepthMode
) -> None:
    report, practices = tmp_path / "validation.txt", BestPractices()
    before = practices.counts()
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
    depth = gl.depth_texture(ctx, SIZE_PX)
    with fresh_monado(tmp_path) as monado, monado.feed() as feed, validation(report) as layers:
        settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=layers, depth=mode)
        participant = Participant(feed, lambda _: STANDING)
        with OpenXrHeadset(ctx, settings, before_wait=participant) as headset:
            panel = headset.show_panel((32, 16), Quad(Pose([0.0, 1.5, -1.5]), (1.0, 0.5)))
            for frame in islice(headset.frames(), 12):
                headset.inputs()
                panel.draw(np.zeros((16, 32, 4), dtype=np.uint8))
                for eye in (0, 1):
                    headset.take_depth(eye, depth, 0.02)
                headset.submit(frame, eyes)
            panel.hide()
            headset.recenter()
            headset.tick(0)
            for frame in islice(headset.frames(), 3):
                headset.submit(frame, eyes)
            assert complaints(headset) == []
    assert errors(report) == []
    assert practices.counts() == before
