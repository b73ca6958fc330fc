"""The depth of what is seen: a blurred foreground's reaches as far as its blur.

A runtime that shifts images by depth moves each pixel as its depth says. Behind the outline of a
blurred foreground the scene's depth is the background's, while the colour is the foreground's: the
outline would tear. With this depth it moves with what it belongs to.
"""

from __future__ import annotations

from vrcomfort.geometry import focal_length_px
from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, of_each
from vrcomfort.protocol.conditions import DepthOfField
from vrcomfort.render.camera import EyeCamera
from vrcomfort.render.effects.depth_of_field.coc_passes import DepthToCoc, aspects
from vrcomfort.render.effects.depth_of_field.lens_radius import max_radius_of
from vrcomfort.render.effects.effect import EffectInputs

TAPS = 16
"""On each side of a pixel: discs wider than this are sought in steps."""


class SeenDepthPass:
    """Spreads depth of what is in front of the focus over its discs.

    With several views its inputs are the lens's, not a view's.

    Attributes
    ----------
    target
        D32F of the same size.
    """

    def __init__(self, inputs: EffectInputs) -> None:
        ctx, depth, settings = inputs.ctx, inputs.reads["depth"], inputs.settings
        self._settings, self._size_px = settings, gl.size_px_of(depth)
        self._radii = DepthToCoc(inputs)
        self.target = gl.eye_depth(ctx, self._size_px, gl.layers_of(depth))
        # Taps are whole pixels apart, and as many on each side: the last may lie beyond the disc.
        reach_px = max_radius_of(settings, self._size_px) + TAPS
        self._rows = self._radii.make_pass(
            "depth_of_field/seen_depth_rows.frag",
            size_px=self._size_px,
            defines={"TAPS": TAPS},
            components=2,
            dtype="f4",
            reach_px={"depth": reach_px},
        )
        self._columns = FullscreenPass(
            ctx,
            "depth_of_field/seen_depth_columns.frag",
            size_px=self._size_px,
            inputs={"rows": self._rows.target},
            defines={"TAPS": TAPS},
            target=(),
            depth=self.target,
            reach_px=reach_px,
        )

    def adjust(self, settings: DepthOfField, infinity_m: float) -> None:
        """Spread by other settings from now on; see :meth:`DepthToCoc.adjust`."""
        self._settings = settings
        self._radii.adjust(settings, infinity_m)

    def render(self, *cameras: EyeCamera) -> None:
        """Spread the present depth of the eyes."""
        fovs = [camera.fov for camera in cameras]
        focal_px = (focal_length_px(fov, self._size_px)[0] for fov in fovs)
        limits_px = [max_radius_of(self._settings, self._size_px, each) for each in focal_px]
        self._radii.see_with(*cameras)
        self._rows.render()
        self._columns.render(
            max_radius_px_of_eye=of_each(limits_px),
            pixel_aspect_of_eye=aspects(fovs, self._size_px),
        )
