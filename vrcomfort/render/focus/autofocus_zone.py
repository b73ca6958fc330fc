"""`autofocus_zone`: weighted mean or extreme of the image's middle, on the GPU or the CPU.

::

    depth, semantic weight ─► weight · value, weight ─► ½ ─► ½ ─► ... ─► 1×1 ─► focus
    (the zone's own frustum,   focus_weights.frag        focus_downsample.frag
     from the head centre)     or, for an extreme,       or
                               focus_candidates.frag     focus_extreme.frag

Source: Hillaire et al. 2008, Eq. 2 and 3.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import moderngl
import numpy as np

from vrcomfort.geometry import Fov, View, clip_from_view
from vrcomfort.gpu import gl, passes
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics import autofocus_zone
from vrcomfort.protocol.conditions import Focus
from vrcomfort.render.camera import rotation_only
from vrcomfort.render.focus.search import FocusInputs, FocusRule, FocusSearch, HeadView, ProbeResult
from vrcomfort.render.gpu_scene import SEMANTIC_SHADER


def decide(settings: Focus) -> tuple[bool, str]:
    """Say that it draws the zone, and how it reads it."""
    width, height = settings.zone_size_px
    done = {
        "mean": "averaged",
        "minimum": "searched for what is nearest",
        "maximum": "searched for what is farthest",
    }[settings.zone_statistic]
    passes = len(autofocus_zone.halvings(settings.zone_size_px))
    how = {
        "gpu": f"by the GPU in {passes} pass{'es' if passes > 1 else ''}",
        "cpu": "by the CPU, which waits for the GPU in every frame",
    }[settings.zone_mean_on]
    reason = (
        f"depth of field follows what is in the middle: {settings.zone_ratio:g} of the image's "
        f"sides, drawn in {width}×{height} px and {done} {how}"
    )
    return True, reason


def screen_tangents(views: tuple[View, View]) -> tuple[float, float]:
    """Return half width and half height of the image as tangents: the mean of both eyes."""
    one, other = views[0].fov.tangents, views[1].fov.tangents
    left, right = (one[0] + other[0]) / 2, (one[1] + other[1]) / 2
    up, down = (one[2] + other[2]) / 2, (one[3] + other[3]) / 2
    return (right - left) / 2, (up - down) / 2


class _Place(NamedTuple):
    half_tangents: tuple[float, float]
    centre: tuple[float, float]


class AutofocusZone:
    """Draws depth and semantic weights of the zone and reduces them to one texel.

    The zone is a rectangle around the head's forward axis, or around where the eyes look and within
    the image, with `zone_ratio` times the sides of the eyes' images; it covers the square of that
    of their area.
    """

    fragment = "focus/focus_zone.frag"

    def __init__(self, inputs: FocusInputs) -> None:
        self._ctx, self._gpu, self._settings, self._near_m, self._along_ray = inputs
        settings, size_px = inputs.settings, inputs.settings.zone_size_px
        self._depth = gl.depth_texture(inputs.ctx, size_px)
        self._semantic = gl.color_texture(inputs.ctx, size_px, components=1, dtype="f4")
        self._zone = inputs.ctx.framebuffer([self._semantic], self._depth)
        self._cleared = passes.clear([self._semantic, self._depth])
        self._drawn = passes.Pass(SEMANTIC_SHADER, inputs.gpu.images, self._cleared.writes)
        self.defines, distance = _how_it_is_read(settings, inputs.near_m)
        self.constants: dict[str, Any] = {"reduced": 2, **distance}
        self._passes = () if settings.zone_mean_on == "cpu" else self._reduction()
        self._reduced = (
            self._passes[-1].target
            if self._passes
            else gl.color_texture(inputs.ctx, (1, 1), components=2, dtype="f4")
        )

    def _reduction(self) -> tuple[FullscreenPass, ...]:
        """Return the passes from the zone to one texel, each a half of the one before."""
        settings = self._settings
        candidates = {
            "near_m": self._near_m,
            "infinity_m": settings.infinity_m,
            "semantic_limits": (settings.semantic_min, settings.semantic_max),
        }
        along_ray = {"ALONG_RAY": 1} if self._along_ray else {}
        if settings.zone_statistic == "mean":
            weights = {
                **candidates,
                "gauss_limits": (settings.gauss_border, settings.gauss_centre),
            }
            first = self._pass("focus/focus_weights.frag", weights, {**self.defines, **along_ray})
            return self._halved(first, "focus/focus_downsample.frag", {})
        first = self._pass("focus/focus_candidates.frag", candidates, along_ray)
        farthest = {"FARTHEST": 1} if settings.zone_statistic == "maximum" else {}
        return self._halved(first, "focus/focus_extreme.frag", farthest)

    def _pass(
        self, fragment: str, constants: dict[str, Any], defines: dict[str, int]
    ) -> FullscreenPass:
        return FullscreenPass(
            self._ctx,
            fragment,
            size_px=self._settings.zone_size_px,
            inputs={"depth": self._depth, "semantic": self._semantic},
            constants=constants,
            defines=defines,
            components=2,
            dtype="f4",
        )

    def _halved(
        self, first: FullscreenPass, fragment: str, defines: dict[str, int]
    ) -> tuple[FullscreenPass, ...]:
        passes = [first]
        _, *smaller = autofocus_zone.halvings(first.target.size)
        for size_px in smaller:
            passes.append(
                FullscreenPass(
                    self._ctx,
                    fragment,
                    size_px=size_px,
                    inputs={"source": passes[-1].target},
                    defines=defines,
                    components=2,
                    dtype="f4",
                )
            )
        return tuple(passes)

    def look(self, view: HeadView) -> ProbeResult:
        """Draw the zone, reduce it, and bind the texel."""
        width, height = view.screen_tangents
        ratio = self._settings.zone_ratio
        centre = autofocus_zone.kept_within(view.zone_centre, view.screen_tangents, ratio)
        place = _Place((width * ratio, height * ratio), centre)
        self._draw(view, place)
        along_ray = place if self._along_ray else None
        for index, each in enumerate(self._passes):
            each.render(**(along_ray._asdict() if along_ray and index == 0 else {}))
        if not self._passes:
            self._reduce_on_cpu(along_ray)
        self._reduced.use(2)
        return ProbeResult({})

    def _draw(self, view: HeadView, place: _Place) -> None:
        ctx = self._ctx
        middle, half = np.array(place.centre), np.array(place.half_tangents)
        (left, down), (right, up) = np.arctan([middle - half, middle + half]).tolist()
        head = view.world_from_head
        clip_from_relative = clip_from_view(Fov(left, right, up, down), self._near_m)
        clip_from_relative = clip_from_relative @ rotation_only(head.rotation.T)
        self._zone.use()
        sky = self._settings.semantic_min
        self._cleared.run(self._zone.clear, sky, depth=0.0)
        ctx.enable_only(moderngl.DEPTH_TEST)
        ctx.depth_func = gl.DEPTH_FUNC
        self._drawn.run(self._gpu.draw_semantic, clip_from_relative, head.position)
        ctx.enable_only(moderngl.NOTHING)

    def _reduce_on_cpu(self, along_ray: _Place | None) -> None:
        """Wait for the GPU, and reduce in NumPy."""
        width, height = self._settings.zone_size_px
        depth, semantic = (
            np.frombuffer(
                self._zone.read(components=1, attachment=attachment, dtype="f4", alignment=1), "f4"
            ).reshape(height, width)
            for attachment in (-1, 0)
        )
        reduced = autofocus_zone.reduced(
            depth, semantic, self._near_m, self._settings, *(along_ray or ())
        )
        self._reduced.write(reduced.astype(np.float32))


def _how_it_is_read(settings: Focus, near_m: float) -> tuple[dict[str, int], dict[str, float]]:
    """Return the variant and the uniform with which one texel is a distance."""
    if settings.zone_statistic != "mean":
        return {"EXTREME": 1}, {"near_m": near_m}
    if settings.mean == "dioptres":
        return {"MEAN_DIOPTRES": 1}, {}
    return {}, {"infinity_m": settings.infinity_m}


def build(inputs: FocusInputs) -> FocusSearch:
    """Build the search in the zone."""
    return FocusSearch(inputs, AutofocusZone(inputs))


RULE = FocusRule("autofocus_zone", decide, build)
