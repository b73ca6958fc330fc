"""Depth of field of one eye (Carnegie & Rhee 2015): circular bokeh, one focus for both eyes."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Fov, Pose, focal_length_px, rotate
from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.protocol.conditions import DepthOfField, Focus
from vrcomfort.render.fullscreen_pass import FullscreenPass

TILE_PX = 16
"""Side of the tiles that share one summary."""

SMALL_PX = 2
"""Discs up to this radius are summed over every pixel."""


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


class _Directions(NamedTuple):
    directions: bytes


class _Aspect(NamedTuple):
    pixel_aspect: float


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


class DepthOfFieldPass:
    """Blurs `colour` by `depth` around `focus`; the result is `target`.

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
        infinity_m: float = Focus().infinity_m,
    ) -> None:
        self._size_px = size_px
        limit_px = radius_limit_px(settings, size_px)
        law = {"LAW_DIOPTRE": 1} if settings.law == "dioptre" else {}
        self._points = FullscreenPass(
            ctx,
            "defocus.frag",
            size_px=size_px,
            inputs={"colour": colour, "depth": depth, "focus": focus},
            constants=_Lens(infinity_m, limit_px / full_blur(settings), limit_px),
            defines=law,
        )
        self._summaries = self._tile_passes(ctx, limit_px)
        self._half = FullscreenPass(
            ctx,
            "defocus_half.frag",
            size_px=(ceil(size_px[0] / 2), ceil(size_px[1] / 2)),
            inputs={"points": self._points.target},
        )
        directions = coc.ring_directions(settings.rings).astype(np.float32)
        self._gather = FullscreenPass(
            ctx,
            "depth_of_field.frag",
            size_px=size_px,
            inputs={
                "colour": colour,
                "points": self._points.target,
                "points_half": self._half.target,
                "reach": self._summaries[-1].target,
            },
            constants=_Directions(directions.tobytes()),
            defines={"RINGS": settings.rings, "TILE": TILE_PX, "SMALL_PX": f"{SMALL_PX}.0"},
        )
        self.target = self._gather.target

    def _tile_passes(self, ctx: moderngl.Context, limit_px: float) -> tuple[FullscreenPass, ...]:
        width, height = self._size_px
        columns = (ceil(width / TILE_PX), height)
        tiles = (columns[0], ceil(height / TILE_PX))
        x_pass = FullscreenPass(
            ctx,
            "defocus_tiles.frag",
            size_px=columns,
            inputs={"source": self._points.target},
            defines={"TILE": TILE_PX, "SMALL_PX": f"{SMALL_PX}.0", "AXIS": 0},
        )
        y_pass = FullscreenPass(
            ctx,
            "defocus_tiles.frag",
            size_px=tiles,
            inputs={"source": x_pass.target},
            defines={"TILE": TILE_PX, "AXIS": 1},
        )
        # Pixels are at most half again as tall as wide in any headset, hence the factor.
        reach = FullscreenPass(
            ctx,
            "defocus_reach.frag",
            size_px=tiles,
            inputs={"tiles": y_pass.target},
            defines={"REACH": max(1, ceil((1.5 * limit_px + 1) / TILE_PX))},
        )
        return x_pass, y_pass, reach

    def render(self, *, fov: Fov, near_m: float, head_from_eye: Pose) -> None:
        """Blur the image that an eye with this frustum, near plane and place in the head drew."""
        focal_x, focal_y = focal_length_px(fov, self._size_px)
        self._points.render(defocus_uniforms(fov, near_m, head_from_eye))
        for summary in self._summaries:
            summary.render()
        self._half.render()
        self._gather.render(_Aspect(focal_y / focal_x))
