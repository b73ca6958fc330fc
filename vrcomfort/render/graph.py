"""The frame, declared: its parts in order, what they read and write, and why they are there.

Effects are found in the modules of `vrcomfort.render.effects`, focus rules in those of
`vrcomfort.render.focus`. Nothing is drawn here; `condition_passes` wires what is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from vrcomfort.declarations import declared_in
from vrcomfort.errors import InputError
from vrcomfort.installed import installed, load, place_of
from vrcomfort.protocol.conditions import EFFECTS as NAMES
from vrcomfort.protocol.conditions import Condition, EffectName
from vrcomfort.render import background_blur, effects
from vrcomfort.render.effects.effect import RegisteredEffect
from vrcomfort.render.focus.rules import RULES
from vrcomfort.render.lighting import has_sun
from vrcomfort.render.planned_pass import PlannedPass
from vrcomfort.scene.data import Scene

ENTRY_POINTS = "vrcomfort.passes"
"""Entry points of installed packages: the name of an effect → its `RegisteredEffect`."""


def _registered() -> dict[EffectName, RegisteredEffect]:
    found = {each.name: each for each in declared_in(effects, RegisteredEffect)}
    for entry in installed(ENTRY_POINTS):
        effect = load(entry)
        if not isinstance(effect, RegisteredEffect) or effect.name != entry.name:
            message = f"is no RegisteredEffect called `{entry.name}` (vrcomfort docs own_effect)"
            raise InputError(f"the entry point {place_of(entry)} {message}")
        found[entry.name] = effect
    missing, unknown = set(NAMES) - set(found), set(found) - set(NAMES)
    if missing or unknown:
        raise InputError(
            "an effect needs a table of settings and a pass (vrcomfort docs own_effect); one of "
            f"both is missing for {', '.join(sorted(missing | unknown))}"
        )
    return {name: found[name] for name in NAMES}


EFFECTS = _registered()
"""By name, in the order of their tables in a condition."""


@dataclass(frozen=True)
class FramePart:
    """A part of a frame.

    Parameters
    ----------
    plan
        Say whether it is there in a scene under a condition, and why; no OpenGL.
    reads, writes
        Images by name. A part that reads the image it writes draws the next one of it.
    """

    name: str
    plan: Callable[[Scene, Condition], PlannedPass]
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()


def frame_of(condition: Condition) -> tuple[FramePart, ...]:
    """Return the parts of a frame in the order in which they run."""
    return (
        FramePart("shadow", _shadow, writes=("shadow_map",)),
        FramePart("focus", plan_focus, writes=("focus",)),
        FramePart("scene", _scene, reads=("shadow_map",), writes=("colour", "depth")),
        FramePart("velocity", _velocity, writes=("velocity",)),
        FramePart("background_blur", background_blur.plan, reads=("colour",), writes=("colour",)),
        *map(_effect, in_order(condition)),
        FramePart("tone_map", _tone_map, reads=("colour",), writes=("display",)),
    )


def in_order(condition: Condition) -> list[RegisteredEffect]:
    """Return all effects in the order in which they would run."""
    return [EFFECTS[name] for name in condition.effect_order]


def plan_passes(scene: Scene, condition: Condition) -> list[PlannedPass]:
    """Return all parts in the order in which they would run.

    One that is not needed has no texture, no program and no draw call.

    Raises
    ------
    ValueError
        If a part reads an image that none before it writes.
    """
    parts = frame_of(condition)
    planned = [part.plan(scene, condition) for part in parts]
    check_parts(parts)
    return planned


def check_parts(parts: Iterable[FramePart]) -> None:
    """Make sure that each part reads what an earlier one writes.

    Raises
    ------
    ValueError
        With the part and the image, and with the later part that writes it.
    """
    listed = list(parts)
    written: set[str] = set()
    for index, part in enumerate(listed):
        for image in part.reads:
            if image in written:
                continue
            later = [other.name for other in listed[index + 1 :] if image in other.writes]
            who = f"{later[0]} writes after it" if later else "no part of a frame writes"
            raise ValueError(f"{part.name} reads the image {image!r}, which {who}")
        written |= set(part.writes)


def plan_effect(name: EffectName, scene: Scene, condition: Condition) -> PlannedPass:
    """Plan one effect."""
    return EFFECTS[name].plan(scene, condition)


def _effect(effect: RegisteredEffect) -> FramePart:
    return FramePart(
        effect.name, effect.plan, ("colour", *sorted(effect.reads)), writes=("colour",)
    )


def _readers(texture: str, scene: Scene, condition: Condition) -> list[str]:
    """Return the effects that are there and read a texture."""
    return [
        effect.name
        for effect in in_order(condition)
        if texture in effect.reads and effect.plan(scene, condition).needed
    ]


def _shadow(scene: Scene, _: Condition) -> PlannedPass:
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


def _scene(scene: Scene, _: Condition) -> PlannedPass:
    """Plan the scene itself."""
    reason = "always: colour and depth of both eyes"
    if scene.environment.resolve == "by_brightness":
        reason += "; bright samples weigh less, at no further reads or bytes"
    return PlannedPass("scene", True, reason)


def _velocity(scene: Scene, condition: Condition) -> PlannedPass:
    """Plan the velocity image."""
    readers = [name.replace("_", " ") for name in _readers("velocity", scene, condition)]
    if not readers:
        return PlannedPass("velocity", False, "nothing reads pixel velocities")
    return PlannedPass("velocity", True, f"{' and '.join(readers)} needs pixel velocities")


def _tone_map(_: Scene, __: Condition) -> PlannedPass:
    """Plan the step from light to display values."""
    return PlannedPass("tone_map", True, "always: linear light to display values")
