"""Composition layers: the two eyes' images with their depth, and panels in the room."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import moderngl
import numpy as np
import xr
from numpy.typing import NDArray

from vrcomfort.geometry import Pose, Quad
from vrcomfort.headset.inputs import POINTER_SIZE_PX, pointer_picture
from vrcomfort.headset.openxr.faults import running
from vrcomfort.headset.openxr.graphics_binding import make_current
from vrcomfort.headset.openxr.native import native, pose_to_xr
from vrcomfort.headset.openxr.swapchain import (
    DEPTH_FORMAT,
    DEPTH_FORMAT_NAME,
    Canvas,
    StereoSwapchain,
)

DEPTH_LAYER = xr.KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME
DepthInfo = xr.CompositionLayerDepthInfoKHR


def why_no_depth(extensions: frozenset[str], formats: Sequence[int]) -> str:
    """Return why the runtime gets no depth, or an empty string where it does."""
    if DEPTH_LAYER not in extensions:
        return "not offered by the runtime"
    if DEPTH_FORMAT not in formats:
        return f"the runtime offers no {DEPTH_FORMAT_NAME} images"
    return ""


Eyes = tuple[moderngl.Texture, moderngl.Texture]
Layer = Any
MakeCanvas = Callable[[tuple[int, int]], Canvas]

MOST_LAYERS = 16
"""Number that every runtime takes."""

_LayerPointer = ctypes.POINTER(xr.CompositionLayerBaseHeader)

PANEL_FLAGS = (
    xr.CompositionLayerFlags.BLEND_TEXTURE_SOURCE_ALPHA_BIT
    | xr.CompositionLayerFlags.UNPREMULTIPLIED_ALPHA_BIT
)


class EyeLayer:
    """The projection layer: the renderer's images with their depth, copied bit for bit.

    With depth a runtime can shift the images with the head, not only turn them. The renderer's is
    ``near_m / distance`` (reverse-Z): 1 on the near plane, 0 at infinity.
    `XR_KHR_composition_layer_depth` calls the distance at depth 0 "near", at depth 1 "far".

    Parameters
    ----------
    ctx
        The context that the session was made with.
    colour
        Takes the eyes' images; it is released with this.
    depth
        Takes their depth, `DEPTH_FORMAT`; None where the runtime takes none.
    """

    def __init__(
        self, ctx: moderngl.Context, colour: StereoSwapchain, depth: StereoSwapchain | None
    ) -> None:
        self._ctx = ctx
        self._colour, self._depth = colour, depth
        self._depth_infos = [] if depth is None else [*map(_depth_info, depth.sub_images)]
        self._has_depth = [False, False]
        self._views = (xr.CompositionLayerProjectionView * 2)(
            *(xr.CompositionLayerProjectionView(sub_image=each) for each in colour.sub_images)
        )
        self._layer = xr.CompositionLayerProjection(views=self._views)  # made once: hot

    def acquire(self) -> None:
        """Acquire the images of a frame; the runtime may have used the context."""
        self._colour.acquire()
        if self._depth is not None:
            self._depth.acquire()

    def copy_depth(self, eye: int, depth: moderngl.Texture, near_m: float) -> None:
        """Copy the depth of `eye` (0 left, 1 right) for the frame under way.

        Raises
        ------
        ValueError
            If it has not the size of the images.
        """
        if self._depth is None:
            return
        self._be_acquired()
        self._depth.copy(eye, depth)
        self._depth_infos[eye].far_z = near_m
        self._has_depth[eye] = True

    def draw(self, eyes: Eyes, views: Any, space: xr.Space) -> xr.CompositionLayerProjection:
        """Give both images to the runtime, with their depth where that of both was copied.

        Return the layer, seen from the runtime's own `views` in `space`; good until the next call.

        Raises
        ------
        ValueError
            If an image has not the size that was asked for.
        """
        self._be_acquired()
        for eye, image in enumerate(eyes):
            self._colour.copy(eye, image)
        self._colour.release_image()
        infos: Sequence[Any] = (None, None)
        if self._depth is not None and all(self._has_depth):
            self._depth.release_image()
            infos = self._depth_infos
        self._has_depth = [False, False]
        for projection, view, info in zip(self._views, views, infos, strict=True):
            projection.pose, projection.fov = view.pose, view.fov
            projection.next = None if info is None else ctypes.addressof(info)
        self._layer.space = space
        return self._layer

    def release(self) -> None:
        """Release the images."""
        self._colour.release()
        if self._depth is not None:
            self._depth.release()

    def _be_acquired(self) -> None:
        """Acquire the images if the frame began without them, as the first one of a scene does."""
        if not (self._colour.is_acquired and (self._depth is None or self._depth.is_acquired)):
            self.acquire()
            make_current(self._ctx)


def _depth_info(sub_image: xr.SwapchainSubImage) -> Any:
    return DepthInfo(sub_image, min_depth=0.0, max_depth=1.0, near_z=math.inf, far_z=1.0)


class PanelLayer:
    """A picture on a rectangle that stands in the room.

    Parameters
    ----------
    make_canvas
        Makes a canvas of a size in pixels.
    size_px
        (width, height) of the picture.
    quad
        Where it stands in the stage, and how large.
    on_hide
        Called with the panel when it is taken away; its images stay until `release`.
    """

    def __init__(
        self,
        make_canvas: MakeCanvas,
        size_px: tuple[int, int],
        quad: Quad,
        on_hide: Callable[[PanelLayer], None],
    ) -> None:
        self._on_hide = on_hide
        self.size_px = size_px
        self.quad = quad
        self._canvas = make_canvas(size_px)
        self._shown: NDArray[np.uint8] | None = None
        self._layer = xr.CompositionLayerQuad(
            layer_flags=PANEL_FLAGS,
            sub_image=self._canvas.sub_image,
            pose=pose_to_xr(quad.pose),
            size=xr.Extent2Df(*quad.size_m),
        )

    @running()
    def draw(self, picture: NDArray[np.uint8]) -> None:
        """Show `picture`, (height, width, 4) sRGB with straight alpha, top row first.

        The same array again costs nothing.
        """
        if picture is self._shown:
            return
        self._canvas.write(picture)
        self._shown = picture

    def move(self, quad: Quad) -> None:
        """Put the panel elsewhere, from the next frame on."""
        self.quad = quad
        self._layer.pose = pose_to_xr(quad.pose)

    @property
    def picture(self) -> NDArray[np.uint8] | None:
        """Return the panel's present picture."""
        return self._shown

    def structure(self, space: xr.Space) -> xr.CompositionLayerQuad | None:
        """Return the layer, or None before the first picture."""
        if self._shown is None:
            return None
        self._layer.space = space
        return self._layer

    def hide(self) -> None:
        """Take the panel away; shown again, it begins without a picture."""
        self._shown = None
        self._on_hide(self)

    def release(self) -> None:
        """Release its images."""
        self._canvas.release()


class FrameEnd:
    """Gives frames to the runtime.

    Parameters
    ----------
    session
        OpenXR's handle.
    """

    def __init__(self, session: xr.Session) -> None:
        self._session = session
        self._end = native("xrEndFrame")
        self._info = xr.FrameEndInfo(environment_blend_mode=xr.EnvironmentBlendMode.OPAQUE)
        self._layers = (_LayerPointer * MOST_LAYERS)()
        self._info._layers = self._layers

    def __call__(self, display_time_ns: int, layers: list[Layer]) -> None:
        """End the frame under way, with layers from back to front."""
        for index, layer in enumerate(layers):
            self._layers[index] = ctypes.cast(ctypes.byref(layer), _LayerPointer)
        self._info.display_time, self._info.layer_count = display_time_ns, len(layers)
        self._end(self._session, self._info)


class Panels:
    """Panels that stand in the room, and those that wait to be shown again.

    Parameters
    ----------
    make_canvas
        Makes a canvas of a size in pixels.
    """

    def __init__(self, make_canvas: MakeCanvas) -> None:
        self._make_canvas = make_canvas
        self._standing: list[PanelLayer] = []
        self._hidden: list[PanelLayer] = []
        self._pointer: PanelLayer | None = None
        self._points = False

    @running()
    def show(self, size_px: tuple[int, int], quad: Quad) -> PanelLayer:
        """Put a panel into the room: one that was hidden, or a new one."""
        panel = next((each for each in self._hidden if each.size_px == size_px), None)
        if panel is None:
            panel = self._new(size_px, quad)
        else:
            self._hidden.remove(panel)
            panel.move(quad)
        self._standing.append(panel)
        return panel

    @running()
    def prepare(self, size_px: tuple[int, int]) -> None:
        """Make the images of a panel and of the pointer now, so that none are made in a scene."""
        nowhere = Quad(Pose(), (1.0, 1.0))
        self.point(nowhere)
        self.point(None)
        self._hidden.append(self._new(size_px, nowhere))

    @running()
    def point(self, quad: Quad | None) -> None:
        """Put the pointer there, in front of all panels, or take it away."""
        self._points = quad is not None
        if quad is None:
            return
        if self._pointer is None:
            self._pointer = self._new(POINTER_SIZE_PX, quad)
            self._pointer.draw(pointer_picture())
        self._pointer.move(quad)

    @property
    def shown(self) -> list[PanelLayer]:
        """Return the visible panels, from back to front."""
        return [*self._standing, *([self._pointer] if self._pointer and self._points else [])]

    def relocate(self, new_from_old: Pose) -> None:
        """Leave all panels where they are in the world: the stage's origin has moved."""
        for panel in self._standing:
            panel.move(Quad(new_from_old @ panel.quad.pose, panel.quad.size_m))

    def release(self) -> None:
        """Release all images; a runtime that is gone keeps nothing."""
        panels = [*self._standing, *self._hidden]
        panels += [] if self._pointer is None else [self._pointer]
        self._standing.clear()
        self._hidden.clear()
        self._pointer = None
        with suppress(xr.exception.ResultException):
            for panel in panels:
                panel.release()

    def _new(self, size_px: tuple[int, int], quad: Quad) -> PanelLayer:
        return PanelLayer(self._make_canvas, size_px, quad, self._put_aside)

    def _put_aside(self, panel: PanelLayer) -> None:
        self._standing.remove(panel)
        self._hidden.append(panel)
