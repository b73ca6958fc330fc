"""Which passes a condition needs in a scene, and why: no OpenGL, nothing is drawn."""

from __future__ import annotations

from dataclasses import dataclass

from vrcomfort.protocol.conditions import Condition, Focus
from vrcomfort.scene.data import Scene


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
    effects = [depth_of_field(condition), motion_blur(scene, condition)]
    if condition.effect_order == "motion_blur_first":
        effects.reverse()
    return [
        shadow(scene),
        focus(condition),
        PlannedPass("scene", True, "always: colour and depth of both eyes"),
        velocity(scene, condition),
        *effects,
        speed_blur(condition),
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
    needed = motion_blur(scene, condition).needed
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
    if settings.peripheral is None and settings.pinhole:
        return PlannedPass("depth_of_field", False, "its lens has no opening")
    reason = f"radius up to {settings.max_radius_percent:g} % of the image width"
    if settings.max_diameter_arcmin is not None:
        reason += f", diameter up to {settings.max_diameter_arcmin:g} arcmin"
    if settings.peripheral is not None:
        reason += ", with peripheral blur"
    if settings.views > 1:
        reason = f"the scene is drawn in {settings.views} views through the lens of each eye"
    return PlannedPass("depth_of_field", True, reason)


def motion_blur(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan motion blur; a shutter that never opens for long blurs nothing.

    Locomotion and heads move at run time, so only a mode that ignores every camera can be known
    to see nothing move; frames in which nothing moved are copied without any pass in every mode.
    """
    settings = condition.motion_blur
    if settings is None:
        return PlannedPass("motion_blur", False, "the condition has none")
    if settings.shutter_fraction == 0:
        return PlannedPass("motion_blur", False, "its shutter is open for no time")
    if settings.mode == "objects_only" and not any(node.moving for node in scene.nodes):
        return PlannedPass("motion_blur", False, "objects_only, and nothing in the scene moves")
    reason = f"{settings.mode}, shutter open for {settings.shutter_fraction:g} of the frame"
    return PlannedPass("motion_blur", True, reason)


def speed_blur(condition: Condition) -> PlannedPass:
    """Plan the blur that grows with speed; without a ramp nothing makes it grow."""
    settings = condition.speed_blur
    if settings is None:
        return PlannedPass("speed_blur", False, "the condition has none")
    if settings.max_sigma_arcmin == 0:
        return PlannedPass("speed_blur", False, "its largest sigma is zero")
    if settings.turning is None and settings.moving is None:
        return PlannedPass("speed_blur", False, "neither turning nor moving makes it grow")
    reason = f"sigma up to {settings.max_sigma_arcmin:g} arcmin at full speed"
    return PlannedPass("speed_blur", True, reason)
