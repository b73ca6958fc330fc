"""Images that the runtime owns: made for what is done with them, and drawn in our own state."""

from __future__ import annotations

import ctypes
from collections import Counter
from itertools import islice
from typing import Any

import moderngl
import numpy as np
import pytest

from tests.support.openxr import Participant, needs_monado
from vrcomfort.geometry import Pose, Quad
from vrcomfort.gpu import gl
from vrcomfort.headset.monado import RemoteFeed, RemoteState

pytest.importorskip("xr", reason="pyopenxr is not installed")

import xr

from tests.support.openxr_images import ReleasedImages
from tests.support.openxr_layers import Interceptor
from vrcomfort.headset.openxr import OpenXrHeadset, OpenXrSettings
from vrcomfort.headset.openxr.graphics_binding import make_current
from vrcomfort.headset.openxr.swapchain import DEPTH_FORMAT

pytestmark = needs_monado

SIZE_PX = (16, 16)
STANDING = RemoteState(Pose([0.0, 1.6, 0.0]))
QUAD = Quad(Pose([0.0, 1.5, -1.5]), (1.0, 1.0))
FRAMEBUFFER_SRGB = 0x8DB9
Usage = xr.SwapchainUsageFlags


def address(handle: Any) -> int:
    return ctypes.cast(handle, ctypes.c_void_p).value or 0


def headset(
    ctx: moderngl.Context, feed: RemoteFeed, layer: Interceptor | None = None, **calls: Any
) -> OpenXrHeadset:
    layer = layer or Interceptor(**calls)
    settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=(layer.name,))
    return OpenXrHeadset(ctx, settings, before_wait=Participant(feed, lambda _: STANDING))


def test_images_that_are_written_to_are_made_for_it(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    made: list[tuple[int, tuple[int, int], int, int]] = []

    def create(follow: Any, session: Any, info: Any, swapchain: Any) -> Any:
        asked = info.contents
        size_px = asked.width, asked.height
        made.append((asked.format, size_px, asked.array_size, int(asked.usage_flags)))
        return follow(session, info, swapchain)

    with headset(ctx, feed, xrCreateSwapchain=create) as session:
        session.show_panel((8, 4), QUAD)
        assert session.details["eye_images"] == "two layers"
    copied_to = int(Usage.TRANSFER_DST_BIT)
    assert [usage & copied_to for *_, usage in made] == [copied_to] * 3
    assert [shape for _, *shape, _ in made] == [[SIZE_PX, 2], [SIZE_PX, 2], [(8, 4), 1]]
    assert [kind == DEPTH_FORMAT for kind, *_ in made] == [False, True, False]


@pytest.mark.parametrize(("arrays", "said"), [(True, "two layers"), (False, "side by side")])
def test_both_eyes_are_parts_of_one_image(
    ctx: moderngl.Context, feed: RemoteFeed, arrays: bool, said: str
) -> None:
    parts: list[list[tuple[int, int, int]]] = []

    def end(follow: Any, session: Any, info: Any) -> Any:
        for layer in info.contents.layers:
            projection = ctypes.cast(layer, ctypes.POINTER(xr.CompositionLayerProjection)).contents
            depths = [
                xr.CompositionLayerDepthInfoKHR.from_address(v.next) for v in projection.views
            ]
            for each in (
                [view.sub_image for view in projection.views],
                [d.sub_image for d in depths],
            ):
                assert len({address(part.swapchain) for part in each}) == 1
                parts.append([(p.image_rect.offset.x, p.image_array_index) for p in each])
        return follow(session, info)

    released = ReleasedImages(ctx, arrays=arrays, xrEndFrame=end)
    random = np.random.default_rng(1)
    colours = [random.bytes(16 * 16 * 4) for _ in range(2)]
    depths = [gl.depth_texture(ctx, SIZE_PX) for _ in range(2)]
    eyes = ctx.texture(SIZE_PX, 4, colours[0]), ctx.texture(SIZE_PX, 4, colours[1])
    for depth, value in zip(depths, (0.25, 0.75), strict=True):
        ctx.framebuffer([], depth).clear(depth=value)
    with headset(ctx, feed, released.layer) as session:
        assert session.details["eye_images"] == said
        for frame in islice((each for each in session.frames() if each.should_render), 3):
            for eye, depth in enumerate(depths):
                session.take_depth(eye, depth, 0.05)
            session.submit(frame, eyes)
    assert released.colour == colours * 3
    assert [set(np.frombuffer(each, np.float32)) for each in released.depth] == [{0.25}, {0.75}] * 3
    assert parts == [[(0, 0), (0, 1) if arrays else (16, 0)]] * 6


def test_a_frame_acquires_two_images_and_takes_the_context_twice(
    ctx: moderngl.Context, feed: RemoteFeed, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: Counter[str] = Counter()
    each_frame: list[Counter[str]] = []

    def counted(name: str) -> Any:
        def call(follow: Any, *arguments: Any) -> Any:
            calls[name] += 1
            return follow(*arguments)

        return call

    def count_current(self: moderngl.Context) -> Any:
        calls["make_current"] += 1
        return enter(self)

    enter = moderngl.Context.__enter__
    monkeypatch.setattr(moderngl.Context, "__enter__", count_current)
    depth, eye = gl.depth_texture(ctx, SIZE_PX), ctx.texture(SIZE_PX, 4)
    names = [f"xr{verb}SwapchainImage" for verb in ("Acquire", "Wait", "Release")]
    with headset(ctx, feed, **{name: counted(name) for name in names}) as session:
        for frame in islice((each for each in session.frames() if each.should_render), 3):
            for number in (0, 1):
                session.take_depth(number, depth, 0.05)
            session.submit(frame, (eye, eye))
            each_frame.append(calls.copy())
            calls.clear()
    assert each_frame[-1] == {**dict.fromkeys(names, 2), "make_current": 2}


def test_whatever_state_the_runtime_leaves_the_images_keep_their_bytes(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    other = gl.create_context()
    noise = np.random.default_rng(0).bytes(16 * 16 * 4)

    def leave_a_mess(follow: Any, *arguments: Any) -> Any:
        result = follow(*arguments)
        ctx.enable_direct(FRAMEBUFFER_SRGB)
        other.__enter__()  # type: ignore[no-untyped-call]
        return result

    calls = dict.fromkeys(("xrEndFrame", "xrBeginFrame", "xrWaitSwapchainImage"), leave_a_mess)
    make_current(ctx)
    eye = ctx.texture(SIZE_PX, 4, noise)
    released = ReleasedImages(ctx, **calls)
    with headset(ctx, feed, released.layer) as each:
        for frame in islice(each.frames(), 8):
            each.submit(frame, (eye, eye) if frame.should_render else None)
    assert len(released.colour) >= 4
    assert set(released.colour) == {noise}
    other.release()
    make_current(ctx)


def test_a_panel_that_was_prepared_or_hidden_is_shown_without_new_images(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    made: list[tuple[int, int]] = []

    def create(follow: Any, session: Any, info: Any, swapchain: Any) -> Any:
        made.append((info.contents.width, info.contents.height))
        return follow(session, info, swapchain)

    picture = np.full((4, 8, 4), 255, np.uint8)
    with headset(ctx, feed, xrCreateSwapchain=create) as session:
        session.prepare_panel((8, 4))
        before = len(made)
        for _ in range(3):
            panel = session.show_panel((8, 4), QUAD)
            assert panel.picture is None
            panel.draw(picture)
            for frame in islice(session.frames(), 2):
                session.submit(frame, None)
            panel.hide()
        assert len(made) == before
        session.show_panel((8, 4), QUAD)
        session.show_panel((8, 4), QUAD)
        assert made[before:] == [(8, 4)]
