"""Hashes of the images that a display got, taken on the GPU and read back late.

They tell whether two images are equal, pixel by pixel; they are no protection against forgery.
"""

from __future__ import annotations

from collections import deque

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.frame import ImageHash
from vrcomfort.gpu import gl, shaders

HASH_EVERY = 30
"""Every so many drawn frames of a session have their images hashed."""

_SUMS_OF_BOTH_EYES = 4


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
    sums = [_mixed(colour ^ _mixed(place + np.uint32(k))).sum(dtype=np.uint32) for k in (0, 1)]
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


def _mixed(values: NDArray[np.uint32]) -> NDArray[np.uint32]:
    values = values ^ values >> np.uint32(16)
    values = values * np.uint32(0x85EBCA6B)
    values ^= values >> np.uint32(13)
    values *= np.uint32(0xC2B2AE35)
    return values ^ values >> np.uint32(16)


def _text(first: int, second: int) -> str:
    return f"{first:08x}{second:08x}"
