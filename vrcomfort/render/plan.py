"""Which passes a condition needs in a scene, and why: no OpenGL, nothing is drawn."""

from __future__ import annotations

from dataclasses import dataclass

from vrcomfort.protocol.conditions import Condition
from vrcomfort.render.scene_data import Scene


@dataclass(frozen=True)
class PlannedPass:
    """One pass, whether it is there, and the reason in words."""

    name: str
    needed: bool
    reason: str


def plan_passes(scene: Scene, condition: Condition) -> list[PlannedPass]:
    """Return all passes in the order in which they would run.

    A pass that is not needed has no texture, no program and no draw call.
    """
    effects = [depth_of_field(condition), motion_blur(condition)]
    if condition.effect_order == "motion_blur_first":
        effects.reverse()
    return [
        shadow(scene),
        focus(condition),
        PlannedPass("scene", True, "always: colour and depth of both eyes"),
        velocity(condition),
        *effects,
        PlannedPass("tone_map", True, "always: linear light to display values"),
    ]


def shadow(scene: Scene) -> PlannedPass:
    """Plan the sun's shadow map."""
    needed = any(value > 0 for value in scene.environment.sun_irradiance)
    return PlannedPass(
        "shadow", needed, "the scene has a sun" if needed else "the scene has no sun"
    )


def focus(condition: Condition) -> PlannedPass:
    """Plan the focus rays."""
    if not depth_of_field(condition).needed:
        return PlannedPass("focus", False, "nothing is out of focus without depth of field")
    if condition.focus.method == "fixed":
        return PlannedPass("focus", False, f"focus is fixed at {condition.focus.fixed_m:g} m")
    return PlannedPass("focus", True, "depth of field follows what is in front of the head")


def velocity(condition: Condition) -> PlannedPass:
    """Plan the velocity image."""
    needed = motion_blur(condition).needed
    return PlannedPass(
        "velocity",
        needed,
        "motion blur needs pixel velocities" if needed else "nothing reads pixel velocities",
    )


def depth_of_field(condition: Condition) -> PlannedPass:
    """Plan depth of field; r_max = 0 is the pinhole image, which needs no pass."""
    settings = condition.depth_of_field
    if settings is None:
        return PlannedPass("depth_of_field", False, "the condition has none")
    if settings.max_radius_percent == 0:
        return PlannedPass("depth_of_field", False, "its largest radius is zero")
    reason = f"radius up to {settings.max_radius_percent:g} % of the image width"
    if settings.views > 1:
        reason = f"the scene is drawn in {settings.views} views through the lens of each eye"
    return PlannedPass("depth_of_field", True, reason)


def motion_blur(condition: Condition) -> PlannedPass:
    """Plan motion blur; a shutter that never opens for long blurs nothing."""
    settings = condition.motion_blur
    if settings is None:
        return PlannedPass("motion_blur", False, "the condition has none")
    if settings.shutter_fraction == 0:
        return PlannedPass("motion_blur", False, "its shutter is open for no time")
    reason = f"{settings.mode}, shutter open for {settings.shutter_fraction:g} of the frame"
    return PlannedPass("motion_blur", True, reason)
