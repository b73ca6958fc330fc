"""Images that the runtime owns: made for what is done with them, and drawn in our own state."""

from __future__ import annotations

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


def headset(
    ctx: moderngl.Context, feed: RemoteFeed, mirror: Any = None, **calls: Any
) -> OpenXrHeadset:
    layer = Interceptor(**calls)
    settings = OpenXrSettings(image_size_px=SIZE_PX, api_layers=(layer.name,))
    participant = Participant(feed, lambda _: STANDING)
    return OpenXrHeadset(ctx, settings, before_wait=participant, mirror=mirror)


def test_images_that_are_written_to_are_made_for_it(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    made: list[tuple[int, tuple[int, int], int]] = []

    def create(follow: Any, session: Any, info: Any, swapchain: Any) -> Any:
        asked = info.contents
        made.append((asked.format, (asked.width, asked.height), int(asked.usage_flags)))
        return follow(session, info, swapchain)

    with headset(ctx, feed, xrCreateSwapchain=create) as session:
        session.show_panel((8, 4), QUAD)
    copied_to = int(Usage.TRANSFER_DST_BIT)
    panels = [usage for _, size_px, usage in made if size_px == (8, 4)]
    depths = [usage for kind, _, usage in made if kind == DEPTH_FORMAT]
    eyes = [usage for kind, size_px, usage in made if kind != DEPTH_FORMAT and size_px == SIZE_PX]
    assert [usage & copied_to for usage in panels + depths] == [copied_to] * 3
    assert [usage & int(Usage.COLOR_ATTACHMENT_BIT) for usage in eyes] == [1, 1]


def test_whatever_state_the_runtime_leaves_the_images_keep_their_bytes(
    ctx: moderngl.Context, feed: RemoteFeed
) -> None:
    other = gl.create_context()
    noise = np.random.default_rng(0).bytes(16 * 16 * 4)
    got: list[bytes] = []

    def leave_a_mess(follow: Any, *arguments: Any) -> Any:
        result = follow(*arguments)
        ctx.enable_direct(FRAMEBUFFER_SRGB)
        other.__enter__()  # type: ignore[no-untyped-call]
        return result

    calls = dict.fromkeys(("xrEndFrame", "xrBeginFrame", "xrWaitSwapchainImage"), leave_a_mess)
    make_current(ctx)
    eye = ctx.texture(SIZE_PX, 4, noise)
    with headset(ctx, feed, lambda _, image: got.append(image.read(components=4)), **calls) as each:
        for frame in islice(each.frames(), 8):
            each.submit(frame, (eye, eye) if frame.should_render else None)
    assert len(got) >= 4
    assert set(got) == {noise}
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
