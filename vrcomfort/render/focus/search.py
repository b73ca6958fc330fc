"""Focus at the head centre: found in a small image of its own, decided on the GPU, read back late.

::

    probe (rays, zone) ──► target ──► refocus law ──► texture ──► both eyes
                                          ▲ focus of the frame before

One focus distance serves both eyes; it never comes from an eye's depth buffer.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import moderngl
import numpy as np

from vrcomfort.frame import FocusSample
from vrcomfort.geometry import Array
from vrcomfort.gpu import shaders
from vrcomfort.optics.focus import RAYS
from vrcomfort.optics.refocus import AT_ONCE, LAWS
from vrcomfort.render.focus.readback import Readback, focus_texture
from vrcomfort.render.focus.rule import FocusInputs, Sight


class Look(NamedTuple):
    """What a probe has drawn, and bound to texture unit 2.

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
    """What a rule adds to the search: a small image, and the shader that reads a target from it."""

    @property
    def fragment(self) -> str:
        """The shader; it calls ``refocus`` of ``include/refocus.glsl`` with the target."""

    @property
    def defines(self) -> shaders.Defines:
        """Its variant."""

    @property
    def constants(self) -> dict[str, Any]:
        """Its uniforms that never change; textures are at unit 2."""

    @property
    def triangles(self) -> int:
        """Those of the last look."""

    def look(self, sight: Sight) -> Look:
        """Draw what focus looks at."""


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
        self._triangle = self._program()
        self._readback = Readback(ctx, inputs.near_m, settings.infinity_m)
        self._last_time_ns: int | None = None

    @property
    def triangles(self) -> int:
        """Return those that the last frame sent."""
        return self._probe.triangles

    def render(self, sight: Sight) -> tuple[FocusSample, ...]:
        """Find the focus of a frame, and return the samples that have arrived meanwhile.

        The refocus law gets the time since the frame before; at a discontinuity, at the first
        frame, and where time goes back, focus is at once at its target.
        """
        now_ns = sight.display_time_ns
        last_ns, self._last_time_ns = self._last_time_ns, now_ns
        if last_ns is None or now_ns < last_ns:
            sight = sight._replace(discontinuity=True)
        dt_s = 0.0 if last_ns is None else (now_ns - last_ns) * 1e-9
        step = AT_ONCE if sight.discontinuity else self._law.step_size(self._settings, dt_s)
        look = self._probe.look(sight)
        self._decide({**look.uniforms, "step_size": step})
        return self._readback.record(sight.frame_index, look.rays, look.ray_lengths, self._target)

    def drain(self) -> tuple[FocusSample, ...]:
        """Return the samples that are still on their way."""
        return self._readback.drain()

    def _decide(self, uniforms: dict[str, Any]) -> None:
        self._ctx.copy_framebuffer(self._history, self._target)
        self._target.use()
        for unit, texture in enumerate(self._before):
            texture.use(unit)
        for name, value in uniforms.items():
            self._triangle.program[name] = value
        self._triangle.render(vertices=3)

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
