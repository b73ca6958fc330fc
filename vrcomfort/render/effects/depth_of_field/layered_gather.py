"""Our kernel of depth of field, and the interface of all kernels."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from vrcomfort.gpu import gl
from vrcomfort.gpu.conditional import ConditionalDraws
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, of_each
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.optics import blur_kernels
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.effects.depth_of_field.coc_passes import CocPasses, Inputs, PixelAspect


class BlurKernel(Protocol):
    """Spreads each point over its disc.

    It is made of a `CocPasses`, whose `colour_and_coc` holds the image (linear HDR) with the signed
    radius of each pixel.
    """

    @property
    def target(self) -> AnyTexture:
        """The blurred image, RGBA16F of the same size."""

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the present points."""


class CutLamps(NamedTuple):
    """What cuts the discs of lamps behind the focus: something near.

    Parameters
    ----------
    tiles
        Where that is so: ``cut_tiles.frag``.
    inputs
        What ``complex.frag`` reads of near things.
    if_near
        Without anything near no tile is drawn.
    """

    tiles: AnyTexture
    inputs: Inputs
    if_near: ConditionalDraws


def is_layered(settings: DepthOfField) -> bool:
    """Return whether these settings want a :class:`LayeredGatherKernel`."""
    return settings.kernel == "vrcomfort" and settings.samples != blur_kernels.HALF_GATHER_SAMPLES


class LayeredGatherKernel:
    """Classifies tiles, makes coarser mips, draws each class of tiles: docs/depth_of_field.md.

    Every texel of a disc is summed, on the mip on which there are not too many.

    Notes
    -----
    Where no disc can be too wide to be summed over pixels, there are no coarser mips.
    """

    def __init__(
        self,
        coc: CocPasses,
        settings: DepthOfField,
        cut: CutLamps | None = None,
        target: AnyTexture | None = None,
    ) -> None:
        self._coc, self._cut = coc, cut
        self._defines = coc.level_defines
        self._points = {"colour_and_coc": coc.colour_and_coc}
        self._dilate = self._dilate_pass()
        self._layers = self._layer_passes()
        layers: Inputs = {"layers": [each.target for each in self._layers]} if self._layers else {}
        self.target = target or gl.eye_texture(coc.ctx, coc.size_px, coc.eyes)
        # A shader for each class, which reads only what the class needs.
        self._composite = [self._tiles("IN_FOCUS", "in_focus"), self._tiles("FAST", "fast")]
        coarser = {"COARSER_BEHIND": int(blur_kernels.coarser_behind(settings.samples))}
        self._composite.append(self._tiles("COMPLEX", "complex", layers, defines=coarser))
        self._composite_cut: FullscreenPass | None = None
        if cut is not None:
            read: Inputs = {**layers, **cut.inputs, "cut": cut.tiles}
            defines = {**coarser, "WITH_CUT": 1}
            self._composite_cut = self._tiles("CUT", "complex", read, defines)
        self._gather: FullscreenPass | None = None
        if self._layers:
            self._gather = self._gather_pass(layers)
            gathered = {"gathered": self._gather.target}
            wide = {"WITH_HALF_RESOLUTION": 1}
            self._composite.append(
                self._tiles("FAST_HALF_RESOLUTION", "fast", gathered, wide, filtered={"gathered"})
            )

    def render(self, pixel_aspect: PixelAspect) -> None:
        """Blur the image of the last eye."""
        self._dilate.render(pixel_aspect_of_eye=pixel_aspect)
        for layer in self._layers:
            layer.render()
        if self._gather is not None:
            self._gather.render(pixel_aspect_of_eye=pixel_aspect)
        sharp, *others = self._composite
        sharp.render()
        for each in others:
            each.render(pixel_aspect_of_eye=pixel_aspect)
        if self._cut is not None:
            self._cut.if_near.run(self._draw_cut, pixel_aspect)

    def warm_up(self) -> None:
        """Draw once what frames without near things skip."""
        self._draw_cut(of_each([1.0] * self._coc.eyes))

    def _draw_cut(self, pixel_aspect: PixelAspect) -> None:
        if self._composite_cut is not None:
            self._composite_cut.render(pixel_aspect_of_eye=pixel_aspect)

    def _dilate_pass(self) -> FullscreenPass:
        tiles, (inputs, defines) = self._coc.tile_min_max, self._coc.reach
        if self._cut is not None:
            inputs, defines = {**inputs, "cut": self._cut.tiles}, {**defines, "WITH_CUT": 1}
        return self._coc.make_pass(
            "coc_tile_dilate",
            {"tiles": tiles, **inputs},
            texel_px=self._coc.tile_px,
            defines={**self._defines, **defines},
            # Tiles that it touches count whole.
            reach_px={"tiles": self._coc.max_radius_px + 2, "cut": 0.0},
        )

    def _layer_passes(self) -> list[FullscreenPass]:
        found: list[FullscreenPass] = []
        for level in range(1, int(self._defines["LEVELS"])):
            finer = found[-1].target if found else self._coc.colour_and_coc
            # Eight half floats in a texel: light and radius of a foreground and of a background.
            found.append(
                self._coc.make_pass(
                    "layers",
                    {"finer": finer},
                    texel_px=2**level,
                    dtype="u4",
                    defines={"FROM_LAYERS": 1} if found else {},
                    reach_px=0.0,
                )
            )
        return found

    def _gather_pass(self, layers: Inputs) -> FullscreenPass:
        """Return the pass that sums wide discs, in tiles of that class and beside them."""
        return self._coc.make_pass(
            "gather",
            {**layers, "dilated": self._dilate.target},
            texel_px=2,
            defines={
                **self._defines,
                **of_class("FAST_HALF_RESOLUTION", self._coc.tile_px // 2, beside=1),
            },
            reach_px={
                "layers": self._coc.disc_px,
                "dilated": self._coc.tile_px,
            },
            **on_tiles(self._dilate.target),
        )

    def _tiles(
        self,
        name: str,
        fragment: str,
        inputs: Inputs | None = None,
        defines: dict[str, int] | None = None,
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass that draws the tiles of a class."""
        class_defines = of_class(name, self._coc.tile_px, beside=0)
        read = {**self._points, **(inputs or {})}
        # What was gathered is read between its texels.
        reach_px = dict.fromkeys(read, self._coc.disc_px) | {"dilated": 0.0, "gathered": 2.0}
        return self._coc.make_pass(
            fragment,
            {**read, "dilated": self._dilate.target},
            target=self.target,
            defines={**self._defines, **class_defines, **(defines or {})},
            reach_px=reach_px,
            **on_tiles(self._dilate.target),
            **options,
        )


def on_tiles(classes: AnyTexture) -> dict[str, Any]:
    """Return the options of a pass that is drawn on tiles of a class."""
    return {"vertex": "depth_of_field/tiles_of_class.vert", "tiles": gl.size_px_of(classes)}


def of_class(name: str, point_px: int, *, beside: int) -> dict[str, Any]:
    """Return the defines of ``tiles_of_class.vert``."""
    return {"CLASS": name, "POINT_PX": point_px, "BESIDE": beside}
