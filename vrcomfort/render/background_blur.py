"""Blurs what was drawn so far, so that named nodes can be drawn over it, sharp: layers by node."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from vrcomfort.errors import InputError
from vrcomfort.gpu.fullscreen_pass import FullscreenPass
from vrcomfort.gpu.mip_chain import MipChain
from vrcomfort.optics.relocation_blur import levels
from vrcomfort.protocol.conditions import BackgroundBlur, Condition
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene
from vrcomfort.settings import did_you_mean


class _Level(NamedTuple):
    level: float


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
    found = np.zeros(len(scene.nodes), dtype=bool)
    for index, node in enumerate(scene.nodes):
        named = any(fnmatchcase(node.name, pattern) for pattern in patterns)
        found[index] = named or (node.parent >= 0 and found[node.parent])
    if patterns and not found.any():
        wanted = " or ".join(repr(pattern) for pattern in patterns)
        hint = did_you_mean(patterns[0], {node.name for node in scene.nodes if node.name})
        raise InputError(
            f"condition {condition.name!r}: background_blur: no node of the scene "
            f"{scene.name!r} is called {wanted}; {hint}"
        )
    return found


class BackgroundBlurPass:
    """Draws `colour` at a MIP level over all samples of `samples`; depth stays as it is.

    Parameters
    ----------
    colour
        Linear HDR RGBA16F: what was drawn so far, one sample per pixel.
    samples
        The multisampled image that is drawn on.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        colour: moderngl.Texture,
        samples: moderngl.Texture,
        settings: BackgroundBlur,
    ) -> None:
        self._level = settings.level
        self._chain = MipChain(ctx, colour, levels(settings.level), colour.size)
        self._pass = FullscreenPass(
            ctx,
            "common/mip_level.frag",
            size_px=colour.size,
            inputs={"image": colour, "levels": self._chain.levels},
            filtered={"levels"},
            defines={"CHAIN": len(self._chain.levels)},
            target=samples,
        )

    def render(self) -> None:
        """Blur the present image."""
        self._chain.render()
        self._pass.render(_Level(self._level))
