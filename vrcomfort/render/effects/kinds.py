"""The effects there are."""

from __future__ import annotations

from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.effects import speed_blur, vignette
from vrcomfort.render.effects.depth_of_field import effect as depth_of_field
from vrcomfort.render.effects.effect import EffectKind
from vrcomfort.render.effects.motion_blur import effect as motion_blur

_KINDS = depth_of_field.KIND, motion_blur.KIND, speed_blur.KIND, vignette.KIND
EFFECTS = {each.name: each for each in _KINDS}
"""By name."""


def in_order(condition: Condition) -> list[EffectKind]:
    """Return all effects in the order in which they would run."""
    return [EFFECTS[name] for name in condition.effect_order]
