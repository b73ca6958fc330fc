"""The effects there are."""

from __future__ import annotations

from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.effects import motion_blur, relocation_blur, speed_blur, vignette
from vrcomfort.render.effects.depth_of_field import effect
from vrcomfort.render.effects.effect import EffectKind

_KINDS = (
    effect.KIND,
    motion_blur.KIND,
    speed_blur.KIND,
    relocation_blur.KIND,
    vignette.KIND,
)
EFFECTS = {each.name: each for each in _KINDS}
"""By name."""


def in_order(condition: Condition) -> list[EffectKind]:
    """Return all effects in the order in which they would run."""
    return [EFFECTS[name] for name in condition.effect_order]
