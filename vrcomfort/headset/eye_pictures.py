"""Small pictures of what both eyes see, read back some frames later: no frame waits for the GPU."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.headset.eye_painter import EyePainter

WIDTH_PX = 240
"""Of one eye's picture."""


@dataclass
class _Target:
    """Where a picture is drawn, and read into."""

    painter: EyePainter
    framebuffer: moderngl.Framebuffer
    buffer: moderngl.Buffer


class EyePictures:
    """Takes one picture at a time, both eyes side by side; makes what it needs with the first."""

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
        """Count a drawn frame; return what makes the picture that is there by now, if one is.

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
        """Let go of what was made on the GPU, which goes with it."""
        self._target, self._taken_at = None, None
