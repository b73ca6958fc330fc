"""Motion blur of one eye from a velocity buffer (McGuire et al. 2012, Guertin et al. 2013)."""

from __future__ import annotations

import moderngl

from vrcomfort.gpu import gl
from vrcomfort.optics.motion import ramp
from vrcomfort.protocol.conditions import Condition, MotionBlur
from vrcomfort.render.effects.effect import EffectInputs, EffectKind, EyeFrame
from vrcomfort.render.effects.motion_blur.per_pixel import PerPixel
from vrcomfort.render.effects.motion_blur.reconstruction import Reconstruction
from vrcomfort.render.effects.motion_blur.shutter import Shutter
from vrcomfort.render.head_step import HeadStep
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene


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
    turns = settings.virtual_turning == "kept"
    moves = scene.has_hands or any(node.moving for node in scene.nodes)
    if settings.mode == "objects_only" and not turns and not moves:
        return PlannedPass("motion_blur", False, "objects_only, and nothing in the scene moves")
    reason = f"{settings.mode}, shutter open for {settings.shutter_fraction:g} of the frame"
    if settings.neck is not None and settings.mode == "rotation_cancelled":
        reason += f", about a neck {settings.neck.behind_m:g} m behind"
        reason += f" and {settings.neck.below_m:g} m below the eyes"
    if settings.virtual_turning != "by_mode":
        reason += f", virtual turning {settings.virtual_turning}"
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
    The limit on half streaks alters what is seen. :meth:`clamps` says how long those would have
    been that were shortened to ``limit_px``.
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
        self.limit_px = settings.max_radius_percent / 100 * size_px[0]
        self._method: Reconstruction | PerPixel
        if settings.method == "reconstruction":
            self._method = Reconstruction(
                ctx,
                colour=colour,
                depth=depth,
                velocity=velocity,
                samples=settings.samples,
                limit_px=self.limit_px,
            )
        else:
            self._method = PerPixel(ctx, colour=colour, velocity=velocity, samples=settings.samples)
        self._copy = gl.copier(ctx)
        self.target = self._method.target

    def render(self, eye: EyeFrame) -> None:
        """Blur the present image; where nothing has moved, it is copied, bit by bit."""
        scale = streak_scale(self._settings, eye.step)
        if eye.still or scale == 0:
            self._copy(self._colour, self.target)
            return
        self._draw(scale)

    def adjust(self, settings: MotionBlur) -> None:
        """Draw by other settings from now on."""
        self._settings = settings

    def warm_up(self) -> None:
        """Draw everything once, which frames in which nothing moves leave out."""
        self._draw(0.0)

    def _draw(self, scale: float) -> None:
        self._method.render(Shutter(self._settings.shutter_fraction * scale, self.limit_px))

    def forget(self) -> None:
        """Do nothing: frames after a cut have no streaks."""

    def longest_half_velocity_px(self) -> float:
        """Return the longest half streak of all frames, before the limit; waits for the GPU.

        With ``per_pixel``, of those only that the limit has shortened; 0 where there are none.
        """
        return self._method.longest_half_velocity_px()

    def clamps(self) -> tuple[str, ...]:
        """Return what the limit has done to the frames so far, in words; waits for the GPU."""
        longest_px = self.longest_half_velocity_px()
        if longest_px <= self.limit_px:
            return ()
        return (
            f"motion blur: half streaks of up to {longest_px:.1f} px were shortened to "
            f"{self.limit_px:.1f} px",
        )


KIND = EffectKind("motion_blur", plan, build, reads=frozenset({"velocity"}))
