"""Motion blur of one eye from a velocity buffer (McGuire et al. 2012, Guertin et al. 2013)."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl

from vrcomfort.protocol.conditions import MotionBlur
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.peak import PeakPass

STREAK_OF_SAMPLES_PX = 16.0
"""Length of streak that takes ``MotionBlur.samples`` samples."""


class _Shutter(NamedTuple):
    shutter_fraction: float
    radius_limit_px: float


class _Sampling(NamedTuple):
    samples_per_px: float


def streak_limit_px(settings: MotionBlur, size_px: tuple[int, int]) -> float:
    """Return the longest half streak that `settings` allow at this image size."""
    return settings.max_radius_percent / 100 * size_px[0]


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
        self.limit_px = streak_limit_px(settings, size_px)
        tile = max(8, ceil(self.limit_px))
        streaks = FullscreenPass(
            ctx,
            "streaks.frag",
            size_px=size_px,
            inputs={"velocity": velocity, "depth": depth},
            constants=_Shutter(settings.shutter_fraction, self.limit_px),
        )
        x_pass, y_pass, neighbours = _tile_passes(ctx, streaks.target, tile)
        gather = FullscreenPass(
            ctx,
            "motion_blur.frag",
            size_px=size_px,
            inputs={"colour": colour, "streaks": streaks.target, "longest": neighbours.target},
            filtered={"colour"},
            constants=_Sampling(settings.samples / STREAK_OF_SAMPLES_PX),
            defines={"TILE": tile},
        )
        self._passes = (streaks, x_pass, y_pass, neighbours, gather)
        self._peak = PeakPass(ctx, y_pass.target)
        self.target = gather.target

    def render(self) -> None:
        """Blur the present image."""
        for stage in self._passes:
            stage.render()
        self._peak.render()

    def longest_half_streak_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU."""
        return self._peak.read()


def _tile_passes(
    ctx: moderngl.Context, streaks: moderngl.Texture, tile: int
) -> tuple[FullscreenPass, FullscreenPass, FullscreenPass]:
    width, height = streaks.size
    columns, rows = ceil(width / tile), ceil(height / tile)
    x_pass = FullscreenPass(
        ctx,
        "streak_tiles.frag",
        size_px=(columns, height),
        inputs={"source": streaks},
        defines={"TILE": tile, "AXIS": 0},
    )
    y_pass = FullscreenPass(
        ctx,
        "streak_tiles.frag",
        size_px=(columns, rows),
        inputs={"source": x_pass.target},
        defines={"TILE": tile, "AXIS": 1},
    )
    neighbours = FullscreenPass(
        ctx,
        "streak_neighbours.frag",
        size_px=(columns, rows),
        inputs={"tiles": y_pass.target},
    )
    return x_pass, y_pass, neighbours
