"""Blurs each eye's whole image, the more the faster the participant turns or moves."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl

from vrcomfort.geometry import focal_length_px
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, copier, of_each
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.optics.motion import sigma_px
from vrcomfort.protocol.conditions import Condition, SpeedBlur
from vrcomfort.render.camera import speed_share
from vrcomfort.render.effects.effect import EffectInputs, EffectPass, EyeFrame, RegisteredEffect
from vrcomfort.scene.data import Scene

LEAST_PX = 0.05
"""A narrower Gaussian gives a neighbour less than one part in 10^80: the image stays as it is."""


def decide(settings: SpeedBlur, _: Condition, __: Scene) -> tuple[bool, str]:
    """Say whether there is blur that grows with speed; without a ramp nothing makes it grow."""
    if settings.max_sigma_arcmin == 0:
        return False, "its largest sigma is zero"
    if settings.turning is None and settings.moving is None:
        return False, "neither turning nor moving makes it grow"
    return True, f"sigma up to {settings.max_sigma_arcmin:g} arcmin at full speed"


class SpeedBlurPass(EffectPass):
    """Blurs the image by a Gaussian; at rest the copy is exact."""

    settings: SpeedBlur

    def __init__(self, inputs: EffectInputs) -> None:
        super().__init__(inputs)
        self._size_px = inputs.size_px
        self._across = _axis(inputs.ctx, 0, inputs.colour)
        self._along = _axis(inputs.ctx, 1, self._across.target)
        self.target = self._along.target
        self._copy = copier(inputs.ctx, inputs.colour, self.target)

    def render(self, *eyes: EyeFrame) -> None:
        """Blur the present image as fast as the head goes; after a cut it does not."""
        sigma_arcmin = self.settings.max_sigma_arcmin * speed_share(self.settings, eyes[0].step)
        sigmas_px = [
            tuple(sigma_px(sigma_arcmin, each) for each in focal_length_px(fov, self._size_px))
            for fov in (eye.camera.fov for eye in eyes)
        ]
        if min(map(min, sigmas_px)) < LEAST_PX:
            self._copy()
            return
        self._draw(sigmas_px)

    def warm_up(self) -> None:
        """Draw everything once, which frames at rest leave out."""
        self._draw([(1.0, 1.0)] * gl.layers_of(self.target))

    def _draw(self, sigmas_px: Sequence[tuple[float, ...]]) -> None:
        x_px, y_px = map(of_each, zip(*sigmas_px, strict=True))
        self._across.render(sigma_px_of_eye=x_px)
        self._along.render(sigma_px_of_eye=y_px)


def _axis(ctx: moderngl.Context, axis: int, image: AnyTexture) -> FullscreenPass:
    inputs, defines, size_px = {"image": image}, {"AXIS": axis}, gl.size_px_of(image)
    return FullscreenPass(
        ctx, "speed_blur/gaussian.frag", size_px=size_px, inputs=inputs, defines=defines
    )


EFFECT = RegisteredEffect(
    "speed_blur",
    decide,
    SpeedBlurPass,
    measured={"moving": {"from_m_s": 0.01, "to_m_s": 0.1}},
)
