"""Depth of field as the mean of views through the lens, each of which is blurred a little.

One setting spans fast to reference: with one view all blur is a filter's; with K, each view is
blurred over about 2/√K of the lens, so that nothing shows between them, and what a filter cannot
know (what a near thing hides) is drawn instead of guessed. Views so many that they lie about a
pixel apart are not blurred: how a pixel samples the scene hides what is between them.
"""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from vrcomfort.geometry import Fov, focal_length_px
from vrcomfort.optics.view_points import view_points, view_radius
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render import gl, shaders
from vrcomfort.render.camera import Lens
from vrcomfort.render.lens_radius import lens, radius_limit_px

LEAST_BLUR_PX = 1.0
"""Radius of a view's blur at one dioptre of defocus, which most of a room is within, below which
views without a blur are closer to the reference: 256 of 320 px width by 2 dB in the temple."""


def part_of_one_view(settings: DepthOfField, size_px: tuple[int, int]) -> float:
    """Return the radius over which each view is blurred, in parts of the lens; 0 for not at all."""
    part = view_radius(settings.views, settings.over_blur)
    dioptres = max(settings.full_blur_dioptre, 1.0) if settings.law == "dioptre" else 1.0
    small = part * radius_limit_px(settings, size_px) < LEAST_BLUR_PX * dioptres
    return 0.0 if small and settings.views > 1 else part


def blur_of_one_view(settings: DepthOfField, size_px: tuple[int, int]) -> DepthOfField | None:
    """Return the settings by which one of the views is blurred; None where it is not.

    For one view they are these settings.
    """
    if settings.views == 1:
        return settings
    part = part_of_one_view(settings, size_px)
    diameter = settings.max_diameter_arcmin
    update = {
        "max_radius_percent": part * settings.max_radius_percent,
        "max_diameter_arcmin": diameter and part * diameter,
        "pupil_mm": part * settings.pupil_mm,
    }
    return settings.model_copy(update=update) if part else None


class LensViews:
    """Averages what is drawn through each point of a lens; the mean is `target`.

    The points are the same in both eyes and in every frame: no noise, no rivalry. Sums are 32-bit
    floats. Focus is left to the GPU (`ScenePass.lens_focus`).

    Parameters
    ----------
    view
        The texture that holds a view once it is drawn and blurred.
    infinity_m
        Distance taken for the sky.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        view: moderngl.Texture,
        settings: DepthOfField,
        infinity_m: float,
    ) -> None:
        self.views = settings.views
        self._settings = settings
        self._infinity_m = infinity_m
        self._points = view_points(settings.views, part_of_one_view(settings, view.size))
        self._sum = gl.color_texture(ctx, view.size, dtype="f4")
        self.target = gl.color_texture(ctx, view.size)
        self._view = view
        self._ctx = ctx
        self._copy = shaders.fullscreen(ctx, "scaled_copy.frag")
        self._summing = ctx.framebuffer([self._sum])
        self._averaging = ctx.framebuffer([self.target])

    def render(self, fov: Fov, draw: Callable[[Lens], None]) -> None:
        """Average the views of an eye with this frustum; `draw` fills the view's texture."""
        self._summing.clear()
        for point in self._lenses(fov):
            draw(point)
            self._ctx.blend_func = moderngl.ONE, moderngl.ONE
            with self._ctx.scope(self._summing, moderngl.BLEND):
                self._scaled(self._view, 1.0)
        with self._ctx.scope(self._averaging, moderngl.NOTHING):
            self._scaled(self._sum, 1 / self.views)

    def _scaled(self, image: moderngl.Texture, share: float) -> None:
        image.use(0)
        self._copy.program["share"] = share
        self._copy.render(vertices=3)

    def _lenses(self, fov: Fov) -> list[Lens]:
        focal_x, focal_y = focal_length_px(fov, self._view.size)
        # Round in angle, not in pixels. The focus is the scene pass's to fill in.
        return [
            lens(
                self._settings,
                (float(x), float(y) * focal_y / focal_x),
                focal_x,
                self._view.size,
                self._infinity_m,
                self._infinity_m,
            )
            for x, y in self._points
        ]
