"""Depth of field of each eye: circular bokeh, one focus for both eyes.

With several views through the lens the effect blurs each view a little, and `LensViews` averages
them. One setting spans fast to reference: with one view all blur is a filter's; with K, each view
is blurred over about 2/√K of the lens, so that no gap shows between them, and what a filter cannot
know (the background that the foreground hides) is drawn instead of guessed. Views that
lie about a pixel apart are not blurred: the pixel's own sampling of the scene hides the gaps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import moderngl

from vrcomfort.geometry import Fov, focal_length_px
from vrcomfort.gpu import gl, passes
from vrcomfort.gpu.fullscreen_pass import ADDED, FullscreenPass
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.optics.lens_sampling import FEW, view_points, view_radius
from vrcomfort.protocol.conditions import Condition, DepthOfField
from vrcomfort.render.camera import Lens
from vrcomfort.render.effects.depth_of_field import half_gather
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses, aspects
from vrcomfort.render.effects.depth_of_field.kernels import make_kernel
from vrcomfort.render.effects.depth_of_field.layered_gather import (
    BlurKernel,
    LayeredGatherKernel,
    is_layered,
)
from vrcomfort.render.effects.depth_of_field.lens_radius import lens, radius_per_dioptre_px
from vrcomfort.render.effects.depth_of_field.near_things import BEHIND_PX, CocTiles, NearThings
from vrcomfort.render.effects.effect import EffectInputs, EffectPass, EyeFrame, RegisteredEffect
from vrcomfort.scene.data import Scene


def decide(settings: DepthOfField, condition: Condition, _: Scene) -> tuple[bool, str]:
    """Say whether there is depth of field; r_max = 0 is the pinhole image, which needs no pass."""
    if settings.max_radius_percent == 0:
        return False, "its largest radius is zero"
    if settings.peripheral is None and settings.pinhole:
        return False, "its lens has no opening"
    reason = f"radius up to {settings.max_radius_percent:g} % of the image width"
    if settings.max_diameter_arcmin is not None:
        reason += f", diameter up to {settings.max_diameter_arcmin:g} arcmin"
    if settings.peripheral is not None:
        on_gaze = " centred on the gaze" if "peripheral" in condition.centred_on_gaze else ""
        reason += f", with peripheral blur{on_gaze}"
    if settings.distance_along == "ray":
        reason += ", by the distance along each ray"
    if settings.kernel == "mip_slices" and settings.slices_m:
        places = ", ".join(f"{place:g}" for place in settings.slices_m)
        reason = f"MIP levels on billboards {places} m away, whatever the focus"
    if settings.views > 1:
        reason = f"the scene is drawn in {settings.views} views through the lens of each eye"
    return True, reason


def build(inputs: EffectInputs) -> DepthOfFieldPass | None:
    """Build the blur of one view; None where many views need no blur."""
    of_one_view = blur_of_one_view(inputs.settings, inputs.size_px)
    if of_one_view is None:
        return None
    return DepthOfFieldPass(replace(inputs, settings=of_one_view))


class DepthOfFieldPass(EffectPass):
    """Blurs the image by its depth around the focus."""

    def __init__(self, inputs: EffectInputs) -> None:
        super().__init__(inputs)
        settings: DepthOfField = inputs.settings
        self._size_px = inputs.size_px
        self._slices_m = settings.slices_m if settings.kernel == "mip_slices" else None
        self._coc = CocPasses(inputs)
        self._near: NearThings | None = None
        self._warm_up: list[Callable[[], None]] = []
        self._kernel = self._kernel_with_near(inputs) or make_kernel(self._coc, settings)
        self.target = self._kernel.target

    def _kernel_with_near(self, inputs: EffectInputs) -> BlurKernel | None:
        """Return ours where near things are drawn apart, with `_near`; else None."""
        coc, settings = self._coc, inputs.settings
        layered = is_layered(settings)
        behind_px = BEHIND_PX if layered else half_gather.BEHIND_PX
        ours = settings.kernel == "vrcomfort" and settings.views == 1
        if not ours or inputs.scene is None or coc.max_radius_px <= behind_px:
            return None
        if layered:
            self._near = near = NearThings(inputs.ctx, coc, inputs.scene, CocTiles(coc), cuts=True)
            kernel = LayeredGatherKernel(coc, settings, near.cut, near.blurred)
            self._warm_up = [near.warm_up, kernel.warm_up]
            return kernel
        image = half_gather.HalfImage(coc)
        self._near = near = NearThings(inputs.ctx, coc, inputs.scene, image, cuts=False)
        self._warm_up = [near.warm_up]
        return half_gather.HalfGatherKernel(coc, image, near.blurred)

    @property
    def draws_behind(self) -> bool:
        """Return whether `colour` comes to hold what near things hide."""
        return self._near is not None

    def render(self, *eyes: EyeFrame) -> None:
        """Blur the images that eyes with these frusta, near planes and places in the head drew."""
        cameras = [eye.camera for eye in eyes]
        pixel_aspect = aspects([camera.fov for camera in cameras], self._size_px)
        self._coc.render(*cameras)
        if self._near is not None:
            self._near.draw_behind(pixel_aspect)
        self._kernel.render(pixel_aspect)
        if self._near is not None:
            self._near.draw_over()

    def adjust(self, condition: Condition, settings: DepthOfField) -> None:
        """Blur by other settings, and take another distance of the sky, from now on."""
        super().adjust(condition, settings)
        self._coc.adjust(settings, condition.focus.infinity_m)

    def leave_out_records(self) -> None:
        """Draw nothing from now on that only :meth:`clamps` needs: for measurements."""
        self._coc.tells_clamps = False

    def warm_up(self) -> None:
        """Draw once what frames without near things skip."""
        for draw in self._warm_up:
            draw()

    @property
    def max_radius_px(self) -> float:
        """Return the largest radius that the last eyes could have."""
        if self._slices_m:
            return 2.0 ** len(self._slices_m)  # of a disc as blurred as the last level
        return self._coc.max_radius_now_px

    def clamps(self) -> tuple[str, ...]:
        """Return how far the largest radius has cut blur off so far; waits for the GPU."""
        return () if self._slices_m else self._coc.clamps()

    def reset(self) -> None:
        """Count no frame so far among those that :meth:`clamps` tells of."""
        self._coc.reset()


EFFECT = RegisteredEffect("depth_of_field", decide, build, reads=frozenset({"depth", "focus"}))


LEAST_BLUR_PX = 0.75
"""Radius of a view's blur at one dioptre of defocus, which most of a room is within, below which
twelve views or more are closer to the reference without a blur: at 0.7 px (256 views at 320 px
width) by 2 dB in the temple. At 0.9 px (16 views) they are closer by 3 to 5 dB with focus at 1.5 m,
but farther by 6 dB at 0.5 m, where the temple is 1.5 dioptres out of focus and they stand apart."""


def part_of_one_view(settings: DepthOfField, size_px: tuple[int, int]) -> float:
    """Return the radius over which each view is blurred, in parts of the lens; 0 for not at all."""
    part = view_radius(settings.views, settings.over_blur)
    small = _at_one_dioptre_px(settings, part, size_px) < LEAST_BLUR_PX
    return 0.0 if small and settings.views >= FEW else part


def blur_of_one_view(settings: DepthOfField, size_px: tuple[int, int]) -> DepthOfField | None:
    """Return the settings by which one of the views is blurred; None where it is not.

    For one view they are these settings. The largest radius of a view is that of the lens, so that
    none is cut before the lens's is `1 / part` times as large.
    """
    if settings.views == 1:
        return settings
    part = part_of_one_view(settings, size_px)
    if not part:
        return None
    update = {
        "full_blur_dioptre": settings.full_blur_dioptre / part,
        "pupil_mm": part * settings.pupil_mm,
    }
    return settings.model_copy(update=update)


def _at_one_dioptre_px(settings: DepthOfField, part: float, size_px: tuple[int, int]) -> float:
    """Return the radius of a view's blur at one dioptre of defocus, by the law."""
    return part * radius_per_dioptre_px(settings, size_px)


SCALED_COPY = "depth_of_field/scaled_copy.frag"


class LensViews:
    """Averages views through points of a lens; the mean is `target`.

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
        view: AnyTexture,
        settings: DepthOfField,
        infinity_m: float,
    ) -> None:
        self.views = settings.views
        self._settings = settings
        self._infinity_m = infinity_m
        self._size_px = size_px = gl.size_px_of(view)
        self._points = view_points(settings.views, part_of_one_view(settings, size_px))
        # Of up to hundreds of half floats.
        total = gl.eye_texture(ctx, size_px, gl.layers_of(view), dtype="f4")
        self._summing = ctx.framebuffer([total])
        self._cleared = passes.clear([total])
        scaled = partial(FullscreenPass, ctx, SCALED_COPY, size_px=size_px, reach_px=0.0)
        self._add = scaled(
            inputs={"image": view}, constants={"share": 1.0}, target=total, blend=ADDED
        )
        self._average = scaled(inputs={"image": total}, constants={"share": 1 / settings.views})
        self.target = self._average.target

    def render(self, fovs: Sequence[Fov], draw: Callable[[Sequence[Lens]], None]) -> None:
        """Average the views of eyes with these frusta; `draw` fills the view's texture."""
        self._cleared.run(self._summing.clear)
        for points in zip(*map(self._lenses, fovs), strict=True):
            draw(points)
            self._add.render()
        self._average.render()

    def _lenses(self, fov: Fov) -> list[Lens]:
        focal_x, focal_y = focal_length_px(fov, self._size_px)
        # Round in angle, not in pixels. The focus is the scene pass's to fill in.
        return [
            lens(
                self._settings,
                (float(x), float(y) * focal_y / focal_x),
                focal_x,
                self._size_px,
                self._infinity_m,
                self._infinity_m,
            )
            for x, y in self._points
        ]
