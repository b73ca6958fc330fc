"""What lies behind near things is drawn, and they over it.

One image does not know what a blurred foreground hides. Around its silhouettes the scene is drawn
again with one sample a pixel: what lies well behind. Where that is near as well, the scene is drawn
once more, without all that is near. That image is blurred as ever, and the discs of near things,
of both depths, are gathered by themselves and drawn over it. Where nothing is near, the GPU skips
all of it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import floor
from typing import Any, Protocol

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.gpu import gl, passes, shaders
from vrcomfort.gpu.conditional import ConditionalDraws
from vrcomfort.gpu.fullscreen_pass import OVER, FullscreenPass, max_reduction, of_each
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.gpu.visible_area import DRAWN
from vrcomfort.render.effects.depth_of_field.coc_passes import (
    CocPasses,
    Inputs,
    PixelAspect,
    each_level,
)
from vrcomfort.render.effects.depth_of_field.layered_gather import CutLamps, of_class, on_tiles
from vrcomfort.render.scene_pass import ScenePass

BEHIND_PX = shaders.constant("near.glsl", "BEHIND_PX")
"""Without wider discs nothing is drawn apart, unless `Looked` says otherwise."""

PIXELS_PX = shaders.constant("near.glsl", "PIXELS_PX")
"""What is near and blurred less is summed over pixels."""

SILHOUETTE = 3.0
"""Farther from a silhouette, in radii of its disc, a near thing is not drawn apart."""

_BEHIND = shaders.constant("tile_classes.glsl", "BEHIND")


class LookedThrough(Protocol):
    """Tiles in which near things are looked for."""

    behind_px: float
    """Nothing is drawn apart that is blurred less."""
    beside: int
    """How many tiles away a pixel may be near though its own tile is not."""
    has_classified: bool
    """Whether the last :meth:`look` did, where someone watches."""

    @property
    def tiles(self) -> AnyTexture:
        """As ``near_rows.frag`` reads them."""

    @property
    def reach(self) -> tuple[dict[str, AnyTexture], dict[str, Any]]:
        """Inputs and defines of ``include/tile_dilate.glsl``."""

    def look(self, classify: Callable[[], None]) -> None:
        """Find the tiles of the last eyes, and classify them where anything may be behind."""

    def again(self, classes: AnyTexture) -> list[Callable[[], None]]:
        """Return what finds tiles anew where what is behind was drawn; the first draws there."""


class CocTiles:
    """Those that depth and focus give: ``coc_tile_min_max.frag``."""

    behind_px, beside = BEHIND_PX, 0
    has_classified = True

    def __init__(self, coc: CocPasses) -> None:
        self._coc = coc
        self.tiles, self.reach = coc.tile_min_max, coc.reach

    def look(self, classify: Callable[[], None]) -> None:
        """Classify them: `CocPasses` has found them."""
        classify()

    def again(self, classes: AnyTexture) -> list[Callable[[], None]]:
        """Return what finds them by the image."""
        coc, colour = self._coc, self._coc.colour_and_coc
        found = coc.make_pass(
            "coc_tile_min_max",
            {"colour_and_coc": colour, "dilated": classes},
            texel_px=coc.tile_px,
            defines={
                **coc.level_defines,
                **of_class("BEHIND", 1, beside=1),
                "TILE": coc.tile_px,
                "FROM_ALPHA": 1,
            },
            target=self.tiles,
            reach_px={"colour_and_coc": 2.0, "dilated": DRAWN},
            **on_tiles(classes),
        )
        return [found.render]


class NearThings:
    """Draws what is behind near things into `scene.colour`, and near things over :attr:`blurred`.

    Parameters
    ----------
    scene
        What has drawn `coc`'s colours and depths; its depth and velocity stay those of near things.
    looked
        Where near things are looked for.
    cuts
        Whether :attr:`cut` is wanted.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        coc: CocPasses,
        scene: ScenePass,
        looked: LookedThrough,
        *,
        cuts: bool,
    ) -> None:
        self._ctx, self._coc, self._scene, self._looked = ctx, coc, scene, looked
        self._behind = {"BEHIND_PX": looked.behind_px} if looked.behind_px != BEHIND_PX else {}
        colour = coc.colour_and_coc
        self._tiles = self._tile_passes()
        self._classes = self._tiles[-1].target
        # Draws are skipped for both eyes or for none: of which anything is behind, tiles are told.
        self._most = (
            max_reduction(ctx, self._classes, value="a", texel_px=(coc.tile_px, coc.tile_px))
            if coc.eyes > 1
            else None
        )
        self._of_eye = {} if self._most is None else {"most": self._most.target}
        self._if_any = ConditionalDraws(ctx, self._any_behind)
        self._if_more = ConditionalDraws(ctx, self._any_more)
        behind_depth = gl.eye_depth(ctx, coc.size_px, coc.eyes)
        self._closed = gl.framebuffer(ctx, [], behind_depth)
        self._close = passes.clear([behind_depth])
        self._limit = self._limit_pass()
        nearest = gl.eye_texture(ctx, coc.size_px, coc.eyes, components=1, dtype="f4")
        self._open_next = self._open_pass(nearest, behind_depth, seen=coc.depth_to_coc.depth)
        self._open_last = self._open_pass(nearest, behind_depth)
        self.blurred = blurred = gl.eye_texture(ctx, coc.size_px, coc.eyes)
        """The image of the kernel, RGBA16F; free until it draws."""
        scene.prepare_behind(nearest, blurred, behind_depth)
        self._layers = self._layer_passes(blurred, behind_depth)
        self._pixels = (
            None if looked.behind_px >= PIXELS_PX else self._pixels_pass(blurred, behind_depth)
        )
        pixels: Inputs = {} if self._pixels is None else {"near_pixels": self._pixels.target}
        self._take = coc.depth_to_coc.make_pass(
            "depth_of_field/colour_and_coc.frag",
            size_px=coc.size_px,
            inputs={"colour": blurred, "depth": behind_depth, "dilated": self._classes},
            defines={
                "BEHIND_NEAR": 1,
                **coc.coverage,
                **of_class("BEHIND", coc.tile_px, beside=looked.beside),
            },
            target=colour,
            reach_px={"colour": DRAWN, "depth": DRAWN, "dilated": DRAWN},
            **on_tiles(self._classes),
        )
        self._again = looked.again(self._classes)
        self._gather = self._gather_pass()
        self.cut: CutLamps | None = None
        """What the kernel cuts the discs of lamps behind the focus by."""
        if cuts:
            self._lamps, cut_tiles = self._lamp_passes()
            self._cut_tiles, tiles = cut_tiles, cut_tiles.target
            self._uncut = gl.framebuffer(ctx, [tiles])
            self._clear_cut = passes.clear([tiles])
            finest = self._layers[0].targets
            read = {
                "near": self._gather.target,
                **pixels,
                "near_light": finest[0],
                "near_radius": finest[2],
            }
            self.cut = CutLamps(tiles, read, self._if_any)
        self._over = coc.make_pass(
            "near_over",
            {"near": self._gather.target, **pixels, "dilated": self._classes, **self._of_eye},
            defines={
                **({"WITH_PIXELS": 1} if pixels else {}),
                **of_class("NEAR", coc.tile_px, beside=0),
                **self._near(),
            },
            target=blurred,
            blend=OVER,
            # What is blurred knows what is behind as far as its own discs and tiles come.
            reach_px={"near": 2.0, "near_pixels": 0.0, "dilated": coc.disc_px + 4.0 * coc.tile_px},
            **on_tiles(self._classes),
        )

    def draw_behind(self, pixel_aspect: PixelAspect) -> None:
        """Draw what is behind the near things of the last eyes, whose radii are known."""
        self._looked.look(partial(self._classify, pixel_aspect))
        self._if_any.run(self._draw_next, pixel_aspect)
        self._if_more.run(self._draw_last)
        self._if_any.run(self._find_again)
        if self.cut is not None:
            self._clear_cut.run(self._uncut.clear)
        self._if_any.run(self._draw_near, pixel_aspect)

    def draw_over(self) -> None:
        """Draw near things over the blurred image."""
        self._if_any.run(self._over.render)

    def warm_up(self) -> None:
        """Draw once what frames without near things skip."""
        square = of_each([1.0] * self._coc.eyes)
        self._draw_next(square)
        self._draw_last()
        self._find_again()
        self._draw_near(square)
        self._over.render()

    def _classify(self, pixel_aspect: PixelAspect) -> None:
        for each in self._tiles:
            each.render(pixel_aspect_of_eye=pixel_aspect)
        self._if_any.ask(self._again[0])

    def _find_again(self) -> None:
        for each in self._again:
            each()

    def _any_behind(self) -> bool:
        return self._looked.has_classified and bool(self._is_behind().any())

    def _any_more(self) -> bool:
        """Whether something near is behind something near."""
        if not self._any_behind():
            return False
        coc, colour, tile_px = self._coc, self._coc.colour_and_coc, self._coc.tile_px
        width, height = coc.size_px
        radii = np.frombuffer(colour.read(), np.float16)[3::4].reshape(-1, height, width)
        behind = self._is_behind().repeat(tile_px, axis=1).repeat(tile_px, axis=2)
        return bool((radii[behind[:, :height, :width]] <= -self._looked.behind_px).any())

    def _is_behind(self) -> NDArray[np.bool_]:
        columns, rows = gl.size_px_of(self._classes)
        classes = np.frombuffer(self._classes.read(), np.float16)[3::4]
        return np.equal(classes.reshape(-1, rows, columns), _BEHIND)

    def _draw_next(self, pixel_aspect: PixelAspect) -> None:
        if self._most is not None:
            self._most.render()
        self._limit.render()
        self._close.run(self._closed.clear, depth=1.0)
        self._open_next.render()
        self._scene.draw_behind()
        for each in self._layers:
            each.render()
        if self._pixels is not None:
            self._pixels.render(pixel_aspect_of_eye=pixel_aspect)
        self._take.render()
        self._close.run(self._closed.clear, depth=1.0)
        self._if_more.ask(self._open_last.render)

    def _draw_last(self) -> None:
        self._scene.draw_behind()
        self._take.render()

    def _draw_near(self, pixel_aspect: PixelAspect) -> None:
        self._gather.render(pixel_aspect_of_eye=pixel_aspect)
        if self.cut is not None:
            self._lamps.render()
            self._cut_tiles.render(pixel_aspect_of_eye=pixel_aspect)

    def _open_pass(
        self,
        nearest: AnyTexture,
        depth: AnyTexture,
        *,
        seen: AnyTexture | None = None,
    ) -> FullscreenPass:
        """Return the pass that opens `depth` for what is not near; or well behind depths `seen`."""
        coc = self._coc
        inputs: dict[str, AnyTexture] = {
            "colour_and_coc": coc.colour_and_coc,
            "limit": self._limit.target,
        }
        defines = {**self._behind, "TILE": coc.tile_px}
        defines |= of_class("BEHIND", coc.tile_px, beside=self._looked.beside)
        if seen is not None:
            inputs["depth"], defines["NEXT"] = seen, 1
        return coc.make_pass(
            "near_depth",
            {**inputs, "dilated": self._classes},
            defines=defines,
            target=nearest,
            depth=depth,
            reach_px={
                "colour_and_coc": 0.0,
                "depth": 0.0,
                "limit": coc.tile_px,
                "dilated": DRAWN,
            },
            **on_tiles(self._classes),
        )

    def _tile_passes(self) -> tuple[FullscreenPass, FullscreenPass]:
        coc, (inputs, defines) = self._coc, self._looked.reach
        # Nothing is drawn apart from here on (near_tiles.frag); what is as far is not looked at.
        away_tiles = floor(SILHOUETTE * coc.max_radius_px / coc.tile_px) + 4
        away = {**coc.level_defines, **defines, **self._behind, "AWAY": float(away_tiles)}
        reach_px = float((away_tiles - 1) * coc.tile_px)
        tiles = {"tiles": self._looked.tiles, **inputs}
        rows = coc.make_pass(
            "near_rows",
            tiles,
            texel_px=coc.tile_px,
            defines=away,
            reach_px={"tiles": reach_px},
        )
        found = coc.make_pass(
            "near_tiles",
            {**tiles, "rows": rows.target},
            texel_px=coc.tile_px,
            defines=away,
            reach_px={"tiles": 0.0, "rows": reach_px},
        )
        return rows, found

    def _limit_pass(self) -> FullscreenPass:
        coc, radii = self._coc, self._coc.depth_to_coc
        columns, rows = gl.size_px_of(self._classes)
        size_px = columns + 1, rows + 1
        made = FullscreenPass(
            self._ctx,
            "depth_of_field/near_limit.frag",
            size_px=size_px,
            inputs=radii.inputs,
            constants={"size_px": coc.size_px},
            defines={**radii.defines, **self._behind, "TILE": coc.tile_px},
            target=gl.eye_texture(self._ctx, size_px, coc.eyes, components=1, dtype="f4"),
        )
        made.target.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return made

    def _layer_passes(
        self, next_colour: AnyTexture, next_depth: AnyTexture
    ) -> list[FullscreenPass]:
        coc = self._coc
        inputs: Inputs = {
            "finer": coc.colour_and_coc,
            "next": next_colour,
            "next_depth": next_depth,
            **coc.depth_to_coc.inputs,
        }
        defines = {
            **coc.depth_to_coc.defines,
            **coc.coverage,
            **self._behind,
            "FROM_PIXELS": 1,
        }
        found: list[FullscreenPass] = []
        for level in range(1, max(int(coc.level_defines["LEVELS"]), 2)):
            if found:
                *light, radius = found[-1].targets
                inputs, defines = {"light": light, "radius": radius}, self._behind
            found.append(
                coc.make_pass(
                    "near_layer",
                    inputs,
                    texel_px=2**level,
                    defines=defines,
                    more_components=(4, 2),
                    # What is drawn behind is there wherever it is wanted.
                    reach_px={**dict.fromkeys(inputs, 0.0), "next": DRAWN, "next_depth": DRAWN},
                )
            )
        return found

    def _lamp_passes(self) -> tuple[FullscreenPass, FullscreenPass]:
        coc, (inputs, defines) = self._coc, self._coc.reach
        lamps = coc.make_pass(
            "lamp_tiles",
            {"colour_and_coc": coc.colour_and_coc, "tiles": coc.tile_min_max},
            texel_px=coc.tile_px,
            components=1,
            defines={"TILE": coc.tile_px},
            reach_px=0.0,
        )
        cut = coc.make_pass(
            "cut_tiles",
            {"lamps": lamps.target, "dilated": self._classes, **inputs, **self._of_eye},
            texel_px=coc.tile_px,
            components=1,
            defines={
                **of_class("NEAR", 1, beside=0),
                **self._near(),
                **defines,
                "COARSEST_PX": coc.disc_px - coc.max_radius_px,
            },
            reach_px={"lamps": coc.disc_px, "dilated": 0.0},
            **on_tiles(self._classes),
        )
        return lamps, cut

    def _near(self) -> dict[str, Any]:
        """Return the defines of tiles that near discs come to, in eyes with anything behind."""
        return {"UP_TO": "BEHIND", **({"IF_ANY": "BEHIND"} if self._of_eye else {})}

    def _pixels_pass(self, next_colour: AnyTexture, next_depth: AnyTexture) -> FullscreenPass:
        coc = self._coc
        return coc.make_pass(
            "near_pixels",
            {
                "colour_and_coc": coc.colour_and_coc,
                "next": next_colour,
                "next_depth": next_depth,
                "dilated": self._classes,
            },
            defines={
                **coc.coverage,
                **of_class("NEAR", coc.tile_px, beside=0),
                **self._near(),
            },
            reach_px={
                "colour_and_coc": PIXELS_PX + 1.0,
                "next": DRAWN,
                "next_depth": DRAWN,
                "dilated": 0.0,
            },
            **on_tiles(self._classes),
        )

    def _gather_pass(self) -> FullscreenPass:
        coc = self._coc
        names = "light", "light_2", "radius"
        images = zip(*(each.targets for each in self._layers), strict=True)
        levels = dict(zip(names, images, strict=True))
        return coc.make_pass(
            "near_gather",
            {**levels, "dilated": self._classes, **self._of_eye},
            texel_px=2,
            defines={
                **coc.level_defines,
                "NEAR_LEVELS": len(self._layers),
                "EACH_NEAR_LEVEL(f)": each_level(1, len(self._layers) + 1),
                **self._behind,
                **of_class("NEAR", coc.tile_px // 2, beside=1),
                **self._near(),
            },
            reach_px={**dict.fromkeys(levels, coc.disc_px), "dilated": coc.tile_px},
            **on_tiles(self._classes),
        )
