"""Motion blur of one eye from a velocity buffer (McGuire et al. 2012, Guertin et al. 2013)."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl

from vrcomfort.optics.motion import ramp
from vrcomfort.protocol.conditions import MotionBlur
from vrcomfort.render import gl, shaders
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.head_step import HeadStep
from vrcomfort.render.streaks import Streaks

STREAK_OF_SAMPLES_PX = 16.0
"""Length of streak that takes ``MotionBlur.samples`` samples."""


class _Limit(NamedTuple):
    radius_limit_px: float


class _Sampling(NamedTuple):
    px_per_sample: int


def streak_scale(settings: MotionBlur, step: HeadStep | None) -> float:
    """Return what all streaks are multiplied by, for how fast the head turns: 1 to 0."""
    fade = settings.fade_with_turning
    if fade is None or step is None:
        return 1.0
    return 1 - ramp(step.turn_deg_s("head"), fade.from_deg_s, fade.to_deg_s)


class MotionBlurPass:
    """Smears `colour` along `velocity` for as long as the shutter is open; the result is `target`.

    Parameters
    ----------
    colour, depth, velocity
        Linear HDR RGBA16F, reverse-Z D32F and RG16F (px per frame, +x right, +y up).

    Notes
    -----
    The limit on half streaks alters what is seen. :meth:`longest_half_streak_px` says how long
    they would have been; what lies above ``limit_px`` was shortened.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        velocity: moderngl.Texture,
        settings: MotionBlur,
        size_px: tuple[int, int],
    ) -> None:
        self._settings, self._colour = settings, colour
        self._streaks = Streaks(
            ctx, depth=depth, velocity=velocity, settings=settings, size_px=size_px
        )
        self.limit_px = self._streaks.limit_px
        make = _Reconstruction if settings.method == "reconstruction" else _per_pixel
        self._gather = make(ctx, colour, self._streaks, settings)
        self._copy = gl.copier(ctx)
        self.target = self._gather.target

    def render(self, *, still: bool = False, step: HeadStep | None = None) -> None:
        """Blur the present image.

        Parameters
        ----------
        still
            Nothing has moved since the frame before: the image is copied, bit by bit.
        step
            How the head got here, None after a cut.
        """
        scale = streak_scale(self._settings, step)
        if still or scale == 0:
            self._copy(self._colour, self.target)
            return
        self._draw(scale)

    def warm_up(self) -> None:
        """Draw everything once, which frames in which nothing moves leave out."""
        self._draw(0.0)

    def _draw(self, scale: float) -> None:
        self._streaks.render(scale)
        self._gather.render()

    def longest_half_streak_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU."""
        return self._streaks.longest_px()

    def clamps(self) -> tuple[str, ...]:
        """Return what the limit has done to the frames so far, in words; waits for the GPU."""
        longest_px = self.longest_half_streak_px()
        if longest_px <= self.limit_px:
            return ()
        return (
            f"motion blur: half streaks of up to {longest_px:.1f} px were shortened to "
            f"{self.limit_px:.1f} px",
        )


class _Reconstruction:
    """Copies the image, then draws over the tiles in which something is seen to move."""

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        streaks: Streaks,
        settings: MotionBlur,
    ) -> None:
        self._colour, self._copy = colour, gl.copier(ctx)
        tile: dict[str, int | float | str] = {"TILE": streaks.tile_px}
        kinds: tuple[shaders.Defines, ...] = ({"KIND": "ALIKE", "ONLY_ALIKE": 1}, {"KIND": "MIXED"})
        self._neighbours = FullscreenPass(
            ctx,
            "streak_neighbours.frag",
            size_px=streaks.tiles.size,
            inputs={"tiles": streaks.tiles},
            constants=_Limit(streaks.limit_px),
            defines=tile | {"REACH": ceil(streaks.limit_px / streaks.tile_px) + 1},
        )
        longest = self._neighbours.target
        self.target = gl.color_texture(ctx, colour.size)
        self._gathers = tuple(
            FullscreenPass(
                ctx,
                "motion_blur.frag",
                size_px=colour.size,
                inputs={"colour": colour, "streaks": streaks.points, "longest": longest},
                filtered={"colour"},
                constants=_Sampling(max(1, round(STREAK_OF_SAMPLES_PX / settings.samples))),
                defines={**tile, **kind},
                vertex="streak_tiles.vert",
                vertices=6 * longest.width * longest.height,
                target=self.target,
            )
            for kind in kinds
        )

    def render(self) -> None:
        """Blur along the present streaks."""
        self._neighbours.render()
        self._copy(self._colour, self.target)
        for gather in self._gathers:
            gather.render()


def _per_pixel(
    ctx: moderngl.Context, colour: moderngl.Texture, streaks: Streaks, settings: MotionBlur
) -> FullscreenPass:
    return FullscreenPass(
        ctx,
        "motion_blur_per_pixel.frag",
        size_px=colour.size,
        inputs={"colour": colour, "streaks": streaks.points},
        filtered={"colour"},
        defines={"SAMPLES": settings.samples},
    )
