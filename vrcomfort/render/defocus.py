"""How far each pixel of one eye is out of focus: colour and signed radius side by side."""

from __future__ import annotations

from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Fov, Pose, rotate
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.fullscreen_pass import FullscreenPass


class DefocusUniforms(NamedTuple):
    """What ``defocus.frag`` needs of the eye that drew the image."""

    tangents: tuple[float, float, float, float]
    head_forward_in_view: tuple[float, float, float]
    near_m: float
    offset_m: float


class _Lens(NamedTuple):
    infinity_m: float
    px_per_defocus: float
    radius_limit_px: float


def radius_limit_px(settings: DepthOfField, size_px: tuple[int, int]) -> float:
    """Return the largest circle-of-confusion radius that `settings` allow at this image size."""
    return coc.max_radius_px(settings.max_radius_percent, size_px[0])


def full_blur(settings: DepthOfField) -> float:
    """Return the defocus that reaches the largest radius: metres or dioptres, as the law has it."""
    return settings.full_blur_m if settings.law == "linear" else settings.full_blur_dioptre


def defocus_uniforms(fov: Fov, near_m: float, head_from_eye: Pose) -> DefocusUniforms:
    """Return the uniforms that turn an eye's depth into depth along the head's forward axis."""
    x, y, z = rotate(head_from_eye.inverse().orientation, np.array([0.0, 0.0, -1.0]))
    offset_m = -float(head_from_eye.position[2])
    return DefocusUniforms(fov.tangents, (float(x), float(y), float(z)), near_m, offset_m)


class Defocus:
    """Gives every pixel of `colour` its signed circle-of-confusion radius.

    Parameters
    ----------
    colour, depth
        Linear HDR RGBA16F and reverse-Z D32F of `size_px`.
    focus
        1×1 texture whose x is the focus distance in metres, the same one for both eyes.
    infinity_m
        Distance taken for the sky.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        focus: moderngl.Texture,
        settings: DepthOfField,
        size_px: tuple[int, int],
        infinity_m: float,
    ) -> None:
        self.size_px = size_px
        self.limit_px = radius_limit_px(settings, size_px)
        """Largest radius of any point."""
        law = {"LAW_DIOPTRE": 1} if settings.law == "dioptre" else {}
        self._pass = FullscreenPass(
            ctx,
            "defocus.frag",
            size_px=size_px,
            inputs={"colour": colour, "depth": depth, "focus": focus},
            constants=_Lens(infinity_m, self.limit_px / full_blur(settings), self.limit_px),
            defines=law,
        )
        self.points = self._pass.target
        """RGBA16F: finite colour, signed radius in pixels of image width."""

    def render(self, *, fov: Fov, near_m: float, head_from_eye: Pose) -> None:
        """Find the radii of what an eye drew: its frustum, near plane and place in the head."""
        self._pass.render(defocus_uniforms(fov, near_m, head_from_eye))
