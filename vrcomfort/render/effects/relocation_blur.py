"""Blurs one eye's whole image at a relocation, and lets it sharpen again."""

from __future__ import annotations

import moderngl

from vrcomfort.gpu.fullscreen_pass import copier
from vrcomfort.optics.motion import level_after
from vrcomfort.protocol.conditions import Condition, RelocationBlur
from vrcomfort.render.background_blur import MipLevelPass
from vrcomfort.render.effects.effect import EyeFrame, RegisteredEffect, reading_colour
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene


def plan(_: Scene, condition: Condition) -> PlannedPass:
    """Plan the blur after a relocation; level 0 is the image itself."""
    settings = condition.relocation_blur
    if settings is None:
        return PlannedPass("relocation_blur", False, "the condition has none")
    if settings.level == 0:
        return PlannedPass("relocation_blur", False, "its level is 0, the image itself")
    when = "a cut or a snap turn" if settings.snap_turns else "a cut"
    reason = f"MIP level {settings.level:g} at {when}, sharp after {settings.duration_s:g} s"
    return PlannedPass("relocation_blur", True, reason)


class RelocationBlurPass:
    """Draws `colour` (linear HDR RGBA16F) at a MIP level that falls with time into `target`.

    The level is a frame's, not an eye's: both eyes are as blurred. Once it has reached 0 the copy
    is exact.
    """

    max_radius_px = 0.0
    """A MIP level has no radius."""

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        settings: RelocationBlur,
        size_px: tuple[int, int],
    ) -> None:
        self._settings = settings
        self._blur = MipLevelPass(ctx, colour, most_level=settings.level, size_px=size_px)
        self.target = self._blur.target
        self._copy = copier(ctx, colour, self.target)
        self._relocated_ns: int | None = None

    def render(self, eye: EyeFrame) -> None:
        """Blur the present image by the time since the last relocation."""
        level = self._level(eye)
        if level == 0:
            self._copy()
            return
        self._blur.render(level)

    def adjust(self, settings: RelocationBlur) -> None:
        """Draw by other settings from now on."""
        self._settings = settings

    def warm_up(self) -> None:
        """Draw everything once, which frames long after a relocation leave out."""
        self._blur.render(self._settings.level)

    def clamps(self) -> tuple[str, ...]:
        """Return nothing: it has no limit."""
        return ()

    def reset(self) -> None:
        """Start again without a relocation."""
        self._relocated_ns = None

    def _level(self, eye: EyeFrame) -> float:
        step, settings = eye.step, self._settings
        if step is None or (settings.snap_turns and step.snap_turn):
            self._relocated_ns = eye.display_time_ns
        if self._relocated_ns is None:
            return 0.0
        elapsed_s = (eye.display_time_ns - self._relocated_ns) / 1e9
        return level_after(settings.level, elapsed_s=elapsed_s, duration_s=settings.duration_s)


EFFECT = RegisteredEffect("relocation_blur", plan, reading_colour(RelocationBlurPass))
