"""The registered effects, and the passes that a condition needs in a scene: nothing is drawn."""

from __future__ import annotations

from dataclasses import replace

from vrcomfort.protocol.conditions import Condition, EffectName
from vrcomfort.render import background_blur
from vrcomfort.render.effects import motion_blur, relocation_blur, speed_blur, vignette
from vrcomfort.render.effects.depth_of_field import effect
from vrcomfort.render.effects.effect import RegisteredEffect
from vrcomfort.render.focus.rules import RULES
from vrcomfort.render.lighting import has_sun
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene

_ALL_EFFECTS = (
    effect.EFFECT,
    motion_blur.EFFECT,
    speed_blur.EFFECT,
    relocation_blur.EFFECT,
    vignette.EFFECT,
)
EFFECTS = {each.name: each for each in _ALL_EFFECTS}
"""By name."""


def in_order(condition: Condition) -> list[RegisteredEffect]:
    """Return all effects in the order in which they would run."""
    return [EFFECTS[name] for name in condition.effect_order]


def plan_passes(scene: Scene, condition: Condition) -> list[PlannedPass]:
    """Return all passes in the order in which they would run.

    A pass that is not needed has no texture, no program and no draw call.
    """
    return [
        plan_shadow(scene),
        plan_focus(scene, condition),
        PlannedPass("scene", True, "always: colour and depth of both eyes"),
        plan_velocity(scene, condition),
        background_blur.plan(scene, condition),
        *(effect.plan(scene, condition) for effect in in_order(condition)),
        PlannedPass("tone_map", True, "always: linear light to display values"),
    ]


def plan_effect(name: EffectName, scene: Scene, condition: Condition) -> PlannedPass:
    """Plan one effect."""
    return EFFECTS[name].plan(scene, condition)


def _readers(texture: str, scene: Scene, condition: Condition) -> list[str]:
    """Return the effects that are there and read a texture."""
    return [
        effect.name
        for effect in in_order(condition)
        if texture in effect.reads and effect.plan(scene, condition).needed
    ]


def plan_shadow(scene: Scene) -> PlannedPass:
    """Plan the sun's shadow map."""
    needed = has_sun(scene.environment)
    return PlannedPass(
        "shadow", needed, "the scene has a sun" if needed else "the scene has no sun"
    )


def plan_focus(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan the search for the focus."""
    if not _readers("focus", scene, condition):
        return PlannedPass("focus", False, "nothing is out of focus without depth of field")
    planned = RULES[condition.focus.method].plan(condition.focus)
    if "autofocus_zone" in condition.centred_on_gaze:
        return replace(planned, reason=f"{planned.reason}; centred on the gaze")
    return planned


def plan_velocity(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan the velocity image."""
    readers = [name.replace("_", " ") for name in _readers("velocity", scene, condition)]
    if not readers:
        return PlannedPass("velocity", False, "nothing reads pixel velocities")
    return PlannedPass("velocity", True, f"{' and '.join(readers)} needs pixel velocities")
