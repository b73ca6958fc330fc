"""Draws an image at one MIP level, blown up to full size: ``common/mip_level.frag``."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass, MipChain
from vrcomfort.optics.motion import halvings


class _Level(NamedTuple):
    level: float


class MipLevelPass:
    """Draws `colour` (linear HDR RGBA16F) at a MIP level into `target`.

    Parameters
    ----------
    most_level
        The highest level that is drawn; above 0.
    target
        A texture to draw into instead of one of its own; of several samples, all are drawn.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        *,
        most_level: float,
        size_px: tuple[int, int],
        target: moderngl.Texture | None = None,
    ) -> None:
        self._chain = MipChain(ctx, colour, halvings(most_level), size_px)
        self._pass = FullscreenPass(
            ctx,
            "common/mip_level.frag",
            size_px=size_px,
            inputs={"image": colour, "levels": self._chain.levels},
            filtered={"levels"},
            defines={"CHAIN": len(self._chain.levels)},
            target=target,
        )
        self.target = self._pass.target

    def render(self, level: float) -> None:
        """Draw the present image at a level above 0."""
        self._chain.render(halvings(level))
        self._pass.render(_Level(level))
