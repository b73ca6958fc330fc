"""Draws eyes' images and panels into a window, and small copies for the console."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Quad, View, clip_from_view
from vrcomfort.gpu import gl
from vrcomfort.resources import data_folder

Box: TypeAlias = tuple[int, int, int, int]
"""(left, bottom, width, height) in pixels of the window, from its lower left corner."""

NEAR_M = 0.02
ANISOTROPY = 4.0
FULL = np.diag([2.0, 2.0, 1.0, 1.0])
"""clip-from-picture of a picture that fills its box."""


class WindowPanel:
    """A picture on a rectangle that stands in the room.

    Parameters
    ----------
    size_px
        (width, height) of the picture.
    quad
        Where it stands in the stage, and how large.
    on_hide
        Called with the panel when it is taken away.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        size_px: tuple[int, int],
        quad: Quad,
        on_hide: Callable[[WindowPanel], None] = lambda _: None,
    ) -> None:
        self.quad = quad
        self._on_hide = on_hide
        self._shown: NDArray[np.uint8] | None = None
        self.texture = ctx.texture(size_px, 4)
        self.texture.repeat_x = self.texture.repeat_y = False
        self.texture.anisotropy = ANISOTROPY

    def draw(self, picture: NDArray[np.uint8]) -> None:
        """Show `picture`, (height, width, 4) sRGB with straight alpha, top row first.

        The same array again costs nothing.
        """
        if picture is not self._shown:
            self.texture.write(picture[::-1].tobytes())
            self.texture.build_mipmaps()
            self._shown = picture

    def hide(self) -> None:
        """Take the panel away."""
        self._on_hide(self)


class EyePainter:
    """Draws an eye's image and the panels that stand before it into a box of a framebuffer."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        folder = data_folder("shaders")
        vertex, fragment = (
            (folder / name).read_text(encoding="utf-8")
            for name in ("display/picture.vert", "display/picture.frag")
        )
        self._program = ctx.program(vertex, fragment)
        self._rectangle = ctx.vertex_array(self._program, [])
        self._smooth = ctx.sampler(repeat_x=False, repeat_y=False)
        self._smooth.filter = moderngl.LINEAR, moderngl.LINEAR

    def paint(
        self,
        target: moderngl.Framebuffer,
        box: Box,
        image: moderngl.Texture | None,
        view: View,
        panels: Sequence[WindowPanel],
    ) -> None:
        """Draw one eye.

        Parameters
        ----------
        image
            What the renderer drew (RGBA8, sRGB-encoded), or None for nothing behind the panels.
        view
            stage-from-eye.
        """
        if image is not None:
            self.paint_image(target, box, image)
        with self._ctx.scope(target, moderngl.BLEND):
            self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
            target.viewport = box
            clip_from_stage = clip_from_view(view.fov, NEAR_M) @ view.pose.inverse().matrix()
            for panel in panels:
                sized = np.diag([*panel.quad.size_m, 1.0, 1.0])
                self._draw(panel.texture, clip_from_stage @ panel.quad.pose.matrix() @ sized)

    def paint_image(self, target: moderngl.Framebuffer, box: Box, image: moderngl.Texture) -> None:
        """Fill the box with an eye's image."""
        with self._ctx.scope(target, moderngl.NOTHING):
            target.viewport = box
            self._smooth.use(0)
            self._draw(image, FULL)
            self._smooth.clear(0)

    def _draw(self, texture: moderngl.Texture, clip_from_picture: Array) -> None:
        texture.use(0)
        self._program["clip_from_picture"] = tuple(clip_from_picture.T.ravel())
        self._rectangle.render(moderngl.TRIANGLE_STRIP, vertices=4)


def fitted(size_px: tuple[int, int], aspect: float, *, column: int = 0, of: int = 1) -> Box:
    """Return the largest box of an aspect (width / height), centred in a column of a window."""
    width, height = size_px[0] // of, size_px[1]
    wide, high = min(width, round(height * aspect)), min(height, round(width / aspect))
    left = column * width + (width - wide) // 2
    return left, (height - high) // 2, wide, high


WIDTH_PX = 240
"""Of one eye's picture."""


@dataclass
class _Target:
    """Where a picture is drawn, and read into."""

    painter: EyePainter
    framebuffer: moderngl.Framebuffer
    buffer: moderngl.Buffer


class EyePictures:
    """Takes one picture at a time, both eyes side by side; allocates with the first."""

    def __init__(self, width_px: int = WIDTH_PX) -> None:
        self._width_px = width_px
        self._target: _Target | None = None
        self._frames = 0
        self._taken_at: int | None = None

    def take(self, eyes: tuple[moderngl.Texture, moderngl.Texture]) -> None:
        """Begin to copy both images (RGBA8), unless one is on its way."""
        if self._taken_at is not None:
            return
        target = self._target = self._target or self._made(eyes[0])
        width, height = target.framebuffer.size
        for eye, image in enumerate(eyes):
            box = (eye * width // 2, 0, width // 2, height)
            target.painter.paint_image(target.framebuffer, box, image)
        target.framebuffer.read_into(target.buffer, components=3, alignment=1)
        self._taken_at = self._frames

    def arrived(self) -> Callable[[], bytes] | None:
        """Count a drawn frame; return a function that encodes the picture, once one has arrived.

        It gives width and height in pixels (two bytes each, little-endian), then RGB, bottom up.
        """
        self._frames += 1
        if self._taken_at is None or self._frames - self._taken_at <= gl.LATENCY:
            return None
        assert self._target is not None  # noqa: S101 - tells mypy that `take` has made it
        self._taken_at = None
        pixels = self._target.buffer.read()
        size = b"".join(side.to_bytes(2, "little") for side in self._target.framebuffer.size)
        return lambda: size + pixels

    def _made(self, image: moderngl.Texture) -> _Target:
        ctx = image.ctx
        width = min(self._width_px, image.width)
        size_px = 2 * width, max(round(width * image.height / image.width), 1)
        framebuffer = ctx.framebuffer([gl.color_texture(ctx, size_px, dtype="f1")])
        buffer = gl.dynamic_buffer(ctx, 3 * size_px[0] * size_px[1])
        return _Target(EyePainter(ctx), framebuffer, buffer)

    def release(self) -> None:
        """Drop the GPU objects."""
        self._target, self._taken_at = None, None
