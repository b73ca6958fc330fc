"""Passes after the effects: tone map to 8 bits with dither, photodiode patch, hash of the images.

The patch is drawn after tone mapping: full black or full white in every condition.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import ImageHash
from vrcomfort.geometry import Fov
from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.optics import dither, tone
from vrcomfort.protocol.viewing import Photodiode

TONE_CURVE = {"COMPRESSION_START": tone.COMPRESSION_START, "DESATURATION": tone.DESATURATION}
"""Defines of ``include/tone.glsl``."""


def noise_texture(ctx: moderngl.Context) -> moderngl.Texture:
    """Return the thresholds of :func:`dither.blue_noise`."""
    texture = gl.color_texture(ctx, (dither.SIDE, dither.SIDE), components=1, dtype="f4")
    texture.write(dither.blue_noise().astype(np.float32).tobytes())
    return texture


def tone_map_pass(
    ctx: moderngl.Context,
    *,
    radiance: AnyTexture,
    blue_noise: moderngl.Texture,
    size_px: tuple[int, int],
    exposure: float,
) -> FullscreenPass:
    """Return the pass that encodes `radiance` (linear RGBA16F) as RGBA8: sRGB, dithered.

    Parameters
    ----------
    blue_noise
        That of :func:`noise_texture`.
    """
    return FullscreenPass(
        ctx,
        "display/tone_map.frag",
        size_px=size_px,
        inputs={"radiance": radiance, "blue_noise": blue_noise},
        constants={"exposure": exposure},
        defines=TONE_CURVE,
        dtype="f1",
        reach_px={"radiance": 0.0},
    )


Rectangle = tuple[int, int, int, int]
"""Left, bottom, width and height in px; rows count from the bottom, as on the GPU."""


@dataclass
class PatchLight:
    """Whether the patch is white in the frames of one exposure, as they are drawn."""

    settings: Photodiode
    _first_ns: int | None = None
    _drawn: int = field(default=0)

    @property
    def has_begun(self) -> bool:
        """Whether a frame was drawn."""
        return self._first_ns is not None

    def of_next(self, display_ns: int) -> bool:
        """Return whether it is white in the next frame that is drawn."""
        if self._first_ns is None:
            self._first_ns = display_ns
        count, self._drawn = self._drawn, self._drawn + 1
        if self.settings.white == "every_other_frame":
            return count % 2 == 0
        return display_ns - self._first_ns < self.settings.onset_s * 1e9


class PatchPainter:
    """Paints the patch onto the images that displays get.

    Parameters
    ----------
    images
        RGBA8 of each eye that is drawn.
    """

    def __init__(
        self, ctx: moderngl.Context, settings: Photodiode, images: tuple[moderngl.Texture, ...]
    ) -> None:
        self._settings = settings
        self._targets = [ctx.framebuffer([image]) for image in images]

    def paint(self, fovs: tuple[Fov, ...], *, white: bool) -> None:
        """Paint it onto the present images, which have these frusta."""
        light = float(white)
        for target, fov in zip(self._targets, fovs, strict=False):
            place = patch_place(self._settings, fov, target.size)
            target.clear(light, light, light, 1.0, viewport=place)


def patch_place(settings: Photodiode, fov: Fov, size_px: tuple[int, int]) -> Rectangle:
    """Return where the patch is in an image.

    Along each axis it begins `inset_deg` from the edge of the field and is `size_deg` long, both as
    angles from the eye in that axis.
    """
    vertical, _, horizontal = settings.corner.partition("_")
    left, width = _span(settings, fov.left, fov.right, size_px[0], near_low=horizontal == "left")
    bottom, height = _span(settings, fov.down, fov.up, size_px[1], near_low=vertical == "lower")
    return left, bottom, width, height


def _span(
    settings: Photodiode, low: float, high: float, size_px: int, *, near_low: bool
) -> tuple[int, int]:
    """Return where the patch begins along an axis, and how long it is; at least a pixel."""
    inset, length = math.radians(settings.inset_deg), math.radians(settings.size_deg)
    start = low + inset if near_low else high - inset - length
    ends = (min(max(angle, low), high) for angle in (start, start + length))
    width = math.tan(high) - math.tan(low)
    first, last = (round((math.tan(end) - math.tan(low)) / width * size_px) for end in ends)
    first = min(first, size_px - 1)
    return first, max(last - first, 1)


# Hashes tell whether two images are equal, pixel by pixel; they are no protection against forgery.


HASH_EVERY = 30
"""Drawn frames of a session from one hash of its images to the next."""

_SUMS_OF_BOTH_EYES = 4
"""Two of 32 bits for each eye: integer sums are the same in any order of the GPU's threads."""


def image_hash(rgb8: NDArray[np.uint8]) -> str:
    """Return the hash of an image in a file: the twin of ``display/image_hash.comp``.

    Parameters
    ----------
    rgb8
        (height, width, 3) sRGB, the top row first.

    Returns
    -------
    str
        16 hexadecimal digits.
    """
    red, green, blue = (rgb8[..., channel].ravel().astype(np.uint32) for channel in range(3))
    colour = red | green << np.uint32(8) | blue << np.uint32(16)
    place = 2 * np.arange(len(colour), dtype=np.uint32)
    sums = [mixed(colour ^ mixed(place + np.uint32(k))).sum(dtype=np.uint32) for k in (0, 1)]
    return _text(*map(int, sums))


class ImageHasher:
    """Hashes both eyes of some frames; each hash is read `gpu.gl.LATENCY` frames later."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = shaders.compute(ctx, "display/image_hash.comp")
        size_bytes = 4 * _SUMS_OF_BOTH_EYES
        self._free = [gl.dynamic_buffer(ctx, size_bytes) for _ in range(gl.LATENCY + 1)]
        self._pending: deque[tuple[int, int, moderngl.Buffer]] = deque()
        self._frames = 0

    def take(self, frame_index: int, eyes: tuple[moderngl.Texture, moderngl.Texture]) -> None:
        """Begin to hash a frame's images, RGBA8 with their first row at the bottom."""
        buffer = self._free.pop()
        buffer.write(bytes(buffer.size))
        buffer.bind_to_storage_buffer(0)
        for eye, texture in enumerate(eyes):
            texture.use(0)
            self._program["image"] = 0
            self._program["first"] = 2 * eye
            self._program.run(texture.height)
        self._pending.append((self._frames, frame_index, buffer))

    def arrived(self) -> tuple[ImageHash, ...]:
        """Count a drawn frame; return the hashes that are there by now without a wait."""
        self._frames += 1
        due = []
        while self._pending and self._frames - self._pending[0][0] > gl.LATENCY:
            due.append(self._read())
        return tuple(due)

    def drain(self) -> tuple[ImageHash, ...]:
        """Return the hashes that are still on their way (this waits for the GPU)."""
        return tuple(self._read() for _ in range(len(self._pending)))

    def _read(self) -> ImageHash:
        _, frame_index, buffer = self._pending.popleft()
        self._ctx.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)
        sums = np.frombuffer(buffer.read(), dtype=np.uint32).tolist()
        self._free.append(buffer)
        return ImageHash(frame_index, _text(*sums[:2]), _text(*sums[2:]))


def mixed(values: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Return (...,) numbers whose bits are mixed: the twin of ``include/mixed.glsl``."""
    values = values ^ values >> np.uint32(16)
    values = values * np.uint32(0x85EBCA6B)
    values ^= values >> np.uint32(13)
    values *= np.uint32(0xC2B2AE35)
    return values ^ values >> np.uint32(16)


def _text(first: int, second: int) -> str:
    return f"{first:08x}{second:08x}"
