"""Images that belong to the runtime: acquire, draw, give back."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import moderngl
import xr

from vrcomfort.errors import InputError
from vrcomfort.headset.openxr.faults import lost
from vrcomfort.headset.openxr.graphics_binding import make_current
from vrcomfort.headset.openxr.native import native, watched

FORMATS = {0x8C43: "SRGB8_ALPHA8"}
"""Our images are sRGB-encoded in 8 bits: this format takes their bytes as they are."""

DEPTH_FORMAT, DEPTH_FORMAT_NAME = 0x8CAC, "DEPTH_COMPONENT32F"
"""The format of the renderer's depth: a copy keeps it as it is."""

_Usage = xr.SwapchainUsageFlags
EYE_USAGE = _Usage.COLOR_ATTACHMENT_BIT | _Usage.SAMPLED_BIT
"""Blitted to, as to a framebuffer."""
PANEL_USAGE = EYE_USAGE | _Usage.TRANSFER_DST_BIT
"""Written to from memory."""
DEPTH_USAGE = _Usage.DEPTH_STENCIL_ATTACHMENT_BIT | _Usage.SAMPLED_BIT | _Usage.TRANSFER_DST_BIT
"""Copied to, image by image."""


def choose_format(offered: Sequence[int]) -> int:
    """Return the first of `FORMATS` that the runtime offers.

    Raises
    ------
    InputError
        If it offers none: any other would change the colours of the stimulus.
    """
    for candidate in FORMATS:
        if candidate in offered:
            return candidate
    raise InputError(
        f"the OpenXR runtime offers no {' or '.join(FORMATS.values())} images (it offers "
        f"{', '.join(hex(each) for each in offered)}); colours would change: use another runtime"
    )


class Swapchain:
    """A ring of textures of one size that belong to the runtime.

    Parameters
    ----------
    ctx
        The context that the session was made with; it is current while an image is lent.
    session
        OpenXR's handle.
    size_px
        (width, height).
    image_format
        OpenGL's number, from `choose_format`, or `DEPTH_FORMAT`.
    usage
        What is done with the images: `EYE_USAGE`, `PANEL_USAGE` or `DEPTH_USAGE`.
    timeout_s
        How long the runtime may keep an image.

    Attributes
    ----------
    names
        OpenGL's names of the textures.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        session: xr.Session,
        size_px: tuple[int, int],
        image_format: int,
        usage: xr.SwapchainUsageFlags,
        timeout_s: float,
    ) -> None:
        self._ctx = ctx
        self.size_px = size_px
        self._wait_info = xr.SwapchainImageWaitInfo(timeout=int(timeout_s * 1e9))
        self._acquire = native("xrAcquireSwapchainImage")
        self._wait = native("xrWaitSwapchainImage", usual=xr.Result.TIMEOUT_EXPIRED)
        self._release = native("xrReleaseSwapchainImage")
        self._index = ctypes.c_uint32()
        self._handle = watched(
            xr.create_swapchain, session, _create_info(size_px, image_format, usage)
        )
        images = watched(xr.enumerate_swapchain_images, self._handle, xr.SwapchainImageOpenGLKHR)
        self.names = [int(image.image) for image in images]
        area = xr.Rect2Di(xr.Offset2Di(0, 0), xr.Extent2Di(*size_px))
        self.sub_image = xr.SwapchainSubImage(self._handle, area)
        """The whole of the image that was given back last."""

    @contextmanager
    def image(self) -> Iterator[int]:
        """Lend the next image, by its place in `names`; afterwards the runtime has it.

        Raises
        ------
        RuntimeLostError
            If the runtime gives none in time.
        """
        self._acquire(self._handle, None, self._index)
        if self._wait(self._handle, self._wait_info) != 0:
            raise lost(f"it gave no image within {self._wait_info.timeout / 1e9:g} s")
        make_current(self._ctx)
        try:
            yield self._index.value
        finally:
            self._release(self._handle, None)

    def release(self) -> None:
        """Give the images back for good."""
        self.names.clear()
        watched(xr.destroy_swapchain, self._handle)


class Canvas:
    """A swapchain to draw colours on.

    Parameters
    ----------
    ctx
        The context that the session was made with.
    swapchain
        Of a format from `choose_format`; it is released with the canvas.
    """

    def __init__(self, ctx: moderngl.Context, swapchain: Swapchain) -> None:
        self._swapchain = swapchain
        self.size_px = swapchain.size_px
        self.sub_image = swapchain.sub_image
        make_current(ctx)
        self._targets = [_framebuffer(ctx, name, self.size_px) for name in swapchain.names]

    @contextmanager
    def image(self) -> Iterator[moderngl.Framebuffer]:
        """Lend the next image to draw on; afterwards the runtime has it."""
        with self._swapchain.image() as index:
            yield self._targets[index]

    def release(self) -> None:
        """Give the images back for good."""
        self._targets.clear()
        self._swapchain.release()


def _create_info(
    size_px: tuple[int, int], image_format: int, usage: xr.SwapchainUsageFlags
) -> xr.SwapchainCreateInfo:
    width, height = size_px
    return xr.SwapchainCreateInfo(
        usage_flags=usage,
        format=image_format,
        sample_count=1,
        width=width,
        height=height,
        face_count=1,
        array_size=1,
        mip_count=1,
    )


def _framebuffer(
    ctx: moderngl.Context, name: int, size_px: tuple[int, int]
) -> moderngl.Framebuffer:
    return ctx.framebuffer([ctx.external_texture(name, size_px, 4, 0, "f1")])
