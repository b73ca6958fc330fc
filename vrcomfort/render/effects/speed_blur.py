"""Blurs one eye's whole image, the more the faster the participant turns or moves."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.geometry import focal_length_px
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, copier
from vrcomfort.optics.motion import sigma_px
from vrcomfort.protocol.conditions import Condition, SpeedBlur
from vrcomfort.render.camera import speed_share
from vrcomfort.render.effects.effect import EyeFrame, RegisteredEffect, reading_colour
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene

LEAST_PX = 0.05
"""A narrower Gaussian gives a neighbour less than one part in 10^80: the image stays as it is."""


class _Sigma(NamedTuple):
    sigma_px: float


def plan(_: Scene, condition: Condition) -> PlannedPass:
    """Plan the blur that grows with speed; without a ramp nothing makes it grow."""
    settings = condition.speed_blur
    if settings is None:
        return PlannedPass("speed_blur", False, "the condition has none")
    if settings.max_sigma_arcmin == 0:
        return PlannedPass("speed_blur", False, "its largest sigma is zero")
    if settings.turning is None and settings.moving is None:
        return PlannedPass("speed_blur", False, "neither turning nor moving makes it grow")
    reason = f"sigma up to {settings.max_sigma_arcmin:g} arcmin at full speed"
    return PlannedPass("speed_blur", True, reason)


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
        self._settings, self._size_px = settings, size_px
        self._across = _axis(ctx, 0, colour, size_px)
        self._along = _axis(ctx, 1, self._across.target, size_px)
        self.target = self._along.target
        self._copy = copier(ctx, colour, self.target)

    max_radius_px = 0.0
    """A Gaussian has no radius."""

    def render(self, eye: EyeFrame) -> None:
        """Blur the present image as fast as the head goes; after a cut it does not."""
        sigma_arcmin = self._settings.max_sigma_arcmin * speed_share(self._settings, eye.step)
        focal_px = focal_length_px(eye.camera.fov, self._size_px)
        x_px, y_px = (sigma_px(sigma_arcmin, each) for each in focal_px)
        if min(x_px, y_px) < LEAST_PX:
            self._copy()
            return
        self._draw(x_px, y_px)

    def adjust(self, settings: SpeedBlur) -> None:
        """Draw by other settings from now on."""
        self._settings = settings

    def warm_up(self) -> None:
        """Draw everything once, which frames at rest leave out."""
        self._draw(1.0, 1.0)

    def clamps(self) -> tuple[str, ...]:
        """Return nothing: no limit shortens it."""
        return ()

    def reset(self) -> None:
        """Do nothing: each frame has its own speed."""

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


EFFECT = RegisteredEffect(
    "speed_blur",
    plan,
    reading_colour(SpeedBlurPass),
    measured={"moving": {"from_m_s": 0.01, "to_m_s": 0.1}},
)
