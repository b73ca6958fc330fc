"""How far each pixel of one eye is out of focus: colour and signed radius side by side."""

from __future__ import annotations

from math import ceil, radians, tan
from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Fov, Pose, focal_length_px, rotate
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.camera import Lens, LensLaw
from vrcomfort.render.fullscreen_pass import FullscreenPass, Uniforms
from vrcomfort.render.peak import PeakPass

PEAK_TILE_PX = 16
"""Side of the tiles whose largest radii are compared on the way to the largest of all."""


class DefocusUniforms(NamedTuple):
    """What ``include/defocus.glsl`` needs of the eye that drew the image."""

    tangents: tuple[float, float, float, float]
    head_forward_in_view: tuple[float, float, float]
    near_m: float
    offset_m: float


class _Scale(NamedTuple):
    """Pixels per metre or dioptre; they follow from the eye's field of view."""

    px_per_defocus: float


class _Limit(NamedTuple):
    radius_limit_px: float


class _Infinity(NamedTuple):
    infinity_m: float


class _ThinLens(NamedTuple):
    focal_length_m: float
    distance_offset_m: float


class _PeripheralUnit(NamedTuple):
    peripheral_px: float


class _PeripheralShape(NamedTuple):
    peripheral_exponent: float


class _Together:
    """The fields of several tuples of uniforms."""

    def __init__(self, *parts: Uniforms) -> None:
        self._parts = parts

    def _asdict(self) -> dict[str, Any]:
        return {name: value for part in self._parts for name, value in part._asdict().items()}


def radius_limit_px(settings: DepthOfField, size_px: tuple[int, int]) -> float:
    """Return the largest circle-of-confusion radius that `settings` allow at this image size.

    `max_diameter_arcmin` may allow less: see :func:`radius_limit_in_px`.
    """
    return coc.max_radius_px(settings.max_radius_percent, size_px[0])


def radius_limit_in_px(settings: DepthOfField, focal_px: float, size_px: tuple[int, int]) -> float:
    """Return the largest radius for an eye whose image has a focal length of `focal_px`."""
    limit_px = radius_limit_px(settings, size_px)
    if settings.max_diameter_arcmin is None:
        return limit_px
    return min(limit_px, radius_of_arcmin(settings.max_diameter_arcmin, focal_px))


def radius_of_arcmin(diameter_arcmin: float, focal_px: float) -> float:
    """Return the radius in pixels, in the middle of the image, of a disc given by its diameter."""
    return tan(radians(diameter_arcmin / 120)) * focal_px


def lens_law(settings: DepthOfField | None) -> LensLaw | None:
    """Return whether the radius is proportional to metres or to dioptres of defocus."""
    if settings is None:
        return None
    return "linear" if settings.law == "linear" else "dioptre"


def px_per_dioptre(
    settings: DepthOfField, *, focal_px: float, size_px: tuple[int, int], focus_m: float
) -> float:
    """Return the radius per dioptre of defocus, for every law that is affine in 1/distance.

    Parameters
    ----------
    focal_px
        Horizontal focal length of the eye's image.
    focus_m
        From the head centre; the pixels of a `thin_lens` depend on it.
    """
    if settings.law == "eye":
        return coc.eye_px_per_dioptre(settings.pupil_mm, focal_px)
    if settings.law == "thin_lens":
        return coc.thin_lens_px_per_dioptre(
            settings.aperture_m,
            settings.focal_length_m,
            focal_px,
            focus_m + settings.distance_offset_m,
        )
    return radius_limit_px(settings, size_px) / settings.full_blur_dioptre


def lens(
    settings: DepthOfField,
    position: tuple[float, float],
    focal_px: float,
    size_px: tuple[int, int],
    focus_m: float,
    infinity_m: float,
) -> Lens:
    """Return a point of the lens that `settings` describe, for a reference (`camera.Lens`)."""
    focus_m = min(focus_m, infinity_m)
    limit_px = radius_limit_in_px(settings, focal_px, size_px)
    if settings.law == "linear":
        return Lens(position, focus_m, infinity_m, limit_px / settings.full_blur_m, limit_px)
    px = px_per_dioptre(settings, focal_px=focal_px, size_px=size_px, focus_m=focus_m)
    if settings.law != "thin_lens":
        return Lens(position, focus_m, infinity_m, px, limit_px)
    offset_m = settings.distance_offset_m
    focus = coc.lens_focus_m(focus_m + offset_m, settings.focal_length_m)
    return Lens(position, focus, infinity_m + offset_m, px, limit_px, offset_m)


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
        Texture whose first x is the focus distance in metres, the same one for both eyes.
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
        self._settings = settings
        self.limit_px = radius_limit_px(settings, size_px)
        """No eye's image can have a larger radius."""
        self.limit_now_px = self.limit_px
        """Largest radius that the last eye could have: `max_diameter_arcmin` may make it less."""
        lens = _lens_constants(settings, infinity_m)
        self._pass = FullscreenPass(
            ctx,
            "defocus.frag",
            size_px=size_px,
            inputs={"colour": colour, "depth": depth, "focus": focus},
            constants=_Together(lens, *_peripheral_constants(settings)),
            defines={**_law_defines(settings), **_peripheral_defines(settings)},
        )
        width, height = size_px
        self._peaks = FullscreenPass(
            ctx,
            "defocus_peak.frag",
            size_px=(ceil(width / PEAK_TILE_PX), ceil(height / PEAK_TILE_PX)),
            inputs={"depth": depth, "focus": focus},
            constants=lens,
            defines={**_law_defines(settings), "TILE": PEAK_TILE_PX},
            dtype="f4",
        )
        self._peak = PeakPass(ctx, self._peaks.target)
        self._least_limit_px = self.limit_px
        self.points = self._pass.target
        """RGBA16F: finite colour, signed radius in pixels of image width."""

    def render(self, *, fov: Fov, near_m: float, head_from_eye: Pose) -> None:
        """Find the radii of what an eye drew: its frustum, near plane and place in the head."""
        eye = defocus_uniforms(fov, near_m, head_from_eye)
        focal_px = focal_length_px(fov, self.size_px)[0]
        limit = _Limit(radius_limit_in_px(self._settings, focal_px, self.size_px))
        scale = self._scale(focal_px, limit)
        self.limit_now_px = limit.radius_limit_px
        self._least_limit_px = min(self._least_limit_px, self.limit_now_px)
        self._pass.render(_Together(eye, scale, limit, *_peripheral_unit(self._settings, focal_px)))
        needs_limit = self._settings.law == "linear"
        self._peaks.render(_Together(eye, scale, *([limit] if needs_limit else [])))
        self._peak.render()

    def forget(self) -> None:
        """Count no frame so far among those that :meth:`clamps` tells of."""
        self._peak.forget()
        self._least_limit_px = self.limit_px

    def largest_radius_px(self) -> float:
        """Return the largest radius of all frames before its limit; waits for the GPU."""
        return self._peak.read()

    def clamps(self) -> tuple[str, ...]:
        """Return what the limit has done to the frames so far, in words; waits for the GPU."""
        largest_px = self.largest_radius_px()
        if largest_px <= self._least_limit_px:
            return ()
        return (
            f"depth of field: circles of confusion of up to {largest_px:.1f} px (radius) were "
            f"limited to {self._least_limit_px:.1f} px",
        )

    def _scale(self, focal_px: float, limit: _Limit) -> _Scale:
        settings = self._settings
        if settings.law == "linear":
            return _Scale(limit.radius_limit_px / settings.full_blur_m)
        # A thin lens focused at infinity: the shader knows the focus.
        return _Scale(
            px_per_dioptre(settings, focal_px=focal_px, size_px=self.size_px, focus_m=np.inf)
        )


def _law_defines(settings: DepthOfField) -> dict[str, int]:
    wanted = {"LAW_DIOPTRE": settings.law != "linear", "LAW_THIN_LENS": settings.law == "thin_lens"}
    return {name: 1 for name, needed in wanted.items() if needed}


def _lens_constants(settings: DepthOfField, infinity_m: float) -> Uniforms:
    infinity = _Infinity(infinity_m)
    if settings.law != "thin_lens":
        return infinity
    return _Together(infinity, _ThinLens(settings.focal_length_m, settings.distance_offset_m))


def _peripheral_defines(settings: DepthOfField) -> dict[str, int]:
    return {} if settings.peripheral is None else {"PERIPHERAL": 1}


def _peripheral_constants(settings: DepthOfField) -> tuple[Uniforms, ...]:
    shape = settings.peripheral
    return () if shape is None else (_PeripheralShape(shape.exponent),)


def _peripheral_unit(settings: DepthOfField, focal_px: float) -> tuple[Uniforms, ...]:
    shape = settings.peripheral
    if shape is None:
        return ()
    return (_PeripheralUnit(radius_of_arcmin(shape.unit_diameter_arcmin, focal_px)),)
