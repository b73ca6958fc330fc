"""What the settings of depth of field are in pixels of an image: float64, no OpenGL."""

from __future__ import annotations

from math import radians, tan

from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.camera import Lens, LensLaw


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
    return radius_limit_in_px(settings, focal_px, size_px) / settings.full_blur_dioptre


def lens(
    settings: DepthOfField,
    position: tuple[float, float],
    focal_px: float,
    size_px: tuple[int, int],
    focus_m: float,
    infinity_m: float,
) -> Lens:
    """Return a point of the lens that `settings` describe, for views and references."""
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
