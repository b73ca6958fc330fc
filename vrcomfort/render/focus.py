"""Focus at the head centre: nine rays into what is drawn, decided on the GPU, read back late.

::

    head ──────────────● ray 1       Each ray is a frustum one texel wide around it, so the centre
         ╲╲────────● ray 2..9        of texel k of a 9 × 1 depth image lies exactly on ray k.

One focus distance serves both eyes; it never comes from an eye's depth buffer.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.geometry import Array, Fov, Pose, clip_from_view, rotation_matrix
from vrcomfort.optics.focus import RAYS, ray_tangents
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render import gl, shaders
from vrcomfort.render.camera import rotation_only
from vrcomfort.render.gpu_scene import GpuScene

LATENCY = 2
"""Frames between drawing and reading: the CPU never waits for the frame it has just sent."""

RAY_WIDTH = 1e-4
"""Tangent across a ray's frustum, 0.3 arcmin. Thin enough that alpha masks are read at full size,
as a ray meets them; a pixel's width would read a mip level and see other holes."""

AT_ONCE = 3e38
"""A step of the refocus law that reaches everything."""


@dataclass(frozen=True, eq=False)
class FocusSample:
    """The focus of one frame.

    Parameters
    ----------
    frame_index
        `Frame.index`.
    focus_m, focus_raw_m
        After and before the refocus law, metres along the head's forward axis.
    rays_m
        (9,) metres along the head's forward axis, NaN where focus is not found by rays.
    used
        (9,) bool, False for outliers.
    """

    frame_index: int
    focus_m: float
    focus_raw_m: float
    rays_m: Array
    used: NDArray[np.bool_]


class _Constants(NamedTuple):
    """Uniforms of ``focus.frag`` that never change."""

    near_m: float
    infinity_m: float
    outlier_mad: float
    outlier_floor: float


class FocusPass:
    """Finds the focus distance of each frame by nine rays; `texture` holds it.

    Parameters
    ----------
    gpu
        The scene; `GpuScene.update` must have been called for the frame that `render` draws.
    near_m
        Nearer than this nothing is drawn, for the rays as for the eyes.
    """

    def __init__(
        self, ctx: moderngl.Context, gpu: GpuScene, settings: Focus, *, near_m: float = 0.02
    ) -> None:
        self._ctx = ctx
        self._gpu = gpu
        self._settings = settings
        self._near_m = near_m
        self._clips_from_head = ray_projections(settings.ring_deg, near_m)
        self._depth = gl.depth_texture(ctx, (RAYS, 1))
        self._rays = ctx.framebuffer([], self._depth)
        self._before = _state(ctx, settings.infinity_m)
        self.texture = _state(ctx, settings.infinity_m)
        """1×1 RGBA32F: x = focus, y = mean before the refocus law, z = bits of the rays used."""
        self._target = ctx.framebuffer([self.texture])
        self._history = ctx.framebuffer([self._before])
        self._triangle = self._estimate_program()
        self._readback = _Readback(ctx, near_m, settings.infinity_m)
        self._last_time_ns: int | None = None
        self.triangles = 0

    def render(
        self,
        *,
        frame_index: int,
        display_time_ns: int,
        world_from_head: Pose,
        discontinuity: bool = False,
    ) -> tuple[FocusSample, ...]:
        """Find the focus of a frame, and return the samples that have arrived meanwhile.

        The refocus law gets the time since the frame before; at a discontinuity, at the first
        frame, and where time goes back, focus is at once where the rays say.
        """
        self._draw_rays(world_from_head)
        last_ns, self._last_time_ns = self._last_time_ns, display_time_ns
        cut = discontinuity or last_ns is None or display_time_ns < last_ns
        dt_s = 0.0 if cut or last_ns is None else (display_time_ns - last_ns) * 1e-9
        self._estimate(AT_ONCE if cut else step_size(self._settings, dt_s))
        return self._readback.record(frame_index, self._rays, self._target)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return the samples that are still on their way."""
        return self._readback.drain()

    def _draw_rays(self, world_from_head: Pose) -> None:
        ctx = self._ctx
        self._rays.use()
        self._rays.viewport = (0, 0, RAYS, 1)
        self._rays.clear(depth=0.0)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        head_from_relative = rotation_only(rotation_matrix(world_from_head.orientation).T)
        self.triangles = self._gpu.draw_depth_views(
            self._clips_from_head @ head_from_relative, world_from_head.position, self._aim
        )
        self._rays.viewport = (0, 0, RAYS, 1)
        ctx.enable_only(moderngl.NOTHING)

    def _aim(self, ray: int) -> None:
        self._rays.viewport = (ray, 0, 1, 1)

    def _estimate(self, step: float) -> None:
        self._ctx.copy_framebuffer(self._history, self._target)
        self._target.use()
        self._depth.use(0)
        self._before.use(1)
        self._triangle.program["step_size"] = step
        self._triangle.render(vertices=3)

    def _estimate_program(self) -> moderngl.VertexArray:
        settings = self._settings
        dioptres = settings.mean == "dioptres"
        variants = {"MEAN_DIOPTRES": dioptres, "LAW_DIOPTRE": settings.law == "linear_dioptre"}
        triangle = shaders.fullscreen(
            self._ctx, "focus.frag", {name: 1 for name, wanted in variants.items() if wanted}
        )
        floor = settings.outlier_floor_dioptre if dioptres else settings.outlier_floor_fraction
        constants = _Constants(self._near_m, settings.infinity_m, settings.outlier_mad, floor)
        for name, value in {"depth": 0, "before": 1, **constants._asdict()}.items():
            triangle.program[name] = value
        return triangle


class FixedFocus:
    """Focus that no ray decides: the same interface, no rays, no draw calls."""

    def __init__(self, ctx: moderngl.Context, settings: Focus) -> None:
        self._focus_m = settings.fixed_m
        self.texture = _state(ctx, settings.fixed_m)
        self.triangles = 0

    def render(
        self,
        *,
        frame_index: int,
        display_time_ns: int,  # noqa: ARG002 - the interface of `FocusPass`
        world_from_head: Pose,  # noqa: ARG002
        discontinuity: bool = False,  # noqa: ARG002
    ) -> tuple[FocusSample, ...]:
        """Return the sample of this frame."""
        no_rays, unused = np.full(RAYS, np.nan), np.zeros(RAYS, dtype=bool)
        return (FocusSample(frame_index, self._focus_m, self._focus_m, no_rays, unused),)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return nothing: nothing is late."""
        return ()


def make_focus_pass(
    ctx: moderngl.Context, gpu: GpuScene, settings: Focus, *, near_m: float = 0.02
) -> FocusPass | FixedFocus:
    """Return the pass that `settings.method` asks for."""
    if settings.method == "fixed":
        return FixedFocus(ctx, settings)
    return FocusPass(ctx, gpu, settings, near_m=near_m)


def ray_projections(ring_deg: float, near_m: float) -> Array:
    """Return (9, 4, 4) reverse-Z projections of the head's frame, one narrow frustum per ray.

    Depth stays ``near_m / distance`` with distance along the head's forward axis.
    """
    half = RAY_WIDTH / 2
    corners = ray_tangents(ring_deg)[:, :, None] + [-half, half]
    return np.stack(
        [
            clip_from_view(Fov(*np.arctan([left, right, up, down]).tolist()), near_m)
            for (left, right), (down, up) in corners
        ]
    )


def step_size(settings: Focus, dt_s: float) -> float:
    """Return how far focus may move in `dt_s`: metres, or dioptres for `linear_dioptre`."""
    if settings.law == "instant":
        return AT_ONCE
    reach = settings.infinity_m if settings.law == "linear" else 1.0
    return reach / settings.refocus_s * dt_s


def _state(ctx: moderngl.Context, focus_m: float) -> moderngl.Texture:
    texture = gl.color_texture(ctx, (1, 1), dtype="f4")
    texture.write(np.array([focus_m, focus_m, 0.0, 1.0], dtype=np.float32))
    return texture


class _Readback:
    """Copies depths and result into buffers in GPU order; each is read `LATENCY` frames later."""

    def __init__(self, ctx: moderngl.Context, near_m: float, infinity_m: float) -> None:
        self._near_m = near_m
        self._infinity_m = infinity_m
        self._free = [gl.dynamic_buffer(ctx, (RAYS + 4) * 4) for _ in range(LATENCY + 1)]
        self._pending: deque[tuple[int, moderngl.Buffer]] = deque()

    def record(
        self, frame_index: int, rays: moderngl.Framebuffer, result: moderngl.Framebuffer
    ) -> tuple[FocusSample, ...]:
        buffer = self._free.pop()
        rays.read_into(buffer, components=1, attachment=-1, dtype="f4")
        result.read_into(buffer, components=4, dtype="f4", write_offset=RAYS * 4)
        self._pending.append((frame_index, buffer))
        return (self._read(),) if len(self._pending) > LATENCY else ()

    def drain(self) -> tuple[FocusSample, ...]:
        return tuple(self._read() for _ in range(len(self._pending)))

    def _read(self) -> FocusSample:
        frame_index, buffer = self._pending.popleft()
        values = np.frombuffer(buffer.read(), dtype=np.float32).astype(np.float64)
        self._free.append(buffer)
        focus_m, raw_m, used = values[RAYS : RAYS + 3].tolist()
        sky = values[:RAYS] * self._infinity_m <= self._near_m
        rays_m = self._near_m / np.where(sky, self._near_m / self._infinity_m, values[:RAYS])
        bits = (int(used) >> np.arange(RAYS)) & 1
        return FocusSample(frame_index, focus_m, raw_m, rays_m, bits.astype(bool))
