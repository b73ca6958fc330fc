"""Waits for the runtime are columns of their own: the times of a frame are without them."""

from __future__ import annotations

import time
from itertools import islice
from types import SimpleNamespace

import pytest

from tests.support.openxr import Participant, needs_monado
from vrcomfort.geometry import Pose
from vrcomfort.headset import watchdog
from vrcomfort.headset.monado import RemoteState
from vrcomfort.protocol import load_protocol
from vrcomfort.render import pipeline
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.load import load_scene

pytest.importorskip("xr", reason="pyopenxr is not installed")

from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings, native

pytestmark = needs_monado

SIZE_PX = (32, 40)
FRAMES = 3
DELAY_S = 1000.0
"""Longer than anything that really takes time here."""
STANDING = RemoteState(Pose([0.0, 1.6, 0.0]))


class SlowRuntime:
    """Lets clocks go on while an image is lent or taken back, as if the call had lasted."""

    def __init__(self, monkeypatch, delay_s):
        self._delay_s, self._passed_s, self._raw = delay_s, 0.0, native._raw
        later = {name: self._later(name) for name in ("perf_counter", "monotonic")}
        for module in (pipeline, watchdog):
            monkeypatch.setattr(module, "time", SimpleNamespace(**{**vars(time), **later}))
        monkeypatch.setattr(native, "_raw", self._slow)

    def _later(self, name):
        now = getattr(time, name)
        return lambda: now() + self._passed_s

    def _slow(self, name):
        function = self._raw(name)
        if not name.endswith("SwapchainImage"):
            return function

        def call(*arguments):
            self._passed_s += self._delay_s
            return function(*arguments)

        return call


def shown(ctx, feed):
    """Return the times of a frame with both effects, in milliseconds, and its waits."""
    settings = OpenXrSettings(image_size_px=SIZE_PX)
    with OpenXrHeadset(ctx, settings, before_wait=Participant(feed, lambda _: STANDING)) as headset:
        renderer = StereoRenderer(
            ctx,
            SIZE_PX,
            on_eye=lambda eye, images: headset.take_depth(eye, images.depth, images.camera.near_m),
        )
        renderer.begin(load_scene("temple"), load_protocol("smoke").condition("both"))
        for frame in islice(headset.frames(), FRAMES):
            rendered = renderer.render(frame, 0.0)
            headset.submit(frame, rendered.eyes)
        renderer.release()
        return rendered.cpu_ms, headset.waits()


def test_waits_for_images_are_told_and_are_no_time_of_the_processor(ctx, feed, monkeypatch):
    _, waits = shown(ctx, feed)
    assert 0 < waits.images_ms < DELAY_S * 1e3
    assert 0 < waits.frame_ms < DELAY_S * 1e3
    with monkeypatch.context() as patch:
        SlowRuntime(patch, DELAY_S)
        cpu_ms, waits = shown(ctx, feed)
    calls = 2 * 3  # colour and depth: acquired, waited for, released
    assert calls * DELAY_S * 1e3 <= waits.images_ms < (calls + 1) * DELAY_S * 1e3
    assert cpu_ms < DELAY_S * 1e3
    assert waits.frame_ms < DELAY_S * 1e3
