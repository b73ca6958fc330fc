"""Motion blur that knows who hides whom: along each pixel's streak, and over what passes it."""

from __future__ import annotations

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
        average = None if sampling.taps == 1 else self._average("streak_average", colour, None)
        in_parts = colour if average is None else average.target
        self._averages = (
            *(() if average is None else (average,)),
            self._average("motion_blur_long", in_parts, self.target),
            self._average("motion_blur", colour, self.target, {"PAIRS": sampling.pairs}),
        )
        self._foreground = self._mixed_tiles(depth)

    def _average(
        self,
        name: str,
        source: moderngl.Texture,
        target: moderngl.Texture | None,
        short: Defines | None = None,
    ) -> FullscreenPass:
        """Return a pass over the whole image: in frames with long streaks, or in `short` ones."""
        sampling = self._sampling
        steps = {"LONG": 1, "TAPS": sampling.taps, "PARTS": sampling.parts}
        return FullscreenPass(
            self._ctx,
            f"motion_blur/{name}.frag",
            size_px=self._colour.size,
            inputs={
                "frame": self._tile_max.frame.target,
                "velocity": self._velocity,
                "source": source,
            },
            filtered={"source"},
            defines={
                "ONE_STEP_PX": sampling.one_step_px,
                **(steps if short is None else short),
                **({"CUBIC": 1} if sampling.cubic else {}),
            },
            vertex="motion_blur/frame_of_streaks.vert",
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
