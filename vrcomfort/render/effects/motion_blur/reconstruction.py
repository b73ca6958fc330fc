"""Motion blur that knows who hides whom: along each pixel's streak, and over what passes it."""

from __future__ import annotations

from collections.abc import Iterator
from types import MappingProxyType
from typing import NamedTuple

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.shaders import Defines
from vrcomfort.optics.motion import sampling_of
from vrcomfort.render.effects.motion_blur.shutter import Shutter
from vrcomfort.render.effects.motion_blur.tile_max import TileMaxPass


class _Limit(NamedTuple):
    radius_limit_px: float


class Reconstruction:
    """Averages along each pixel's own streak; looks who hides whom where things pass each other.

    Parameters
    ----------
    colour, depth, velocity
        Linear HDR RGBA16F, reverse-Z D32F and RG16F (px per frame, +x right, +y up).
    samples
        As in ``MotionBlur.samples``.
    limit_px
        No half streak is longer.

    Notes
    -----
    Each frame is averaged in one step or in two, for how long its longest streak is, and is looked
    at for what passes where its streaks jump: the vertex shaders decide, so that the CPU need not
    know. ``docs/motion_blur.md`` has the graph of passes.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        velocity: moderngl.Texture,
        samples: int,
        limit_px: float,
    ) -> None:
        self._ctx, self._colour, self._velocity = ctx, colour, velocity
        self._sampling = sampling = sampling_of(samples, colour.width)
        self._tile_max = TileMaxPass(ctx, velocity=velocity, limit_px=limit_px, jump=sampling.jump)
        self._dilate = _dilation(ctx, self._tile_max, limit_px, sampling.jump)
        self.target = gl.color_texture(ctx, colour.size)
        self._averages = tuple(self._one_step() if sampling.taps == 1 else self._one_step_or_two())
        self._foreground = self._mixed_tiles(depth)

    def _one_step(self) -> Iterator[FullscreenPass]:
        yield self._average("motion_blur", self._colour, self.target, "common/fullscreen.vert")

    def _one_step_or_two(self) -> Iterator[FullscreenPass]:
        by_frame = "motion_blur/frame_of_streaks.vert"
        average = self._average("streak_average", self._colour, None, by_frame, {"LONG": 1})
        yield average
        yield self._average("motion_blur_long", average.target, self.target, by_frame, {"LONG": 1})
        yield self._average("motion_blur", self._colour, self.target, by_frame)

    def _average(
        self,
        name: str,
        source: moderngl.Texture,
        target: moderngl.Texture | None,
        vertex: str,
        frames: Defines = MappingProxyType({}),
    ) -> FullscreenPass:
        """Return a pass over the whole image, in all frames or in those that `vertex` draws."""
        sampling = self._sampling
        inputs = {"velocity": self._velocity, "source": source}
        defines: dict[str, int | float | str] = {"CUBIC": 1} if sampling.cubic else {}
        defines |= {"TAPS": sampling.taps, "PARTS": sampling.parts, "PAIRS": sampling.pairs}
        if sampling.taps > 1:
            inputs["frame"] = self._tile_max.frame.target
            defines["ONE_STEP_PX"] = sampling.one_step_px
        return FullscreenPass(
            self._ctx,
            f"motion_blur/{name}.frag",
            size_px=self._colour.size,
            inputs=inputs,
            filtered={"source"},
            defines={**defines, **frames},
            vertex=vertex,
            target=target,
        )

    def _mixed_tiles(self, depth: moderngl.Texture) -> FullscreenPass:
        longest, crossing = self._dilate.targets
        tile_px = self._tile_max.tile_px
        return FullscreenPass(
            self._ctx,
            "motion_blur/motion_blur_foreground.frag",
            size_px=self._colour.size,
            inputs={
                "colour": self._colour,
                "velocity": self._velocity,
                "depth": depth,
                "longest": longest,
                "crossing": crossing,
                "frame": self._tile_max.frame.target,
            },
            filtered={"colour"},
            defines={
                "JUMP": self._sampling.jump,
                "TILE": tile_px,
                "POINT_PX": tile_px,
                "CLASS": "MIXED",
                "STRIDE": self._sampling.stride_px,
                "MOST_TAPS": self._sampling.most_taps,
            },
            vertex="motion_blur/motion_tiles_of_class.vert",
            tiles=longest.size,
            target=self.target,
        )

    @property
    def tiles(self) -> tuple[moderngl.Texture, moderngl.Texture]:
        """Return what reaches each tile and its class, and what crosses it.

        Of the last frame in which things may have passed each other.
        """
        longest, crossing = self._dilate.targets
        return longest, crossing

    def render(self, shutter: Shutter) -> None:
        """Blur along the present streaks."""
        self._tile_max.render(shutter.shutter_fraction)
        self._dilate.render()
        for each in self._averages:
            each.render(shutter)
        self._foreground.render(shutter)

    def longest_half_velocity_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU."""
        return self._tile_max.frame.longest_of_all_px()


def _dilation(
    ctx: moderngl.Context, tile_max: TileMaxPass, limit_px: float, jump: float
) -> FullscreenPass:
    return FullscreenPass(
        ctx,
        "motion_blur/tile_max_dilate.frag",
        size_px=tile_max.target.size,
        inputs={
            "tile_max": tile_max.target,
            "tile_max_crossing": tile_max.crossing,
            "frame": tile_max.frame.target,
        },
        more_components=(2,),
        constants=_Limit(limit_px),
        defines={"TILE": tile_max.tile_px, "JUMP": jump, "PASSING": 1},
        vertex="motion_blur/frame_of_streaks.vert",
    )
