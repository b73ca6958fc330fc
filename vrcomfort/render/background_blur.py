"""Background blur: the nodes that stay sharp, and the image at one MIP level behind them."""

from __future__ import annotations

from fnmatch import fnmatchcase

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.gpu.fullscreen_pass import FullscreenPass, MipChain
from vrcomfort.gpu.passes import AnyTexture
from vrcomfort.optics.motion import halvings
from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.boxes import with_all_below
from vrcomfort.scene.data import Scene
from vrcomfort.settings import did_you_mean


def plan(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan the blur behind a foreground; level 0 is the scene itself.

    Raises
    ------
    InputError
        If no node of the scene has one of the names.
    """
    settings = condition.background_blur
    if settings is None:
        return PlannedPass("background_blur", False, "the condition has none")
    sharp = foreground(scene, condition)
    if settings.level == 0:
        return PlannedPass("background_blur", False, "its level is 0, the scene itself")
    reason = f"MIP level {settings.level:g} behind {int(sharp.sum())} of {len(sharp)} nodes"
    return PlannedPass("background_blur", True, reason)


def foreground(scene: Scene, condition: Condition) -> NDArray[np.bool_]:
    """Return (nodes,) which are drawn over the blur: those that are named, and all below them.

    Raises
    ------
    InputError
        If there are none.
    """
    settings = condition.background_blur
    patterns = () if settings is None else settings.foreground
    names = [node.name for node in scene.nodes]
    named = [any(fnmatchcase(name, pattern) for pattern in patterns) for name in names]
    found = with_all_below(scene, np.array(named, dtype=bool))
    if patterns and not found.any():
        wanted = " or ".join(repr(pattern) for pattern in patterns)
        hint = did_you_mean(patterns[0], set(names) - {""})
        raise InputError(
            f"condition {condition.name!r}: background_blur: no node of the scene "
            f"{scene.name!r} is called {wanted}; {hint}"
        )
    return found


class MipLevelPass:
    """Draws `colour` (linear HDR RGBA16F) at a MIP level, magnified to full size, into `target`.

    Parameters
    ----------
    most_level
        The highest level that is drawn; above 0.
    target
        A texture to draw into instead of one of its own; of several samples, all are drawn.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        colour: AnyTexture,
        *,
        most_level: float,
        size_px: tuple[int, int],
        target: AnyTexture | None = None,
    ) -> None:
        self._chain = MipChain(ctx, colour, halvings(most_level), size_px)
        self._pass = FullscreenPass(
            ctx,
            "common/mip_level.frag",
            size_px=size_px,
            inputs={"image": colour, "levels": self._chain.levels},
            filtered={"levels"},
            reach_px={"image": 0.0, "levels": 2.0 ** len(self._chain.levels)},
            defines={"CHAIN": len(self._chain.levels)},
            target=target,
        )
        self.target = self._pass.target

    def render(self, level: float) -> None:
        """Draw the present image at a level above 0."""
        self._chain.render(halvings(level))
        self._pass.render(level=level)
