"""What the runtime composes: the two eyes' images, and panels that stand in the room."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, cast

import moderngl
import numpy as np
import xr
from numpy.typing import NDArray

from vrcomfort.geometry import Quad
from vrcomfort.headset.openxr.convert import pose_to_xr
from vrcomfort.headset.openxr.depth import DepthImages
from vrcomfort.headset.openxr.faults import running
from vrcomfort.headset.openxr.native import native
from vrcomfort.headset.openxr.swapchain import Canvas

Eyes = tuple[moderngl.Texture, moderngl.Texture]
Layer = Any
MakeCanvas = Callable[[tuple[int, int]], Canvas]
Mirror = Callable[[int, moderngl.Framebuffer], None]

MOST_LAYERS = 16
"""Every runtime takes so many."""

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
        mirror: Mirror | None,
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
        """Return what is on it."""
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
