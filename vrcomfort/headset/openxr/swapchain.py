"""Images that belong to the runtime: acquire, draw, release."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence

import moderngl
import numpy as np
import xr
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.gpu import gl
from vrcomfort.headset.openxr.faults import lost
from vrcomfort.headset.openxr.graphics_binding import make_current
from vrcomfort.headset.openxr.native import native, watched

FORMATS = {0x8C43: "SRGB8_ALPHA8"}
"""Our images are sRGB-encoded in 8 bits: this format takes their bytes as they are."""

DEPTH_FORMAT, DEPTH_FORMAT_NAME = 0x8CAC, "DEPTH_COMPONENT32F"
"""The format of the renderer's depth: a copy keeps it as it is."""

_Usage = xr.SwapchainUsageFlags
COLOUR_USAGE = _Usage.COLOR_ATTACHMENT_BIT | _Usage.SAMPLED_BIT | _Usage.TRANSFER_DST_BIT
DEPTH_USAGE = _Usage.DEPTH_STENCIL_ATTACHMENT_BIT | _Usage.SAMPLED_BIT | _Usage.TRANSFER_DST_BIT
"""Copied to, or written to from memory."""

_TEXTURE_2D, _TEXTURE_2D_ARRAY = 0x0DE1, 0x8C1A


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
    session
        OpenXR's handle.
    size_px
        (width, height).
    image_format
        OpenGL's number, from `choose_format`, or `DEPTH_FORMAT`.
    timeout_s
        How long the runtime may keep an image.
    layers
        Of each image; more than 1 make it an array.

    Attributes
    ----------
    names
        OpenGL's names of the textures.
    index
        Of the acquired image in `names`; None where the runtime has them all.
    """

    def __init__(
        self,
        session: xr.Session,
        size_px: tuple[int, int],
        image_format: int,
        timeout_s: float,
        layers: int = 1,
    ) -> None:
        self.size_px = size_px
        self.index: int | None = None
        self._wait_info = xr.SwapchainImageWaitInfo(timeout=int(timeout_s * 1e9))
        self._acquire = native("xrAcquireSwapchainImage")
        self._wait = native("xrWaitSwapchainImage", usual=xr.Result.TIMEOUT_EXPIRED)
        self._release = native("xrReleaseSwapchainImage")
        self._next = ctypes.c_uint32()
        self._handle = watched(
            xr.create_swapchain, session, _create_info(size_px, image_format, layers)
        )
        images = watched(xr.enumerate_swapchain_images, self._handle, xr.SwapchainImageOpenGLKHR)
        self.names = [int(image.image) for image in images]

    def acquire(self) -> None:
        """Acquire the next image, where none is; the runtime may have used the context.

        Raises
        ------
        RuntimeLostError
            If the runtime gives none in time.
        """
        if self.index is not None:
            return
        self._acquire(self._handle, None, self._next)
        if self._wait(self._handle, self._wait_info) != 0:
            raise lost(f"it gave no image within {self._wait_info.timeout / 1e9:g} s")
        self.index = self._next.value

    def release_image(self) -> None:
        """Give the acquired image to the runtime."""
        self.index = None
        self._release(self._handle, None)

    def sub_image(
        self, size_px: tuple[int, int], left_px: int = 0, layer: int = 0
    ) -> xr.SwapchainSubImage:
        """Return a part of the image that was released last."""
        area = xr.Rect2Di(xr.Offset2Di(left_px, 0), xr.Extent2Di(*size_px))
        return xr.SwapchainSubImage(self._handle, area, layer)

    def release(self) -> None:
        """Give the images back for good."""
        self.names.clear()
        watched(xr.destroy_swapchain, self._handle)


MakeSwapchain = Callable[[tuple[int, int], int], Swapchain]
"""Makes one of a size in pixels and a number of layers."""


class StereoSwapchain:
    """Both eyes' images in one swapchain: two layers, or side by side where it has no layers.

    Parameters
    ----------
    ctx
        The context that the session was made with.
    make_swapchain
        Makes the swapchain.
    size_px
        (width, height) of one eye's image.

    Attributes
    ----------
    layers
        2, or 1 where the images are side by side.
    sub_images
        Each eye's part.
    """

    def __init__(
        self, ctx: moderngl.Context, make_swapchain: MakeSwapchain, size_px: tuple[int, int]
    ) -> None:
        width, height = self.size_px = size_px
        try:
            self._swapchain, self.layers = make_swapchain(size_px, 2), 2
        except (
            xr.exception.FeatureUnsupportedError,
            xr.exception.LimitReachedError,
            xr.exception.ValidationFailureError,
        ):
            self._swapchain, self.layers = make_swapchain((2 * width, height), 1), 1
        corners = [(0, 0), (0, 1)] if self.layers > 1 else [(0, 0), (width, 0)]
        self.sub_images = [self._swapchain.sub_image(size_px, *corner) for corner in corners]
        kind = _TEXTURE_2D_ARRAY if self.layers > 1 else _TEXTURE_2D
        self._places = [(kind, 0, left_px, 0, layer) for left_px, layer in corners]
        self._copy = gl.function(ctx, "glCopyImageSubData", *[ctypes.c_int] * 15)

    @property
    def is_acquired(self) -> bool:
        """Return whether an image may be copied to."""
        return self._swapchain.index is not None

    def acquire(self) -> None:
        """Acquire the next image; see :meth:`Swapchain.acquire`."""
        self._swapchain.acquire()

    def copy(self, eye: int, image: moderngl.Texture) -> None:
        """Copy the image of `eye` (0 left, 1 right), bit for bit, into the acquired one.

        Raises
        ------
        ValueError
            If it has not the size of an eye's image.
        """
        if image.size != self.size_px:
            raise ValueError(f"image of {image.size} pixels, wanted {self.size_px}")
        index = self._swapchain.index
        if index is None:
            raise RuntimeError("no image of the swapchain is acquired")
        source, target = (image.glo, _TEXTURE_2D, 0, 0, 0, 0), self._swapchain.names[index]
        self._copy(*source, target, *self._places[eye], *self.size_px, 1)

    def release_image(self) -> None:
        """Give the acquired image to the runtime."""
        self._swapchain.release_image()

    def release(self) -> None:
        """Give the images back for good."""
        self._swapchain.release()


class Canvas:
    """A swapchain to write pictures to.

    Parameters
    ----------
    ctx
        The context that the session was made with.
    swapchain
        Of a format from `choose_format`; it is released with the canvas.
    """

    def __init__(self, ctx: moderngl.Context, swapchain: Swapchain) -> None:
        self._ctx, self._swapchain = ctx, swapchain
        size_px = swapchain.size_px
        self.sub_image = swapchain.sub_image(size_px)
        make_current(ctx)
        self._textures = [
            ctx.external_texture(name, size_px, 4, 0, "f1") for name in swapchain.names
        ]

    def write(self, picture: NDArray[np.uint8]) -> None:
        """Give a picture to the runtime: (height, width, 4), top row first."""
        self._swapchain.acquire()
        make_current(self._ctx)
        self._textures[self._swapchain.index or 0].write(picture[::-1].tobytes())
        self._swapchain.release_image()

    def release(self) -> None:
        """Give the images back for good."""
        self._textures.clear()
        self._swapchain.release()


def _create_info(
    size_px: tuple[int, int], image_format: int, layers: int
) -> xr.SwapchainCreateInfo:
    width, height = size_px
    return xr.SwapchainCreateInfo(
        usage_flags=DEPTH_USAGE if image_format == DEPTH_FORMAT else COLOUR_USAGE,
        format=image_format,
        sample_count=1,
        width=width,
        height=height,
        face_count=1,
        array_size=layers,
        mip_count=1,
    )
