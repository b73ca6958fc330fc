"""Blurs one eye's whole image at a relocation, and lets it sharpen again."""

from __future__ import annotations

from vrcomfort.gpu.fullscreen_pass import copier
from vrcomfort.optics.motion import level_after
from vrcomfort.protocol.conditions import Condition, RelocationBlur
from vrcomfort.render.background_blur import MipLevelPass
from vrcomfort.render.effects.effect import EffectInputs, EffectPass, EyeFrame, RegisteredEffect
from vrcomfort.scene.data import Scene


def decide(settings: RelocationBlur, _: Condition, __: Scene) -> tuple[bool, str]:
    """Say whether there is blur after a relocation; level 0 is the image itself."""
    if settings.level == 0:
        return False, "its level is 0, the image itself"
    when = "a cut or a snap turn" if settings.snap_turns else "a cut"
    return True, f"MIP level {settings.level:g} at {when}, sharp after {settings.duration_s:g} s"


class RelocationBlurPass(EffectPass):
    """Draws the image at a MIP level that falls with time.

    The level is a frame's, not an eye's: both eyes are as blurred. Once it has reached 0 the copy
    is exact.
    """

    settings: RelocationBlur

    def __init__(self, inputs: EffectInputs) -> None:
        super().__init__(inputs)
        level, size_px = self.settings.level, inputs.size_px
        self._blur = MipLevelPass(inputs.ctx, inputs.colour, most_level=level, size_px=size_px)
        self.target = self._blur.target
        self._copy = copier(inputs.ctx, inputs.colour, self.target)
        self._relocated_ns: int | None = None

    def render(self, *eyes: EyeFrame) -> None:
        """Blur the present image by the time since the last relocation."""
        level = self._level(eyes[0])
        if level == 0:
            self._copy()
            return
        self._blur.render(level)

    def warm_up(self) -> None:
        """Draw everything once, which frames long after a relocation leave out."""
        self._blur.render(self.settings.level)

    def reset(self) -> None:
        """Start again without a relocation."""
        self._relocated_ns = None

    def _level(self, eye: EyeFrame) -> float:
        step, settings = eye.step, self.settings
        if step is None or (settings.snap_turns and step.snap_turn):
            self._relocated_ns = eye.display_time_ns
        if self._relocated_ns is None:
            return 0.0
        elapsed_s = (eye.display_time_ns - self._relocated_ns) / 1e9
        return level_after(settings.level, elapsed_s=elapsed_s, duration_s=settings.duration_s)


EFFECT = RegisteredEffect("relocation_blur", decide, RelocationBlurPass)
