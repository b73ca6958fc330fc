"""Blurs one eye's whole image, the more the faster the participant turns or moves."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.geometry import Fov, focal_length_px
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.gaussian import sigma_px
from vrcomfort.optics.motion import ramp
from vrcomfort.protocol.conditions import SpeedBlur
from vrcomfort.render.head_step import HeadStep

LEAST_PX = 0.05
"""A narrower Gaussian gives a neighbour less than one part in 10^80: the image stays as it is."""


class _Sigma(NamedTuple):
    sigma_px: float


def strength(settings: SpeedBlur, step: HeadStep | None) -> float:
    """Return 0 (at rest, or after a cut) to 1 (at full speed), the same for both eyes."""
    if step is None:
        return 0.0
    turning, moving, of = settings.turning, settings.moving, settings.speed_of
    by_turning = turning and ramp(step.turn_deg_s(of), turning.from_deg_s, turning.to_deg_s)
    by_moving = moving and ramp(step.speed_m_s(of), moving.from_m_s, moving.to_m_s)
    return max(by_turning or 0.0, by_moving or 0.0)


class SpeedBlurPass:
    """Blurs `colour` (linear HDR RGBA16F) into `target`; at rest the copy is exact."""

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        settings: SpeedBlur,
        size_px: tuple[int, int],
    ) -> None:
        self._settings, self._size_px, self._colour = settings, size_px, colour
        self._across = _axis(ctx, 0, colour, size_px)
        self._along = _axis(ctx, 1, self._across.target, size_px)
        self._copy = gl.copier(ctx)
        self.target = self._along.target

    def render(self, *, fov: Fov, step: HeadStep | None) -> None:
        """Blur the present image of an eye with this frustum; `step` is None after a cut."""
        sigma_arcmin = self._settings.max_sigma_arcmin * strength(self._settings, step)
        x_px, y_px = (sigma_px(sigma_arcmin, f) for f in focal_length_px(fov, self._size_px))
        if min(x_px, y_px) < LEAST_PX:
            self._copy(self._colour, self.target)
            return
        self._draw(x_px, y_px)

    def warm_up(self) -> None:
        """Draw everything once, which frames at rest leave out."""
        self._draw(1.0, 1.0)

    def _draw(self, x_px: float, y_px: float) -> None:
        self._across.render(_Sigma(x_px))
        self._along.render(_Sigma(y_px))


def _axis(
    ctx: moderngl.Context, axis: int, image: moderngl.Texture, size_px: tuple[int, int]
) -> FullscreenPass:
    inputs = {"image": image}
    return FullscreenPass(
        ctx, "speed_blur/gaussian.frag", size_px=size_px, inputs=inputs, defines={"AXIS": axis}
    )
