"""Very wide blur, drawn on texels of 4, 8 and 16 px, as far as the limit of discs asks for them."""

from __future__ import annotations

from typing import Any

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.gather_resolution import COARSEST_TEXEL_PX, coarser_above_px
from vrcomfort.render.effects.depth_of_field.circle_of_confusion import Defocus
from vrcomfort.render.effects.depth_of_field.kernels.base import Aspect
from vrcomfort.render.effects.depth_of_field.kernels.tile_passes import (
    Level,
    TilePasses,
    make_level,
    make_reach_pass,
)
from vrcomfort.render.effects.depth_of_field.kernels.tiles import READ_AROUND_PX


def read_around_px(limit_px: float, rings: int) -> int:
    """Return how much farther than discs reach their points may be read.

    Of texels a texel farther away, every texel that the disc covers: each is made of those around.
    """
    texel_px = 2
    while _needs_wider(limit_px, rings, texel_px):
        texel_px *= 2
    return 3 * texel_px if texel_px > 2 else READ_AROUND_PX


def far_layers(
    ctx: moderngl.Context,
    defocus: Defocus,
    finer: Level,
    inputs: dict[str, moderngl.Texture],
    defines: dict[str, Any],
) -> FarLayers | None:
    """Return what draws the discs that are too wide for texels like those of `finer`, if any are.

    The parameters are those of :class:`FarLayers`.
    """
    if not _needs_wider(defocus.limit_px, defines["RINGS"], finer.texel_px):
        return None
    return FarLayers(ctx, defocus, finer, inputs, defines)


class FarLayers:
    """Draws very wide discs on texels twice as wide as those of `finer` (:func:`coarser_above_px`).

    Parameters
    ----------
    finer
        Colours and signed radii.
    inputs
        The same of all pixels (`points`), and what may reach each tile (`reach`).
    defines
        `RINGS` and `SMALL_PX`.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        defocus: Defocus,
        finer: Level,
        inputs: dict[str, moderngl.Texture],
        defines: dict[str, Any],
    ) -> None:
        self.texel_px = texel_px = 2 * finer.texel_px
        rings = defines["RINGS"]
        self.above_px = coarser_above_px(rings, finer.texel_px)
        """Discs are drawn here from this radius on."""
        self._kinds = make_reach_pass(
            ctx,
            defocus,
            "depth_of_field/far_kinds.frag",
            {"reach": inputs["reach"]},
            margin_px=2 * texel_px,
            defines={"FAR_PX": self.above_px},
            components=1,
        )
        self.kinds = self._kinds.target
        """`HALVES` and `LAYERS` of ``include/kinds.glsl``."""
        self._tiles = TilePasses(ctx, defocus, self.kinds)
        here, fronts, self._back, self._front = (
            make_level(ctx, defocus, texel_px, "f4") for _ in range(4)
        )
        self._coarser = far_layers(ctx, defocus, here, inputs, defines)
        self._defines = {**defines, "LEVEL": texel_px}
        halves, points = {"points": finer.texture}, {"points": inputs["points"]}
        self._halves = [
            self._tiles.make_pass("depth_of_field/defocus_half.frag", "HALVES", halves, here),
            self._tiles.make_pass(
                "depth_of_field/defocus_fronts.frag",
                "HALVES",
                points,
                fronts,
                defines=self._defines,
            ),
        ]
        self._here, self._fronts = here.texture, fronts.texture
        seen = {"points_far": here.texture}
        in_front = {**seen, "fronts_far": fronts.texture, "reach": inputs["reach"]}
        self._layers = [self._layer(seen, self._back), self._layer(in_front, self._front, FRONT=1)]

    def render(self, pixel_aspect: float) -> None:
        """Draw both layers."""
        self._kinds.render(Aspect(pixel_aspect))
        for each in self._halves:
            each.render()
        if self._coarser is not None:
            self._coarser.render(pixel_aspect)
        for layer in self._layers:
            layer.render(Aspect(pixel_aspect))

    def layers(self, *, front: bool) -> dict[str, moderngl.Texture]:
        """Return what ``wide_layers.glsl`` reads: the back, with `front` both layers."""
        back = {"wide_back": self._back.texture}
        return {**back, "wide_front": self._front.texture} if front else back

    def points(self, *, front: bool) -> dict[str, moderngl.Texture]:
        """Return what ``far_sum.glsl`` reads for one of the layers."""
        return {"fronts_far": self._fronts} if front else {"points_far": self._here}

    def _layer(
        self, inputs: dict[str, moderngl.Texture], target: Level, **defines: Any
    ) -> FullscreenPass:
        wider, limit = read_wider(self._coarser, front="FRONT" in defines)
        defines = {**self._defines, **defines, **limit}
        return self._tiles.make_pass(
            "depth_of_field/defocus_far.frag",
            "LAYERS",
            {**inputs, **wider},
            target,
            defines=defines,
        )


def read_wider(
    wider: FarLayers | None, *, front: bool
) -> tuple[dict[str, moderngl.Texture], dict[str, float]]:
    """Return the inputs and defines with which a layer reads one of wider texels, if there are."""
    if wider is None:
        return {}, {}
    return wider.layers(front=front), {"FAR_PX": wider.above_px}


def _needs_wider(limit_px: float, rings: int, texel_px: int) -> bool:
    return texel_px < COARSEST_TEXEL_PX and limit_px > coarser_above_px(rings, texel_px)
