"""Our kernel: tiles say what may reach a pixel; fronts spread, sharp fronts do not leak."""

from __future__ import annotations

from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.optics import circle_of_confusion as coc
from vrcomfort.optics import fronts
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render import gl
from vrcomfort.render.defocus import Defocus
from vrcomfort.render.fullscreen_pass import FullscreenPass
from vrcomfort.render.kernels.base import Aspect
from vrcomfort.render.kernels.tiles import TileKinds

_LAYERS: tuple[dict[str, int], ...] = ({}, {"FRONT": 1})
"""Wide blur behind each pixel, and in front of it."""


class _Directions(NamedTuple):
    directions: bytes


class VrcomfortKernel:
    """Tile-classified gather with a back and a front layer (``depth_of_field.frag``).

    Every pixel of a disc is looked at up to a radius that grows with the `rings`
    (:func:`fronts.small_px`). The widest discs come from half resolution, in 32-bit floats, so that
    a constant image is rounded once. Each tile is drawn by a program of its kind; where nothing is
    blurred it is copied, and where nothing is blurred around it there are no points either.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        defocus: Defocus,
        settings: DepthOfField,
    ) -> None:
        small_px = fronts.small_px(settings.rings)
        self._kinds = TileKinds(ctx, defocus, small_px=small_px)
        self._points_pass = self._kinds.points_pass()
        self._defocus, self._points = defocus, {"points": defocus.points}
        self._directions = _Directions(
            coc.ring_directions(settings.rings).astype(np.float32).tobytes()
        )
        self._defines: dict[str, Any] = {"RINGS": settings.rings, "SMALL_PX": small_px}
        self.target = gl.color_texture(ctx, defocus.size_px)
        seen = {"colour": colour, **self._points}
        all_around = {**seen, "reach": self._kinds.reach}
        self._before = [
            self._kinds.draw("taps_copy.frag", "COPIED", {"colour": colour}, target=self.target)
        ]
        self._blurs = [
            self._gather("ALIKE", seen, {"ONE_SURFACE": 1}),
            self._gather("SMALL", all_around, {}),
        ]
        self._after: list[FullscreenPass] = []
        if defocus.limit_px > small_px:
            self._add_wide(all_around)

    def render(self, pixel_aspect: float) -> None:
        """Blur the present points."""
        self._kinds.render()
        self._points_pass.render(self._defocus.eye)
        for each in self._before:
            each.render()
        for blur in self._blurs:
            blur.render(Aspect(pixel_aspect))
        for each in self._after:
            each.render()

    def _gather(
        self,
        kind: str,
        inputs: dict[str, moderngl.Texture],
        defines: dict[str, int],
        **options: Any,
    ) -> FullscreenPass:
        """Return the pass over tiles of this kind."""
        return self._kinds.draw(
            "depth_of_field.frag",
            kind,
            inputs,
            defines={**self._defines, **defines},
            target=self.target,
            **options,
        )

    def _add_wide(self, all_around: dict[str, moderngl.Texture]) -> None:
        """Draw wide discs at half resolution, where there are any, and then what they reach."""
        half = self._kinds.draw(
            "defocus_half.frag", "HALVES", self._points, halved=True, dtype="f4"
        )
        wide = [self._wide(half.target, layer) for layer in _LAYERS]
        back, front = (layer.target for layer in wide)
        layers = {"wide_back": back, "wide_front": front}
        self._before.append(half)
        self._blurs += wide
        self._after.append(
            self._kinds.draw(
                "defocus_enlarge.frag",
                "WIDE",
                {"wide_back": back},
                filtered={"wide_back"},
                target=self.target,
            )
        )
        self._blurs.append(
            self._gather(
                "LAYERED",
                {**all_around, **layers},
                {"WIDE_LAYERS": 1},
                constants=self._directions,
            )
        )

    def _wide(self, half: moderngl.Texture, layer: dict[str, int]) -> FullscreenPass:
        """Return the pass that draws one layer."""
        return self._kinds.draw(
            "defocus_wide.frag",
            "LAYERS",
            {**self._points, "points_half": half, "reach": self._kinds.reach},
            halved=True,
            filtered=() if layer else {"points_half"},
            constants=self._directions,
            defines={**self._defines, **layer},
            dtype="f4",
        )
