"""Which passes a condition needs in a scene, and why: nothing is drawn."""

from __future__ import annotations

from vrcomfort.protocol.conditions import Condition, EffectName, Focus
from vrcomfort.render.effects.kinds import EFFECTS, in_order
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene

__all__ = ["PlannedPass", "effect", "focus", "plan_passes", "shadow", "velocity"]


def plan_passes(scene: Scene, condition: Condition) -> list[PlannedPass]:
    """Return all passes in the order in which they would run.

    A pass that is not needed has no texture, no program and no draw call.
    """
    return [
        shadow(scene),
        focus(scene, condition),
        PlannedPass("scene", True, "always: colour and depth of both eyes"),
        velocity(scene, condition),
        *(kind.plan(scene, condition) for kind in in_order(condition)),
        PlannedPass("tone_map", True, "always: linear light to display values"),
    ]


def effect(name: EffectName, scene: Scene, condition: Condition) -> PlannedPass:
    """Plan one effect."""
    return EFFECTS[name].plan(scene, condition)


def _readers(texture: str, scene: Scene, condition: Condition) -> list[str]:
    """Return the effects that are there and read a texture."""
    return [
        kind.name
        for kind in in_order(condition)
        if texture in kind.reads and kind.plan(scene, condition).needed
    ]


def shadow(scene: Scene) -> PlannedPass:
    """Plan the sun's shadow map."""
    needed = any(value > 0 for value in scene.environment.sun_irradiance)
    return PlannedPass(
        "shadow", needed, "the scene has a sun" if needed else "the scene has no sun"
    )


def focus(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan the focus rays."""
    if not _readers("focus", scene, condition):
        return PlannedPass("focus", False, "nothing is out of focus without depth of field")
    if condition.focus.method == "fixed":
        return PlannedPass("focus", False, f"focus is fixed at {condition.focus.fixed_m:g} m")
    return PlannedPass("focus", True, _focus_reason(condition.focus))


def _focus_reason(settings: Focus) -> str:
    if settings.method == "autofocus_zone":
        share = f"{settings.zone_ratio:g} of the image's sides"
        return (
            f"depth of field follows what is in the middle: {share}, averaged by the "
            f"{settings.zone_mean_on.upper()}"
        )
    if settings.method == "gaze":
        instead = (
            "nine rays ahead without one"
            if settings.without_gaze == "nine_ray"
            else "the session stops without one"
        )
        return f"depth of field follows the gaze: needs an eye tracker; {instead}"
    return "depth of field follows what is in front of the head"


def velocity(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan the velocity image."""
    readers = [name.replace("_", " ") for name in _readers("velocity", scene, condition)]
    if not readers:
        return PlannedPass("velocity", False, "nothing reads pixel velocities")
    return PlannedPass("velocity", True, f"{' and '.join(readers)} needs pixel velocities")
