"""Depth of field's settings in pixels of an image: lens, radius, and the limit on the radius.

Float64, no OpenGL.
"""

from __future__ import annotations

import math
from math import radians, tan
from typing import NamedTuple

from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.optics.circle_of_confusion import limit_distances_m
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus
from vrcomfort.render.camera import NEAR_M, Lens, LensLaw


def max_radius_of(
    settings: DepthOfField, size_px: tuple[int, int], focal_px: float = math.inf
) -> float:
    """Return the largest circle-of-confusion radius that `settings` allow at this image size.

    Parameters
    ----------
    focal_px
        `max_diameter_arcmin` may allow less at this focal length; without it, an eye's may be any.
    """
    of_width_px = coc.radius_of_percent(settings.max_radius_percent, size_px[0])
    if settings.max_diameter_arcmin is None:
        return of_width_px
    return min(of_width_px, radius_of_arcmin(settings.max_diameter_arcmin, focal_px))


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
    return max_radius_of(settings, size_px, focal_px) / settings.full_blur_dioptre


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
    max_radius_px = max_radius_of(settings, size_px, focal_px)
    if settings.law == "linear":
        return Lens(
            position, focus_m, infinity_m, max_radius_px / settings.full_blur_m, max_radius_px
        )
    px = px_per_dioptre(settings, focal_px=focal_px, size_px=size_px, focus_m=focus_m)
    if settings.law != "thin_lens":
        return Lens(position, focus_m, infinity_m, px, max_radius_px)
    offset_m = settings.distance_offset_m
    focus = coc.lens_focus_m(focus_m + offset_m, settings.focal_length_m)
    return Lens(position, focus, infinity_m + offset_m, px, max_radius_px, offset_m)


# A limit can be put on the radius of each pixel of one image, but not on the mean of views, which
# is the image of a lens. Where it acts, quality levels with views therefore show more blur than
# those without.


FOCAL_PER_WIDTH = 0.5
"""Focal length of an image 90° wide, in parts of its width: assumed until a headset has told how
wide its images are. Most are wider, so that their radii are less by up to a third."""

EXAMPLES_M = (0.5, 1.0, 3.0)
"""Focus distances that are told of where focus moves."""


class Range(NamedTuple):
    """Where the limit acts with this focus: distances from the head, along its forward axis."""

    focus_m: float
    nearer_than_m: float
    farther_than_m: float | None
    """None: not even the sky is so far out of focus."""


class Unlimited(NamedTuple):
    """A condition with more blur in its views than in one view, which has the limit."""

    views: int
    limit_dioptre: float
    ranges: tuple[Range, ...]
    text: str


def radius_per_dioptre_px(settings: DepthOfField, size_px: tuple[int, int]) -> float:
    """Return the radius at one dioptre in an image 90° wide; of the laws that views can have."""
    focal_px = FOCAL_PER_WIDTH * size_px[0]
    return px_per_dioptre(settings, focal_px=focal_px, size_px=size_px, focus_m=math.inf)


def limit_dioptre(settings: DepthOfField) -> float:
    """Return the defocus at which the radius reaches its limit; infinity where it never does."""
    size_px = (1000, 1000)  # any: both grow with it
    radius_px = radius_per_dioptre_px(settings, size_px)
    max_radius_px = max_radius_of(settings, size_px, FOCAL_PER_WIDTH * size_px[0])
    return max_radius_px / radius_px if radius_px else math.inf


def unlimited(condition: Condition) -> Unlimited | None:
    """Return where views go beyond the limit; None where there are none, or nothing is so near."""
    settings = condition.depth_of_field
    if settings is None or settings.views == 1 or settings.max_radius_percent == 0:
        return None
    dioptre = limit_dioptre(settings)
    ranges = tuple(_range(focus_m, dioptre) for focus_m in _focus_m(condition.focus))
    if all(each.nearer_than_m < NEAR_M and each.farther_than_m is None for each in ranges):
        return None
    return Unlimited(settings.views, dioptre, ranges, _text(settings, dioptre, ranges))


def _focus_m(focus: Focus) -> tuple[float, ...]:
    if focus.method == "scripted":
        scripts = focus.named_scripts.values()
        return tuple(sorted({distance_m for script in scripts for _, distance_m in script}))
    return (focus.fixed_m,) if focus.method == "fixed" else EXAMPLES_M


def _range(focus_m: float, dioptre: float) -> Range:
    near_m, far_m = limit_distances_m(focus_m, dioptre)
    return Range(focus_m, near_m, far_m if math.isfinite(far_m) else None)


def _text(settings: DepthOfField, dioptre: float, ranges: tuple[Range, ...]) -> str:
    where = "; ".join(_where(each) for each in ranges)
    exact = settings.law == "dioptre" and settings.max_diameter_arcmin is None
    wide = "" if exact else " in an image 90° wide"
    return (
        f"{settings.views} views through the lens have no largest radius. One view (quality fast "
        f"or balanced) has one, {settings.max_radius_percent:g} % of the image's width, reached at "
        f"{dioptre:.2g} D of defocus{wide}: {where}. There these views show more blur."
    )


def _where(each: Range) -> str:
    text = f"focused at {each.focus_m:g} m, nearer than {each.nearer_than_m:.2g} m"
    if each.farther_than_m is None:
        return text
    return f"{text} or farther than {each.farther_than_m:.2g} m"
