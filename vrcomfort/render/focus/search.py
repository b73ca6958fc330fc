"""Focus at the head centre: searched in a small image, decided on the GPU, read back late.

::

    probe (rays, zone) ──► target ──► refocus law ──► texture ──► both eyes
                                          ▲ focus of the frame before

One focus distance serves both eyes; it never comes from an eye's depth buffer. A new rule is its
settings (`vrcomfort.protocol.conditions.Focus`), a `FocusRule`, its shader and the shader's twin.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from struct import Struct
from typing import Any, NamedTuple, Protocol

import moderngl
import numpy as np

from vrcomfort.frame import FocusSample
from vrcomfort.geometry import Array, Gaze, Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.gpu.gl import LATENCY
from vrcomfort.gpu.passes import Pass, PassImage
from vrcomfort.optics.focus import RAYS
from vrcomfort.optics.refocus import AT_ONCE, LAWS
from vrcomfort.protocol.conditions import Focus, FocusRuleName
from vrcomfort.render.gpu_scene import GpuScene
from vrcomfort.render.planned_pass import PlannedPass


class HeadView(NamedTuple):
    """Head of a frame: its place, its frustum and its gaze.

    Parameters
    ----------
    world_from_head
        The head centre.
    discontinuity
        The frame before has nothing to do with this one.
    screen_tangents
        Half width and half height of the image as tangents, the mean of both eyes.
    gaze
        head-from-gaze, None without an eye tracker.
    scene_time_s
        Of the scene's animations.
    zone_centre
        Tangents (right, up) of where the middle of an autofocus zone is to be.
    """

    frame_index: int
    display_time_ns: int
    world_from_head: Pose
    discontinuity: bool = False
    screen_tangents: tuple[float, float] = (1.0, 1.0)
    gaze: Gaze | None = None
    scene_time_s: float = 0.0
    zone_centre: tuple[float, float] = (0.0, 0.0)


class FocusInputs(NamedTuple):
    """Scene and settings for building a focus rule.

    Parameters
    ----------
    gpu
        The scene; `GpuScene.update` must have been called for the frame that is rendered.
    near_m
        Nearer than this nothing is drawn, for the search as for the eyes.
    along_ray
        Whether distances are those along each ray, or those along the head's forward axis.
    """

    ctx: moderngl.Context
    gpu: GpuScene
    settings: Focus
    near_m: float
    along_ray: bool = False


class FocusPass(Protocol):
    """Finds the focus distance of each frame."""

    @property
    def texture(self) -> moderngl.Texture:
        """1×1 RGBA32F: x = focus, y = target of the refocus law, z = bits of the rays used."""

    def render(self, view: HeadView) -> tuple[FocusSample, ...]:
        """Find the focus of a frame, and return the samples that have arrived meanwhile."""

    def drain(self) -> tuple[FocusSample, ...]:
        """Return the samples that are still on their way; waits for the GPU."""


@dataclass(frozen=True)
class FocusRule:
    """How focus is found.

    Parameters
    ----------
    name
        Value of `method` in a protocol.
    decide
        Say whether it draws anything, and why; no OpenGL.
    build
        Make it.
    """

    name: FocusRuleName
    decide: Callable[[Focus], tuple[bool, str]]
    build: Callable[[FocusInputs], FocusPass]

    def plan(self, settings: Focus) -> PlannedPass:
        """Plan the search."""
        return PlannedPass("focus", *self.decide(settings))


class ProbeResult(NamedTuple):
    """A probe's drawing, bound to texture unit 2.

    Parameters
    ----------
    uniforms
        Those of this frame.
    rays
        The 9 × 1 depth image to be recorded, if there is one.
    ray_lengths
        (9,) metres of each ray's distance per metre along the head's forward axis.
    """

    uniforms: dict[str, Any]
    rays: moderngl.Framebuffer | None = None
    ray_lengths: Array = np.ones(RAYS)


class Probe(Protocol):
    """A rule's part of the search: a small image, and the shader that reads a target from it."""

    @property
    def fragment(self) -> str:
        """The shader; it calls ``refocus`` of ``include/refocus.glsl`` with the target."""

    @property
    def defines(self) -> shaders.Defines:
        """Its variant."""

    @property
    def constants(self) -> dict[str, Any]:
        """Its uniforms that never change; textures are at unit 2."""

    def look(self, view: HeadView) -> ProbeResult:
        """Draw the small image."""


class FocusSearch:
    """Looks with a probe, and moves focus to the target by the refocus law of the settings."""

    def __init__(self, inputs: FocusInputs, probe: Probe) -> None:
        ctx, settings = inputs.ctx, inputs.settings
        self._ctx = ctx
        self._settings = settings
        self._probe = probe
        self._law = LAWS[settings.law]
        states = 2 if self._law.remembers else 1
        now = [focus_texture(ctx, settings.infinity_m) for _ in range(states)]
        self._before = [focus_texture(ctx, settings.infinity_m) for _ in range(states)]
        self.texture = now[0]
        """1×1 RGBA32F: x = focus, y = target of the refocus law, z = bits of the rays used."""
        self._target = ctx.framebuffer(now)
        self._history = ctx.framebuffer(self._before)
        self._bind_before = gl.binder(ctx, self._before)
        self._triangle = self._program()
        self._values: dict[str, Any] = {}
        """Uniforms of the last frame."""
        now_images, before = (tuple(map(PassImage.of, each)) for each in (now, self._before))
        self._copied = Pass("copy", (), before[:1], earlier=now_images[:1])
        self._decided = Pass(probe.fragment, before, now_images)
        self._readback = Readback(ctx, inputs.near_m, settings.infinity_m)
        self._last_time_ns: int | None = None

    def render(self, view: HeadView) -> tuple[FocusSample, ...]:
        """Find the focus of a frame, and return the samples that have arrived meanwhile.

        The refocus law gets the time since the frame before; at a discontinuity, at the first
        frame, and where time goes back, focus is at once at its target.
        """
        now_ns = view.display_time_ns
        last_ns, self._last_time_ns = self._last_time_ns, now_ns
        if last_ns is None or now_ns < last_ns:
            view = view._replace(discontinuity=True)
        dt_s = 0.0 if last_ns is None else (now_ns - last_ns) * 1e-9
        step = AT_ONCE if view.discontinuity else self._law.step_size(self._settings, dt_s)
        look = self._probe.look(view)
        self._decide({**look.uniforms, "step_size": step})
        return self._readback.record(view.frame_index, look.rays, look.ray_lengths, self._target)

    def adjust(self, settings: Focus) -> None:
        """Take another `infinity_m` from now on."""
        self._settings = settings
        self._readback.adjust_infinity(settings.infinity_m)
        self._triangle.program["infinity_m"] = settings.infinity_m
        for name, value in self._law.constants(settings).items():
            self._triangle.program[name] = value

    def drain(self) -> tuple[FocusSample, ...]:
        """Return the samples that are still on their way."""
        return self._readback.drain()

    def _decide(self, uniforms: dict[str, Any]) -> None:
        # A pass may not read the texture it draws into: the state of the frame before is a copy.
        self._copied.run(self._ctx.copy_framebuffer, self._history, self._target)
        self._target.use()
        self._bind_before()
        for name, value in uniforms.items():
            if self._values.get(name) != value:  # a program keeps uniforms between draws
                self._values[name] = self._triangle.program[name] = value
        self._decided.run(self._triangle.render, vertices=3)

    def _program(self) -> moderngl.VertexArray:
        probe, law = self._probe, self._law
        triangle = shaders.fullscreen(
            self._ctx, probe.fragment, probe.defines, {"refocus_law.glsl": law.glsl}
        )
        memory = {"change_before": 1} if law.remembers else {}
        constants = {"before": 0, **memory, **law.constants(self._settings), **probe.constants}
        for name, value in constants.items():
            triangle.program[name] = value
        return triangle


_NO_RAYS = [math.nan] * RAYS
_RESULT = Struct(f"={RAYS + 4}f")
"""Depths of the rays, then the texel of :func:`focus_texture`."""


class Readback:
    """Copies depths and result into buffers in GPU order; each is read `LATENCY` frames later."""

    def __init__(self, ctx: moderngl.Context, near_m: float, infinity_m: float) -> None:
        self._near_m = near_m
        self._infinity_m = infinity_m
        # One buffer for each frame in flight, and one for the frame that is being drawn.
        self._free = [gl.dynamic_buffer(ctx, (RAYS + 4) * 4) for _ in range(LATENCY + 1)]
        self._pending: deque[tuple[int, Array, moderngl.Buffer]] = deque()

    def adjust_infinity(self, infinity_m: float) -> None:
        """Take the sky at another distance from now on."""
        self._infinity_m = infinity_m

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
        *depths, focus_m, target_m, used, _ = _RESULT.unpack(buffer.read())
        self._free.append(buffer)
        bits, infinity_m = int(used), self._infinity_m
        rays_m, each = _NO_RAYS, [bool(bits >> ray & 1) for ray in range(RAYS)]
        if bits:
            nears = [self._near_m * length for length in ray_lengths]
            rays_m = [
                near / (near / infinity_m if depth * infinity_m <= near else depth)
                for near, depth in zip(nears, depths, strict=True)
            ]
        return FocusSample(frame_index, focus_m, target_m, np.array(rays_m), np.array(each))


def focus_texture(ctx: moderngl.Context, focus_m: float) -> moderngl.Texture:
    """Return a 1×1 RGBA32F texture: x = focus, y = its target (m), z = bits of the rays used."""
    texture = gl.color_texture(ctx, (1, 1), dtype="f4")
    write_focus(texture, focus_m)
    return texture


def write_focus(texture: moderngl.Texture, focus_m: float) -> None:
    """Put a distance (m) into a texture of :func:`focus_texture`, as focus and as target."""
    texture.write(np.array([focus_m, focus_m, 0.0, 1.0], dtype=np.float32))
