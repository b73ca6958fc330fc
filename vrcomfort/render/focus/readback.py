"""Brings the focus of each frame to the CPU some frames late, so that nobody waits for it."""

from __future__ import annotations

from collections import deque

import moderngl
import numpy as np

from vrcomfort.frame import FocusSample
from vrcomfort.geometry import Array
from vrcomfort.gpu import gl
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.optics.focus import RAYS

_NO_RAYS = np.full(RAYS, np.nan)


class Readback:
    """Copies depths and result into buffers in GPU order; each is read `LATENCY` frames later."""

    def __init__(self, ctx: moderngl.Context, near_m: float, infinity_m: float) -> None:
        self._near_m = near_m
        self._infinity_m = infinity_m
        self._free = [gl.dynamic_buffer(ctx, (RAYS + 4) * 4) for _ in range(LATENCY + 1)]
        self._pending: deque[tuple[int, Array, moderngl.Buffer]] = deque()

    def record(
        self,
        frame_index: int,
        rays: moderngl.Framebuffer | None,
        ray_lengths: Array,
        result: moderngl.Framebuffer,
    ) -> tuple[FocusSample, ...]:
        """Queue this frame's result, and its rays if it has any; return the sample that is due.

        `ray_lengths`: (9,) metres to be told of each ray per metre of its depth.
        """
        buffer = self._free.pop()
        if rays is not None:
            rays.read_into(buffer, components=1, attachment=-1, dtype="f4")
        result.read_into(buffer, components=4, dtype="f4", write_offset=RAYS * 4)
        self._pending.append((frame_index, ray_lengths, buffer))
        return (self._read(),) if len(self._pending) > LATENCY else ()

    def drain(self) -> tuple[FocusSample, ...]:
        """Return all samples that are still queued."""
        return tuple(self._read() for _ in range(len(self._pending)))

    def _read(self) -> FocusSample:
        frame_index, ray_lengths, buffer = self._pending.popleft()
        values = np.frombuffer(buffer.read(), dtype=np.float32).astype(np.float64)
        self._free.append(buffer)
        focus_m, target_m, used = values[RAYS : RAYS + 3].tolist()
        bits = (int(used) >> np.arange(RAYS)) & 1
        rays_m = self._metres(values[:RAYS], ray_lengths) if used else _NO_RAYS
        return FocusSample(frame_index, focus_m, target_m, rays_m, bits.astype(bool))

    def _metres(self, depths: Array, ray_lengths: Array) -> Array:
        near = self._near_m * ray_lengths
        sky = depths * self._infinity_m <= near
        return np.asarray(near / np.where(sky, near / self._infinity_m, depths))


def focus_texture(ctx: moderngl.Context, focus_m: float) -> moderngl.Texture:
    """Return a 1×1 RGBA32F texture: x = focus, y = its target (m), z = bits of the rays used."""
    texture = gl.color_texture(ctx, (1, 1), dtype="f4")
    write_focus(texture, focus_m)
    return texture


def write_focus(texture: moderngl.Texture, focus_m: float) -> None:
    """Put a distance (m) into a texture of :func:`focus_texture`, as focus and as target."""
    texture.write(np.array([focus_m, focus_m, 0.0, 1.0], dtype=np.float32))
