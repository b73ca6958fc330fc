"""The pass of the effect `grey`."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import moderngl

from my_lab.grey import Grey
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.effects.effect import EyeFrame, RegisteredEffect, reading_colour
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene

SHADER = Path(__file__).with_name("grey.frag")


class _Constants(NamedTuple):
    amount: float


def plan(_: Scene, condition: Condition) -> PlannedPass:
    """Plan the pass; without an amount there is nothing to draw."""
    settings: Grey | None = getattr(condition, "grey", None)
    if settings is None:
        return PlannedPass("grey", False, "the condition has none")
    return PlannedPass("grey", settings.amount > 0, f"{settings.amount:.0%} of the colour")


class GreyPass:
    """Mixes `colour` (linear HDR) with its luminance; the result is `target`."""

    max_radius_px = 0.0
    """It blurs nothing."""

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        settings: Grey,
        size_px: tuple[int, int],
    ) -> None:
        self._pass = FullscreenPass(
            ctx,
            str(SHADER),
            size_px=size_px,
            inputs={"image": colour},
            constants=_Constants(settings.amount),
        )
        self.target = self._pass.target

    def render(self, eye: EyeFrame) -> None:
        """Draw the present image in grey; both eyes alike."""
        del eye
        self._pass.render()

    def warm_up(self) -> None:
        """Do nothing: there is no pass that frames leave out."""

    def clamps(self) -> tuple[str, ...]:
        """Return nothing: it has no limit."""
        return ()

    def reset(self) -> None:
        """Do nothing: it remembers nothing."""


EFFECT = RegisteredEffect("grey", plan, reading_colour(GreyPass), measured={"amount": 1.0})
