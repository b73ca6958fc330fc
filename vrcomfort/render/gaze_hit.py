"""Gaze hits: distance and node on the line of sight, read back some frames late.

Where a frame has gaze, one texel is drawn along it, from the head centre as the focus is: a frustum
0.3 arcmin wide, through the holes of alpha masks and through what is blended. Nobody waits for it.
"""

from __future__ import annotations

from collections import deque

import moderngl
import numpy as np

from vrcomfort.frame import GazeHit
from vrcomfort.geometry import Array, Gaze, Pose
from vrcomfort.gpu import gl
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.optics.focus import WIDEST_GAZE
from vrcomfort.render.camera import rotation_only
from vrcomfort.render.focus.rays import ray_lengths, ray_projections
from vrcomfort.render.gpu_scene import GpuScene

_FLOAT = 4
"""Bytes."""


class GazeHits:
    """Looks along the gaze of each frame.

    Parameters
    ----------
    gpu
        The scene; `GpuScene.update` must have been called for the frame that is looked at.
    near_m
        Nearer than this nothing is drawn.
    along_ray
        Tell distances along the line of sight, not along the head's forward axis.
    """

    def __init__(
        self, ctx: moderngl.Context, gpu: GpuScene, *, near_m: float, along_ray: bool
    ) -> None:
        self._ctx, self._gpu = ctx, gpu
        self._near_m, self._along_ray = near_m, along_ray
        self._depth = gl.depth_texture(ctx, (1, 1))
        self._number = gl.color_texture(ctx, (1, 1), components=1, dtype="f4")
        self._texel = ctx.framebuffer([self._number], self._depth)
        self._free = [gl.dynamic_buffer(ctx, 2 * _FLOAT) for _ in range(LATENCY + 1)]
        self._pending: deque[tuple[int, float, moderngl.Buffer]] = deque()
        self.triangles = 0
        """Those that the last look sent."""
        self.sought = False
        """Whether the last frame's gaze was known, and is looked along."""

    def look(
        self, frame_index: int, head_from_gaze: Gaze, world_from_head: Pose
    ) -> tuple[GazeHit, ...]:
        """Look along the gaze of a frame, if it is known; return the hit that is due."""
        ahead = head_from_gaze.pose.forward
        self.triangles = 0
        self.sought = head_from_gaze.valid and ahead[2] <= -WIDEST_GAZE
        if not self.sought:
            return ()
        tangents = (ahead[:2] / -ahead[2])[None]
        self._draw(tangents, world_from_head)
        buffer = self._free.pop()
        self._texel.read_into(buffer, components=1, attachment=-1, dtype="f4")
        self._texel.read_into(buffer, components=1, dtype="f4", write_offset=_FLOAT)
        length = float(ray_lengths(tangents)[0]) if self._along_ray else 1.0
        self._pending.append((frame_index, length, buffer))
        return (self._read(),) if len(self._pending) > LATENCY else ()

    def drain(self) -> tuple[GazeHit, ...]:
        """Return all hits that are still on their way; waits for the GPU."""
        return tuple(self._read() for _ in range(len(self._pending)))

    def _draw(self, tangents: Array, head: Pose) -> None:
        ctx = self._ctx
        clip_from_head = ray_projections(tangents, self._near_m)[0]
        self._texel.use()
        self._texel.clear(depth=0.0)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        clip_from_relative = clip_from_head @ rotation_only(head.rotation.T)
        self.triangles = self._gpu.draw_node_numbers(clip_from_relative, head.position)
        ctx.enable_only(moderngl.NOTHING)

    def _read(self) -> GazeHit:
        frame_index, length, buffer = self._pending.popleft()
        depth, number = np.frombuffer(buffer.read(), dtype=np.float32).tolist()
        self._free.append(buffer)
        if depth <= 0.0 or number < 1.0:
            return GazeHit(frame_index, None, "")
        node = self._gpu.scene.nodes[round(number) - 1]
        return GazeHit(frame_index, self._near_m * length / depth, node.name)
