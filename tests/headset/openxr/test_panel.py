"""Questions answered with controllers, through the runtime, on a panel in the room."""

from __future__ import annotations

from itertools import repeat
from pathlib import Path

import moderngl
import numpy as np
import pytest

from tests.support.openxr import fresh_monado, needs_monado
from vrcomfort.geometry import Pose, axis_angle
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.respondent.base import Form
from vrcomfort.respondent.panel import PanelRespondent
from vrcomfort.session.panel_screen import PanelScreen
from vrcomfort.session.rehearsal import Rehearsal

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado


def test_the_ssq_is_answered_by_controller_clicks(ctx: moderngl.Context, tmp_path: Path) -> None:
    ssq = shipped_instruments()["ssq"]
    script = np.random.default_rng(3).integers(0, 4, len(ssq.items)).tolist()
    head = Pose(np.array([0.3, 1.6, -0.2]), axis_angle([0.0, 1.0, 0.0], 0.6))
    heard = []
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        rehearsal = Rehearsal(feed, repeat(head), iter(script))
        settings = OpenXrSettings(image_size_px=(16, 16))
        with OpenXrHeadset(ctx, settings, before_wait=rehearsal.before_frame) as headset:
            rehearsal.screen = PanelScreen(headset)
            person = PanelRespondent(rehearsal.screen, watch=rehearsal.watch, chose=rehearsal.chose)
            person.ask(Form(ssq, "baseline"), lambda item, value, _: heard.append((item, value)))
    assert heard == [(item.name, value) for item, value in zip(ssq.items, script, strict=True)]
