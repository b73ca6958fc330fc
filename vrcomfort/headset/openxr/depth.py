"""Depth beside the images, so that a runtime can shift them with the head, not only turn them.

The renderer's depth is ``near_m / distance`` (reverse-Z): 1 on the near plane, 0 at infinity.
`XR_KHR_composition_layer_depth` calls the distance at depth 0 "near" and that at depth 1 "far".
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence

import moderngl
import xr

from vrcomfort.headset.openxr.swapchain import DEPTH_FORMAT, DEPTH_FORMAT_NAME, Swapchain

DEPTH_LAYER = xr.KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME
DepthInfo = xr.CompositionLayerDepthInfoKHR

_TEXTURE_2D = 0x0DE1


class DepthImages:
    """The two eyes' depth of a frame, copied bit for bit.

    Parameters
    ----------
    ctx
        The context that the session was made with.
    swapchains
        Left and right, of `DEPTH_FORMAT`; they are released with this.
    """

    def __init__(self, ctx: moderngl.Context, swapchains: tuple[Swapchain, Swapchain]) -> None:
        self._swapchains = swapchains
        self._copy = _copier(ctx)
        self._infos = tuple(
            DepthInfo(each.sub_image, min_depth=0.0, max_depth=1.0, near_z=math.inf, far_z=1.0)
            for each in swapchains
        )
        self._drawn = [False, False]

    def draw(self, eye: int, depth: moderngl.Texture, near_m: float) -> None:
        """Hand the depth of `eye` (0 left, 1 right) to the runtime, for the frame under way.

        Raises
        ------
        ValueError
            If it has not the size of the images.
        """
        swapchain = self._swapchains[eye]
        if depth.size != swapchain.size_px:
            raise ValueError(f"depth of {depth.size} pixels, wanted {swapchain.size_px}")
        with swapchain.image() as index:
            self._copy(depth.glo, swapchain.names[index], depth.size)
        self._infos[eye].far_z = near_m
        self._drawn[eye] = True

    def take(self) -> tuple[int | None, int | None]:
        """Return the addresses of what goes into the layer, once: both eyes' depth, or none."""
        whole = all(self._drawn)
        self._drawn = [False, False]
        if not whole:
            return None, None
        left, right = self._infos
        return ctypes.addressof(left), ctypes.addressof(right)

    def release(self) -> None:
        """Release the images."""
        for swapchain in self._swapchains:
            swapchain.release()


def why_not(extensions: frozenset[str], formats: Sequence[int]) -> str:
    """Return why the runtime gets no depth, or an empty string where it does."""
    if DEPTH_LAYER not in extensions:
        return "not offered by the runtime"
    if DEPTH_FORMAT not in formats:
        return f"the runtime offers no {DEPTH_FORMAT_NAME} images"
    return ""


def _copier(ctx: moderngl.Context) -> Callable[[int, int, tuple[int, int]], None]:
    """Return a function that copies a texture (source and target name, size) over another."""
    kind = getattr(ctypes, "WINFUNCTYPE", ctypes.CFUNCTYPE)
    loader = ctx.mglo._context
    # A context of our own and one that a window made look functions up by different names.
    find = getattr(loader, "load", None) or loader.load_opengl_function
    call = kind(None, *[ctypes.c_int] * 15)(find("glCopyImageSubData"))
    corner = (_TEXTURE_2D, 0, 0, 0, 0)

    def copy(source: int, target: int, size_px: tuple[int, int]) -> None:
        call(source, *corner, target, *corner, *size_px, 1)

    return copy
