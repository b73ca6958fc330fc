"""The depth that the runtime gets: the renderer's, bit for bit, with the right near and far."""

from __future__ import annotations

import ctypes
import math
from itertools import islice
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, fresh_monado, needs_monado
from vrcomfort.geometry import Pose
from vrcomfort.gpu import gl
from vrcomfort.headset.monado import RemoteState
from vrcomfort.protocol import Condition, DepthOfField, Focus
from vrcomfort.protocol.viewing import DepthMode
from vrcomfort.render.condition_passes import EyeImages
from vrcomfort.render.pipeline import StereoRenderer
from vrcomfort.scene.load import load_scene

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.support.openxr_images import ReleasedImages
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings

pytestmark = needs_monado

SIZE_PX = (48, 60)
NEAR_M = 0.02


class Runtime(ReleasedImages):
    """Stands before the runtime and keeps the depth that goes by, and what is said of it."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self.infos: list[tuple[float, float, float, float]] = []
        super().__init__(ctx, xrEndFrame=self._end)

    @property
    def images(self) -> list[np.ndarray]:
        """Return the depth of each eye so far."""
        return [np.frombuffer(each, np.float32) for each in self.depth]

    def _end(self, follow: Any, session: Any, info: Any) -> int:
        for layer in info.contents.layers:
            projection = ctypes.cast(layer, ctypes.POINTER(xr.CompositionLayerProjection)).contents
            for view in projection.views:
                if view.next:
                    depth = xr.CompositionLayerDepthInfoKHR.from_address(view.next)
                    ends = depth.min_depth, depth.max_depth, depth.near_z, depth.far_z
                    self.infos.append(ends)
        return follow(session, info)


FAR = Focus(method="fixed", fixed_m=20.0)
LENS = DepthOfField(law="dioptre", max_radius_percent=10.0)


@pytest.mark.parametrize("mode", ["scene", "blur_aware"])
def test_the_runtime_gets_the_depth_that_was_drawn(
    ctx: moderngl.Context, tmp_path: Path, mode: DepthMode
) -> None:
    runtime = Runtime(ctx)
    drawn: list[np.ndarray] = []
    own: list[np.ndarray] = []
    scene = load_scene("temple")
    layers = (runtime.layer.name,)
    settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=layers, depth=mode)
    standing = RemoteState(Pose([0.0, 1.6, 0.0]))
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        feed.send(standing)
        participant = Participant(feed, lambda _: standing)
        with OpenXrHeadset(ctx, settings, before_wait=participant) as headset:

            def on_eye(eye: int, images: EyeImages) -> None:
                headset.take_depth(eye, images.headset_depth, images.camera.near_m)
                drawn.append(np.frombuffer(gl.read(images.headset_depth), np.float32))
                own.append(np.frombuffer(gl.read(images.depth), np.float32))

            renderer = StereoRenderer(
                ctx, SIZE_PX, near_m=NEAR_M, on_eye=on_eye, headset_depth=mode
            )
            renderer.begin(scene, Condition(name="lens", focus=FAR, depth_of_field=LENS))
            headset.place(spawn=scene.spawn)
            visible = (each for each in headset.frames() if each.should_render)
            for frame in islice(visible, 4):
                headset.submit(frame, renderer.render(frame, 0.0).eyes)
            assert headset.details["depth_layer"] == "DEPTH_COMPONENT32F"
            assert headset.details["depth"] == mode
    renderer.release()
    shown = [image for image in runtime.images if image.any()]
    assert len(shown) == 8
    assert all((a >= b).all() for a, b in zip(drawn, own, strict=True))
    assert any((a > b).any() for a, b in zip(drawn, own, strict=True)) == (mode == "blur_aware")
    assert all(np.array_equal(*pair) for pair in zip(shown, drawn, strict=True))
    assert np.ptp(shown[0]) > 0.001
    assert not np.array_equal(shown[0], shown[1])
    zero, one, at_zero, at_one = runtime.infos[0]
    assert (zero, one, at_zero) == (0.0, 1.0, math.inf)
    assert at_one == pytest.approx(NEAR_M)
    assert len(runtime.infos) == 8


def test_a_frame_without_both_depths_goes_without(ctx: moderngl.Context, tmp_path: Path) -> None:
    runtime = Runtime(ctx)
    settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=(runtime.layer.name,))
    eyes = ctx.texture(SIZE_PX, 4), ctx.texture(SIZE_PX, 4)
    depth = gl.depth_texture(ctx, SIZE_PX)
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        feed.send(RemoteState(Pose([0.0, 1.6, 0.0])))
        with OpenXrHeadset(ctx, settings) as headset:
            for frame in islice(headset.frames(), 6):
                headset.take_depth(0, depth, NEAR_M)
                headset.submit(frame, eyes)
            wrong = gl.depth_texture(ctx, (4, 4))
            frame = next(frame for frame in headset.frames() if frame.should_render)
            with pytest.raises(ValueError, match=r"image of \(4, 4\) pixels"):
                headset.take_depth(0, wrong, NEAR_M)
    assert runtime.infos == []


def test_depth_can_be_switched_off(ctx: moderngl.Context, tmp_path: Path) -> None:
    settings = OpenXrSettings(image_size_px=SIZE_PX, depth="off")
    depth = gl.depth_texture(ctx, SIZE_PX)
    with fresh_monado(tmp_path) as monado, monado.feed() as feed:
        feed.send(RemoteState(Pose([0.0, 1.6, 0.0])))
        with OpenXrHeadset(ctx, settings) as headset:
            next(headset.frames())
            headset.take_depth(0, depth, NEAR_M)
            assert headset.details["depth_layer"] == "switched off"
            assert headset.details["depth"] == "off"
