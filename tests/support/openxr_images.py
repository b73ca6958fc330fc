"""Images as the runtime gets them, read when they are released to it."""

from __future__ import annotations

import ctypes
from typing import Any

import moderngl
import xr

from tests.support.openxr_layers import Interceptor
from vrcomfort.gpu import gl
from vrcomfort.headset.openxr.swapchain import DEPTH_FORMAT

_RGBA, _DEPTH_COMPONENT, _UNSIGNED_BYTE, _FLOAT = 0x1908, 0x1902, 0x1401, 0x1406
BYTES_PER_PIXEL = 4


class ReleasedImages:
    """Reads both eyes' images of each frame, left then right, rows from the bottom.

    Parameters
    ----------
    calls
        More calls to intercept.
    arrays
        False refuses swapchains with layers, as a runtime without them would.

    Attributes
    ----------
    layer
        For `OpenXrSettings.api_layers`.
    colour, depth
        Bytes of the images that were released so far.
    """

    def __init__(self, ctx: moderngl.Context, *, arrays: bool = True, **calls: Any) -> None:
        uint, size = ctypes.c_uint, ctypes.c_int
        types = (uint, *[size] * 7, uint, uint, size, ctypes.c_void_p)
        self._read = gl.function(ctx, "glGetTextureSubImage", *types)
        self._arrays = arrays
        self._made: dict[int, Any] = {}
        self._names: dict[int, list[int]] = {}
        self._index: dict[int, int] = {}
        self.colour: list[bytes] = []
        self.depth: list[bytes] = []
        self.layer = Interceptor(
            xrCreateSwapchain=self._create,
            xrEnumerateSwapchainImages=self._enumerate,
            xrAcquireSwapchainImage=self._acquire,
            xrReleaseSwapchainImage=self._release,
            **calls,
        )

    def _create(self, follow: Any, session: Any, info: Any, swapchain: Any) -> Any:
        asked = info.contents
        if asked.array_size > 1 and not self._arrays:
            return xr.Result.ERROR_FEATURE_UNSUPPORTED
        result = follow(session, info, swapchain)
        shape = asked.format, asked.width, asked.height, asked.array_size
        self._made[_address(swapchain.contents)] = shape
        return result

    def _enumerate(self, follow: Any, swapchain: Any, size: int, count: Any, images: Any) -> Any:
        result = follow(swapchain, size, count, images)
        if size:
            first = ctypes.cast(images, ctypes.POINTER(xr.SwapchainImageOpenGLKHR))
            self._names[_address(swapchain)] = [first[i].image for i in range(count[0])]
        return result

    def _acquire(self, follow: Any, swapchain: Any, info: Any, index: Any) -> Any:
        result = follow(swapchain, info, index)
        self._index[_address(swapchain)] = index[0]
        return result

    def _release(self, follow: Any, swapchain: Any, info: Any) -> Any:
        key = _address(swapchain)
        image_format, width, height, layers = self._made[key]
        is_depth = image_format == DEPTH_FORMAT
        width //= 3 - layers  # side by side in one layer
        for eye in range(2):
            left, layer = (0, eye) if layers == 2 else (eye * width, 0)
            data = ctypes.create_string_buffer(width * height * BYTES_PER_PIXEL)
            kind = (_DEPTH_COMPONENT, _FLOAT) if is_depth else (_RGBA, _UNSIGNED_BYTE)
            name = self._names[key][self._index[key]]
            self._read(name, 0, left, 0, layer, width, height, 1, *kind, len(data), data)
            (self.depth if is_depth else self.colour).append(data.raw)
        return follow(swapchain, info)


def _address(handle: Any) -> int:
    return ctypes.cast(handle, ctypes.c_void_p).value or 0
