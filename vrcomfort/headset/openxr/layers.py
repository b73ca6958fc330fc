"""Composition layers: the two eyes' images with their depth, and panels in the room."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, cast

import moderngl
import numpy as np
import xr
from numpy.typing import NDArray

from vrcomfort.geometry import Pose, Quad
from vrcomfort.headset.inputs import POINTER_SIZE_PX, pointer_picture
from vrcomfort.headset.openxr.faults import running
from vrcomfort.headset.openxr.native import native, pose_to_xr
from vrcomfort.headset.openxr.swapchain import DEPTH_FORMAT, DEPTH_FORMAT_NAME, Canvas, Swapchain

DEPTH_LAYER = xr.KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME
DepthInfo = xr.CompositionLayerDepthInfoKHR

_TEXTURE_2D = 0x0DE1


class DepthImages:
    """The two eyes' depth of a frame, copied bit for bit.

    With it a runtime can shift the images with the head, not only turn them. The renderer's depth
    is ``near_m / distance`` (reverse-Z): 1 on the near plane, 0 at infinity.
    `XR_KHR_composition_layer_depth` calls the distance at depth 0 "near", at depth 1 "far".

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
        """Return the addresses of both eyes' depth structures for the layer, once; or none."""
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


def why_no_depth(extensions: frozenset[str], formats: Sequence[int]) -> str:
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


Eyes = tuple[moderngl.Texture, moderngl.Texture]
Layer = Any
MakeCanvas = Callable[[tuple[int, int]], Canvas]
TakeEyeImage = Callable[[int, moderngl.Framebuffer], None]

MOST_LAYERS = 16
"""Number that every runtime takes."""

_LayerPointer = ctypes.POINTER(xr.CompositionLayerBaseHeader)

PANEL_FLAGS = (
    xr.CompositionLayerFlags.BLEND_TEXTURE_SOURCE_ALPHA_BIT
    | xr.CompositionLayerFlags.UNPREMULTIPLIED_ALPHA_BIT
)


class EyeLayer:
    """The projection layer: copies the renderer's images, byte for byte.

    Parameters
    ----------
    ctx
        The context that the session was made with.
    make_canvas
        Makes a canvas of a size in pixels.
    size_px
        (width, height) of one eye's image.
    mirror
        Called with (0 left or 1 right, the image that the runtime is about to get).
    depth
        Goes with the images where the frame has it; None where the runtime takes none.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        make_canvas: MakeCanvas,
        size_px: tuple[int, int],
        mirror: TakeEyeImage | None,
        depth: DepthImages | None,
    ) -> None:
        self._ctx = ctx
        self._mirror = mirror
        self.depth = depth
        self._canvases = make_canvas(size_px), make_canvas(size_px)
        self._views = (xr.CompositionLayerProjectionView * 2)(
            *(
                xr.CompositionLayerProjectionView(sub_image=each.sub_image)
                for each in self._canvases
            )
        )
        self._layer = xr.CompositionLayerProjection(views=self._views)  # made once: hot
        self._sources: dict[int, tuple[moderngl.Texture, moderngl.Framebuffer]] = {}

    def draw(self, eyes: Eyes) -> None:
        """Hand both images to the runtime.

        Raises
        ------
        ValueError
            If an image has not the size that was asked for.
        """
        for eye, (texture, canvas) in enumerate(zip(eyes, self._canvases, strict=True)):
            if texture.size != canvas.size_px:
                raise ValueError(f"image of {texture.size} pixels, wanted {canvas.size_px}")
            source = self._source(eye, texture)
            with canvas.image() as target:
                self._ctx.copy_framebuffer(target, source)
                if self._mirror is not None:
                    self._mirror(eye, target)

    def structure(self, space: xr.Space, views: Any) -> xr.CompositionLayerProjection:
        """Return the layer, seen from the runtime's own `views`; good until the next call."""
        depths = (None, None) if self.depth is None else self.depth.take()
        for projection, view, depth in zip(self._views, views, depths, strict=True):
            projection.pose, projection.fov, projection.next = view.pose, view.fov, depth
        self._layer.space = space
        return self._layer

    def release(self) -> None:
        """Release the images."""
        self._sources.clear()
        for canvas in self._canvases:
            canvas.release()
        if self.depth is not None:
            self.depth.release()

    def _source(self, eye: int, texture: moderngl.Texture) -> moderngl.Framebuffer:
        """Return a framebuffer to copy from; renderers draw into the same textures each frame."""
        kept = self._sources.get(eye)
        if kept is None or kept[0] is not texture:
            kept = texture, self._ctx.framebuffer([texture])
            self._sources[eye] = kept
        return kept[1]


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
        with self._canvas.image() as target:
            cast(moderngl.Texture, target.color_attachments[0]).write(picture[::-1].tobytes())
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
