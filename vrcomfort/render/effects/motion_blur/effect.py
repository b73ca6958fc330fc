"""Motion blur of one eye from a velocity buffer (McGuire et al. 2012, Guertin et al. 2013)."""

from __future__ import annotations

from typing import NamedTuple

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.optics.motion import MOST_SAMPLES, STREAK_OF_SAMPLES_PX, ramp
from vrcomfort.protocol.conditions import Condition, MotionBlur
from vrcomfort.render.effects.effect import EffectInputs, EffectKind, EyeFrame
from vrcomfort.render.effects.motion_blur.tile_max import Shutter, TileMaxPass
from vrcomfort.render.head_step import HeadStep
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene

WIDEST_STRIDE_PX = 4
"""Between samples that look for what is in front: it must not be stepped over."""


class _Limit(NamedTuple):
    radius_limit_px: float


class _Taps(NamedTuple):
    taps_per_px: float
    few_taps: float


class _Sampling(NamedTuple):
    px_per_sample: int


def plan(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan motion blur; a shutter that never opens for long blurs nothing.

    Locomotion and heads move at run time, so only a mode that ignores every camera can be known
    to see nothing move; frames in which nothing moved are copied without any pass in every mode.
    """
    settings = condition.motion_blur
    if settings is None:
        return PlannedPass("motion_blur", False, "the condition has none")
    if settings.shutter_fraction == 0:
        return PlannedPass("motion_blur", False, "its shutter is open for no time")
    if settings.mode == "objects_only" and not any(node.moving for node in scene.nodes):
        return PlannedPass("motion_blur", False, "objects_only, and nothing in the scene moves")
    reason = f"{settings.mode}, shutter open for {settings.shutter_fraction:g} of the frame"
    return PlannedPass("motion_blur", True, reason)


def build(inputs: EffectInputs) -> MotionBlurPass:
    """Build motion blur."""
    return MotionBlurPass(
        inputs.ctx,
        colour=inputs.colour,
        depth=inputs.depth,
        velocity=inputs.reads["velocity"],
        settings=inputs.settings,
        size_px=inputs.size_px,
    )


def streak_scale(settings: MotionBlur, step: HeadStep | None) -> float:
    """Return what all streaks are multiplied by: 1 to 0.

    The shutter is open for a part of one period, also where the frame before lies further back;
    and streaks may fade for how fast the head turns.
    """
    if step is None:
        return 1.0
    fade = settings.fade_with_turning
    faded = ramp(step.turn_deg_s("head"), fade.from_deg_s, fade.to_deg_s) if fade else 0.0
    return (1 - faded) / step.periods


class MotionBlurPass:
    """Smears `colour` along `velocity` for as long as the shutter is open; the result is `target`.

    Parameters
    ----------
    colour, depth, velocity
        Linear HDR RGBA16F, reverse-Z D32F and RG16F (px per frame, +x right, +y up).

    Notes
    -----
    The limit on half tile_max alters what is seen. :meth:`longest_half_velocity_px` says how long
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
        self._tile_max = TileMaxPass(ctx, velocity=velocity, settings=settings, size_px=size_px)
        self.limit_px = self._tile_max.limit_px
        self._gather: _Reconstruction | FullscreenPass
        if settings.method == "reconstruction":
            self._gather = _Reconstruction(ctx, colour, depth, self._tile_max, settings)
        else:
            self._gather = _per_pixel(ctx, colour, self._tile_max, settings)
        self._copy = gl.copier(ctx)
        self.target = self._gather.target

    def render(self, eye: EyeFrame) -> None:
        """Blur the present image; where nothing has moved, it is copied, bit by bit."""
        scale = streak_scale(self._settings, eye.step)
        if eye.still or scale == 0:
            self._copy(self._colour, self.target)
            return
        self._draw(scale)

    def warm_up(self) -> None:
        """Draw everything once, which frames in which nothing moves leave out."""
        self._draw(0.0)

    def _draw(self, scale: float) -> None:
        self._gather.render(self._tile_max.render(scale))

    def forget(self) -> None:
        """Do nothing: frames after a cut have no streaks."""

    def longest_half_velocity_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU."""
        return self._tile_max.longest.read()

    def clamps(self) -> tuple[str, ...]:
        """Return what the limit has done to the frames so far, in words; waits for the GPU."""
        longest_px = self.longest_half_velocity_px()
        if longest_px <= self.limit_px:
            return ()
        return (
            f"motion blur: half streaks of up to {longest_px:.1f} px were shortened to "
            f"{self.limit_px:.1f} px",
        )


class _Reconstruction:
    """Blurs along each pixel's own streak, then draws over where things pass each other."""

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        tile_max: TileMaxPass,
        settings: MotionBlur,
    ) -> None:
        tile: dict[str, int | float | str] = {"TILE": tile_max.tile_px}
        samples = min(settings.samples, MOST_SAMPLES)
        stride_px = min(int(STREAK_OF_SAMPLES_PX / samples), WIDEST_STRIDE_PX)
        self._dilate = FullscreenPass(
            ctx,
            "motion_blur/tile_max_dilate.frag",
            size_px=tile_max.target.size,
            inputs={
                "tile_max": tile_max.target,
                "tile_max_crossing": tile_max.crossing,
                "max_so_far": tile_max.longest.target,
            },
            more_components=(2,),
            constants=_Limit(tile_max.limit_px),
            defines=tile,
        )
        longest, crossing = self._dilate.targets
        self._plain = FullscreenPass(
            ctx,
            "motion_blur/motion_blur.frag",
            size_px=colour.size,
            inputs={"colour": colour, "velocity": tile_max.velocity},
            filtered={"colour"},
            constants=_Taps(samples / STREAK_OF_SAMPLES_PX, samples // 2),
            defines={"CUBIC": 1} if settings.samples > MOST_SAMPLES else {},
        )
        self.target = self._plain.target
        self._foreground = FullscreenPass(
            ctx,
            "motion_blur/motion_blur_foreground.frag",
            size_px=colour.size,
            inputs={
                "colour": colour,
                "velocity": tile_max.velocity,
                "depth": depth,
                "longest": longest,
                "crossing": crossing,
            },
            filtered={"colour"},
            constants=_Sampling(stride_px),
            defines={**tile, "CLASS": "MIXED", "POINT_PX": tile_max.tile_px},
            vertex="motion_blur/motion_tiles_of_class.vert",
            tiles=longest.size,
            target=self.target,
        )

    def render(self, shutter: Shutter) -> None:
        """Blur along the present streaks."""
        self._dilate.render()
        self._plain.render(shutter)
        self._foreground.render(shutter)


def _per_pixel(
    ctx: moderngl.Context, colour: moderngl.Texture, tile_max: TileMaxPass, settings: MotionBlur
) -> FullscreenPass:
    return FullscreenPass(
        ctx,
        "motion_blur/motion_blur_per_pixel.frag",
        size_px=colour.size,
        inputs={"colour": colour, "velocity": tile_max.velocity},
        filtered={"colour"},
        defines={"SAMPLES": settings.samples},
    )


KIND = EffectKind("motion_blur", plan, build, reads=frozenset({"velocity"}))
