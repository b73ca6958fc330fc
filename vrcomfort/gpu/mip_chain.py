"""Levels of an image, each half as wide as the one before; texels are means of their pixels."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import moderngl

from vrcomfort.gpu.fullscreen_pass import FullscreenPass


class _Size(NamedTuple):
    size_px: tuple[int, int]


class MipChain:
    """Levels 1, 2, … of `image` (RGBA16F): ``common/mip_downsample.frag``.

    Level k has size / 2^k, rounded up, and its texel t begins at pixel 2^k t, also where an odd
    image ends within a texel.

    Attributes
    ----------
    levels
        The textures, level 1 first.
    """

    def __init__(
        self, ctx: moderngl.Context, image: moderngl.Texture, count: int, size_px: tuple[int, int]
    ) -> None:
        self._halves: list[FullscreenPass] = []
        width, height = size_px
        for level in range(1, count + 1):
            self._halves.append(
                FullscreenPass(
                    ctx,
                    "common/mip_downsample.frag",
                    size_px=(ceil(width / 2**level), ceil(height / 2**level)),
                    inputs={"source": self._halves[-1].target if self._halves else image},
                    constants=_Size(size_px),
                    defines={"TEXEL": 2 ** (level - 1)},
                )
            )
        self.levels = [half.target for half in self._halves]

    def render(self, count: int | None = None) -> None:
        """Draw the first `count` levels of the present image, or all."""
        for half in self._halves[:count]:
            half.render()
