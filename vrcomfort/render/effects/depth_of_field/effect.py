"""Depth of field of one eye: circular bokeh, one focus for both eyes."""

from __future__ import annotations

import moderngl

from vrcomfort.geometry import focal_length_px
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels import make_kernel
from vrcomfort.render.effects.depth_of_field.lens_views import blur_of_one_view
from vrcomfort.render.effects.effect import EffectInputs, EffectKind, EyeFrame
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.render.resolve import ResolvePass
from vrcomfort.scene.data import Scene


def plan(_: Scene, condition: Condition) -> PlannedPass:
    """Plan depth of field; r_max = 0 is the pinhole image, which needs no pass."""
    settings = condition.depth_of_field
    if settings is None:
        return PlannedPass("depth_of_field", False, "the condition has none")
    if settings.max_radius_percent == 0:
        return PlannedPass("depth_of_field", False, "its largest radius is zero")
    if settings.peripheral is None and settings.pinhole:
        return PlannedPass("depth_of_field", False, "its lens has no opening")
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
    return PlannedPass("depth_of_field", True, reason)


def build(inputs: EffectInputs) -> DepthOfFieldPass | None:
    """Build what blurs one view; None where many views need no blur."""
    of_one_view = blur_of_one_view(inputs.settings, inputs.size_px)
    if of_one_view is None:
        return None
    return DepthOfFieldPass(
        inputs.ctx,
        colour=inputs.colour,
        depth=inputs.depth,
        focus=inputs.reads["focus"],
        settings=of_one_view,
        size_px=inputs.size_px,
        infinity_m=inputs.condition.focus.infinity_m,
        resolve=inputs.resolve,
    )


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
    resolve
        What makes `colour`, where it can write radii beside it.
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
        resolve: ResolvePass | None = None,
    ) -> None:
        self._size_px = size_px
        self._slices_m = settings.slices_m if settings.kernel == "mip_slices" else None
        self._coc = CocPasses(
            ctx,
            colour=colour,
            depth=depth,
            focus=focus,
            settings=settings,
            size_px=size_px,
            infinity_m=infinity_m,
            resolve=resolve,
        )
        self._kernel = make_kernel(ctx, self._coc, settings)
        self.target = self._kernel.target

    def render(self, eye: EyeFrame) -> None:
        """Blur the image that an eye with this frustum, near plane and place in the head drew."""
        fov, near_m = eye.camera.fov, eye.camera.near_m
        focal_x, focal_y = focal_length_px(fov, self._size_px)
        self._coc.render(
            fov=fov,
            near_m=near_m,
            head_from_eye=eye.head_from_eye,
            peripheral_axis=eye.camera.peripheral_axis,
        )
        self._kernel.render(focal_y / focal_x)

    def adjust(self, settings: DepthOfField) -> None:
        """Blur by other settings from now on."""
        self._coc.adjust(settings)

    def leave_out_records(self) -> None:
        """Draw nothing from now on that only :meth:`clamps` needs: for measurements."""
        self._coc.tells_clamps = False

    def warm_up(self) -> None:
        """Draw nothing: every frame draws everything."""

    @property
    def limit_px(self) -> float:
        """Return the largest radius that the last eye could have."""
        if self._slices_m:
            return 2.0 ** len(self._slices_m)  # of a disc as blurred as the last level
        return self._coc.limit_now_px

    def clamps(self) -> tuple[str, ...]:
        """Return what the largest radius has cut off so far, in words; waits for the GPU."""
        return () if self._slices_m else self._coc.clamps()

    def forget(self) -> None:
        """Count no frame so far among those that :meth:`clamps` tells of."""
        self._coc.forget()


KIND = EffectKind("depth_of_field", plan, build, reads=frozenset({"focus"}))
