"""The pass of the effect `grey`."""

from __future__ import annotations

from pathlib import Path

from my_lab.grey import Grey
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.effects.effect import EffectInputs, EffectPass, EyeFrame, RegisteredEffect
from vrcomfort.scene.data import Scene

SHADER = Path(__file__).with_name("grey.frag")


def decide(settings: Grey, _: Condition, __: Scene) -> tuple[bool, str]:
    """Say whether there is anything to draw, and why."""
    return settings.amount > 0, f"{settings.amount:.0%} of the colour"


class GreyPass(EffectPass):
    """Mixes the image with its luminance; both eyes alike."""

    def __init__(self, inputs: EffectInputs) -> None:
        super().__init__(inputs)
        self._pass = FullscreenPass(
            inputs.ctx,
            str(SHADER),
            size_px=inputs.size_px,
            inputs={"image": inputs.colour},
            constants={"amount": inputs.settings.amount},
        )
        self.target = self._pass.target

    def render(self, *eyes: EyeFrame) -> None:
        """Draw the present images in grey."""
        del eyes
        self._pass.render()


EFFECT = RegisteredEffect("grey", decide, GreyPass, measured={"amount": 1.0})
