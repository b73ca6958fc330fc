"""Depth of field of one eye: circular bokeh, one focus for both eyes."""

from __future__ import annotations

import moderngl

from vrcomfort.geometry import Fov, Pose, focal_length_px
from vrcomfort.protocol.conditions import DepthOfField, Focus
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses
from vrcomfort.render.effects.depth_of_field.kernels import make_kernel


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
        self._coc = CocPasses(
            ctx,
            colour=colour,
            depth=depth,
            focus=focus,
            settings=settings,
            size_px=size_px,
            infinity_m=infinity_m,
        )
        self._kernel = make_kernel(ctx, colour, self._coc, settings)
        self.target = self._kernel.target

    def render(self, *, fov: Fov, near_m: float, head_from_eye: Pose) -> None:
        """Blur the image that an eye with this frustum, near plane and place in the head drew."""
        focal_x, focal_y = focal_length_px(fov, self._size_px)
        self._coc.render(fov=fov, near_m=near_m, head_from_eye=head_from_eye)
        self._kernel.render(focal_y / focal_x)

    @property
    def limit_px(self) -> float:
        """Return the largest radius that the last eye could have."""
        return self._coc.limit_now_px

    def clamps(self) -> tuple[str, ...]:
        """Return what the largest radius has cut off so far, in words; waits for the GPU."""
        return self._coc.clamps()

    def forget(self) -> None:
        """Count no frame so far among those that :meth:`clamps` tells of."""
        self._coc.forget()
