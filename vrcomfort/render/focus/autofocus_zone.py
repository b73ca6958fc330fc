"""`autofocus_zone`: a weighted mean over the middle of the image, on the GPU.

::

    depth, semantic weight ─► weight · value, weight ─► ½ ─► ½ ─► ... ─► 1×1 ─► focus
    (the zone's own frustum,   focus_weights.frag        focus_downsample.frag
     from the head centre)

Source: Hillaire et al. 2008, Eq. 2 and 3.
"""

from __future__ import annotations

from typing import NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Fov, View, clip_from_view, rotation_matrix
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import autofocus_zone
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.camera import rotation_only
from vrcomfort.render.focus.rule import FocusInputs, FocusRule, Sight
from vrcomfort.render.focus.search import FocusSearch, Look
from vrcomfort.render.planned_pass import PlannedPass


def plan(settings: Focus) -> PlannedPass:
    """Plan the zone."""
    share = f"{settings.zone_ratio:g} of the image's sides"
    where = settings.zone_mean_on.upper()
    reason = f"depth of field follows what is in the middle: {share}, averaged by the {where}"
    return PlannedPass("focus", True, reason)


def screen_tangents(views: tuple[View, View]) -> tuple[float, float]:
    """Return half width and half height of the image as tangents: the mean of both eyes."""
    left, right, up, down = np.mean([view.fov.tangents for view in views], axis=0)
    return float(right - left) / 2, float(up - down) / 2


class _Weights(NamedTuple):
    near_m: float
    infinity_m: float
    semantic_limits: tuple[float, float]
    gauss_limits: tuple[float, float]


class AutofocusZone:
    """Draws depth and semantic weights of the zone and averages them.

    The zone is a rectangle around the head's forward axis with `zone_ratio` times the sides of the
    eyes' images; it covers the square of that of their area.
    """

    fragment = "focus/focus_zone.frag"

    def __init__(self, inputs: FocusInputs) -> None:
        ctx, self._gpu, settings, self._near_m = inputs
        self._ctx, self._settings = ctx, settings
        size_px = settings.zone_size_px
        self._depth = gl.depth_texture(ctx, size_px)
        self._semantic = gl.color_texture(ctx, size_px, components=1, dtype="f4")
        self._zone = ctx.framebuffer([self._semantic], self._depth)
        self.triangles = 0
        dioptres = settings.mean == "dioptres"
        self.defines = {"MEAN_DIOPTRES": 1} if dioptres else {}
        self.constants = {"means": 2, **({} if dioptres else {"infinity_m": settings.infinity_m})}
        self._passes = () if settings.zone_mean_on == "cpu" else self._averaging(size_px)
        self._means = (
            self._passes[-1].target
            if self._passes
            else gl.color_texture(ctx, (1, 1), components=2, dtype="f4")
        )

    def _averaging(self, size_px: tuple[int, int]) -> tuple[FullscreenPass, ...]:
        settings = self._settings
        weigh = FullscreenPass(
            self._ctx,
            "focus/focus_weights.frag",
            size_px=size_px,
            inputs={"depth": self._depth, "semantic": self._semantic},
            constants=_Weights(
                self._near_m,
                settings.infinity_m,
                (settings.semantic_min, settings.semantic_max),
                (settings.gauss_border, settings.gauss_centre),
            ),
            defines=self.defines,
            components=2,
            dtype="f4",
        )
        passes = [weigh]
        while passes[-1].target.size != (1, 1):
            width, height = passes[-1].target.size
            passes.append(
                FullscreenPass(
                    self._ctx,
                    "focus/focus_downsample.frag",
                    size_px=((width + 1) // 2, (height + 1) // 2),
                    inputs={"source": passes[-1].target},
                    components=2,
                    dtype="f4",
                )
            )
        return tuple(passes)

    def look(self, sight: Sight) -> Look:
        """Draw the zone, average it, and bind the means."""
        self._draw(sight)
        for each in self._passes:
            each.render()
        if not self._passes:
            self._average_on_cpu()
        self._means.use(2)
        return Look({})

    def _draw(self, sight: Sight) -> None:
        ctx = self._ctx
        x, y = np.arctan(self._settings.zone_ratio * np.array(sight.screen_tangents)).tolist()
        head = sight.world_from_head
        clip_from_relative = clip_from_view(Fov(-x, x, y, -y), self._near_m) @ rotation_only(
            rotation_matrix(head.orientation).T
        )
        self._zone.use()
        self._zone.clear(self._settings.semantic_min, depth=0.0)  # the sky
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        self.triangles = self._gpu.draw_semantic(clip_from_relative, head.position)
        ctx.enable_only(moderngl.NOTHING)

    def _average_on_cpu(self) -> None:
        """Wait for the GPU, and average in NumPy."""
        width, height = self._settings.zone_size_px
        depth, semantic = (
            np.frombuffer(
                self._zone.read(components=1, attachment=attachment, dtype="f4", alignment=1), "f4"
            ).reshape(height, width)
            for attachment in (-1, 0)
        )
        weighted = autofocus_zone.weighted(depth, semantic, self._near_m, self._settings)
        self._means.write(weighted.mean(axis=(0, 1)).astype(np.float32))


def build(inputs: FocusInputs) -> FocusSearch:
    """Build the search in the zone."""
    return FocusSearch(inputs, AutofocusZone(inputs))


RULE = FocusRule("autofocus_zone", plan, build)
