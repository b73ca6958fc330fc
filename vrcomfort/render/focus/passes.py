"""Focus at the head centre: found in a small image of its own, decided on the GPU, read back late.

::

    probe (rays, gaze, zone) ──► target ──► refocus law ──► texture ──► both eyes
                                               ▲ focus of the frame before

One focus distance serves both eyes; it never comes from an eye's depth buffer.
"""

from __future__ import annotations

import moderngl
import numpy as np

from vrcomfort.frame import FocusSample
from vrcomfort.geometry import Gaze, Pose
from vrcomfort.gpu import gl, shaders
from vrcomfort.optics.focus import RAYS
from vrcomfort.optics.refocus import backward_euler_share, low_pass_share
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.focus.rays import GazeRays, NineRays, Probe, Sight
from vrcomfort.render.focus.readback import Readback
from vrcomfort.render.focus.zone import AutofocusZone
from vrcomfort.render.gpu_scene import GpuScene

__all__ = ["FixedFocus", "FocusPass", "FocusSample", "make_focus_pass", "step_size"]

AT_ONCE = 3e38
"""A step of any refocus law that reaches everything."""

_PROBES: dict[str, type[NineRays | GazeRays | AutofocusZone]] = {
    "nine_ray": NineRays,
    "gaze": GazeRays,
    "autofocus_zone": AutofocusZone,
}
_LAWS = {
    "linear_dioptre": "LAW_DIOPTRE",
    "low_pass": "LAW_SHARE",
    "low_pass_backward_euler": "LAW_SHARE",
    "duration": "LAW_DURATION",
}


class FocusPass:
    """Finds the focus distance of each frame as `settings.method` says; `texture` holds it.

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
        self._settings = settings
        self._probe: Probe = _PROBES[settings.method](ctx, gpu, settings, near_m=near_m)
        states = 2 if settings.law == "duration" else 1
        now = [_state(ctx, settings.infinity_m) for _ in range(states)]
        self._before = [_state(ctx, settings.infinity_m) for _ in range(states)]
        self.texture = now[0]
        """1×1 RGBA32F: x = focus, y = target of the refocus law, z = bits of the rays used."""
        self._target = ctx.framebuffer(now)
        self._history = ctx.framebuffer(self._before)
        self._triangle = self._program()
        self._readback = Readback(ctx, near_m, settings.infinity_m)
        self._last_time_ns: int | None = None

    @property
    def triangles(self) -> int:
        """Return those that the last frame sent."""
        return self._probe.triangles

    def render(
        self,
        *,
        frame_index: int,
        display_time_ns: int,
        world_from_head: Pose,
        discontinuity: bool = False,
        screen_tangents: tuple[float, float] = (1.0, 1.0),
        gaze: Gaze | None = None,
    ) -> tuple[FocusSample, ...]:
        """Find the focus of a frame, and return the samples that have arrived meanwhile.

        The refocus law gets the time since the frame before; at a discontinuity, at the first
        frame, and where time goes back, focus is at once at its target.

        Parameters
        ----------
        screen_tangents
            Half width and half height of the eyes' images (`autofocus_zone`).
        gaze
            head-from-gaze (`gaze`), None without an eye tracker.
        """
        last_ns, self._last_time_ns = self._last_time_ns, display_time_ns
        cut = discontinuity or last_ns is None or display_time_ns < last_ns
        dt_s = 0.0 if cut or last_ns is None else (display_time_ns - last_ns) * 1e-9
        uniforms = self._probe.look(Sight(world_from_head, screen_tangents, gaze, cut))
        step = AT_ONCE if cut else step_size(self._settings, dt_s)
        self._decide({**uniforms, "step_size": step})
        rays = None if uniforms.get("estimate") == GazeRays.KEEP else self._probe.rays
        return self._readback.record(frame_index, rays, self._target)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return the samples that are still on their way."""
        return self._readback.drain()

    def _decide(self, uniforms: dict[str, float]) -> None:
        self._ctx.copy_framebuffer(self._history, self._target)
        self._target.use()
        for unit, texture in enumerate(self._before):
            texture.use(unit)
        for name, value in uniforms.items():
            self._triangle.program[name] = value
        self._triangle.render(vertices=3)

    def _program(self) -> moderngl.VertexArray:
        settings, probe = self._settings, self._probe
        law = {_LAWS[settings.law]: 1} if settings.law in _LAWS else {}
        triangle = shaders.fullscreen(self._ctx, probe.fragment, {**probe.defines, **law})
        constants = {"before": 0, **probe.constants}
        if settings.law == "duration":
            constants["change_before"] = 1
            constants["duration_s"] = settings.duration_s
            constants["refixation_dioptre"] = settings.refixation_dioptre
        for name, value in constants.items():
            triangle.program[name] = value
        return triangle


class FixedFocus:
    """Focus that nothing decides: the same interface, no rays, no draw calls."""

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
        screen_tangents: tuple[float, float] = (1.0, 1.0),  # noqa: ARG002
        gaze: Gaze | None = None,  # noqa: ARG002
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


def step_size(settings: Focus, dt_s: float) -> float:
    """Return how far focus may move in `dt_s`, in the unit of the law (``refocus.glsl``)."""
    steps = {
        "instant": AT_ONCE,
        "linear": settings.infinity_m / settings.refocus_s * dt_s,
        "linear_dioptre": dt_s / settings.refocus_s,
        "low_pass": low_pass_share(dt_s, settings.cutoff_hz),
        "low_pass_backward_euler": backward_euler_share(dt_s, settings.cutoff_hz),
        "duration": dt_s,
    }
    return steps[settings.law]


def _state(ctx: moderngl.Context, focus_m: float) -> moderngl.Texture:
    texture = gl.color_texture(ctx, (1, 1), dtype="f4")
    texture.write(np.array([focus_m, focus_m, 0.0, 1.0], dtype=np.float32))
    return texture
