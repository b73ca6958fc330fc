"""Compared methods: a table of named conditions, which grows with the settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

from pydantic import BaseModel

from vrcomfort.errors import InputError
from vrcomfort.protocol.conditions import Condition, DepthOfField, Focus, MotionBlur

Effect: TypeAlias = Literal["depth_of_field", "motion_blur", "both"]
EFFECTS: tuple[Effect, ...] = get_args(Effect)
Family: TypeAlias = Literal["none", "source", "ours", "dial"]
"""No blur; the method of a source; ours; ours from many points of the lens."""

OURS = "vrcomfort"
FOCUS = Focus(method="fixed", fixed_m=1.5)
LensName: TypeAlias = Literal["1.75", "3.5", "7", "eye"]
"""Percentage of the image's width that a circle of confusion's radius reaches at 2 D, or an eye."""
LENS_NAMES: tuple[LensName, ...] = get_args(LensName)


def _camera(percent: float) -> dict[str, Any]:
    return {"law": "dioptre", "max_radius_percent": percent, "full_blur_dioptre": 2.0}


LENSES: dict[LensName, dict[str, Any]] = {
    "1.75": _camera(1.75),
    "3.5": _camera(3.5),
    "7": _camera(7.0),
    "eye": {"law": "eye", "pupil_mm": 4.0, "max_radius_percent": 3.5},
}
"""Nothing in the walks is nearer than the limit of 2 D allows, so that the reference, which has no
limit, shows the same blur."""
LENS = LENSES["3.5"]
"""A large lens: 1.75 % of the image's width per dioptre."""
SHUTTER: dict[str, Any] = {"mode": "full", "shutter_fraction": 1.0, "max_radius_percent": 20.0}

PER_PIXEL_SAMPLES = 8
"""Samples along every streak of the method without occlusion."""

SAMPLES = (12, 16, 20, 36, 72, 96)
QUICK_SAMPLES = (12, 16, 36, 96)
STREAK_SAMPLES = (8, 16, 32)
VIEWS = (1, 4, 16, 64, 256)


@dataclass(frozen=True)
class BlurMethod:
    """A condition, and where it stands in figures.

    Parameters
    ----------
    name
        Unique within its effect.
    step
        Its place on the quality dial of its family: samples or views; None without a dial.
    """

    name: str
    effect: Effect
    family: Family
    condition: Condition
    step: int | None = None


def methods(effect: Effect, *, quick: bool = False) -> list[BlurMethod]:
    """Return the methods for an effect; `quick` takes fewer steps of each dial."""
    return {"depth_of_field": _lens, "motion_blur": _shutter, "both": _both}[effect](quick)


def base_condition(effect: Effect) -> Condition:
    """Return the condition of the reference for all methods of an effect."""
    return _condition(effect, "reference", effect != "motion_blur", effect != "depth_of_field")


def pick(found: list[BlurMethod], names: tuple[str, ...] | None) -> list[BlurMethod]:
    """Return the methods with these names (all where None), and the one without blur."""
    if names is None:
        return found
    return [method for method in found if method.name in names or method.family == "none"]


def effects_with(
    effects: tuple[Effect, ...], names: tuple[str, ...] | None, *, quick: bool
) -> tuple[Effect, ...]:
    """Return those of `effects` that have one of the methods with these names (all where None).

    Raises
    ------
    InputError
        If none of them has a method of one of the names.
    """
    if names is None:
        return effects
    known = {each: [method.name for method in methods(each, quick=quick)] for each in EFFECTS}
    for name in names:
        if not any(name in known[effect] for effect in effects):
            lists = "; ".join(f"{each} has {', '.join(known[each])}" for each in EFFECTS)
            asked = " or ".join(effects)
            raise InputError(f"--methods: {asked} has no method {name!r}; {lists}")
    return tuple(effect for effect in effects if set(known[effect]) & set(names))


def kinds(settings: type[BaseModel], name: str) -> tuple[str, ...]:
    """Return the values a setting can have, none where there is no such setting."""
    field = settings.model_fields.get(name)
    return () if field is None else get_args(field.annotation)


def _lens(quick: bool) -> list[BlurMethod]:
    return [
        no_blur("depth_of_field"),
        *_sources("depth_of_field", DepthOfField, "kernel", _lens_condition),
        *_dial(
            "depth_of_field",
            "ours",
            "samples",
            QUICK_SAMPLES if quick else SAMPLES,
            _lens_condition,
        ),
        *_views(quick),
    ]


def _shutter(quick: bool) -> list[BlurMethod]:
    return [
        no_blur("motion_blur"),
        *_sources("motion_blur", MotionBlur, "method", _per_pixel_condition),
        *_dial("motion_blur", "ours", "samples", _few(STREAK_SAMPLES, quick), _shutter_condition),
    ]


def _both(quick: bool) -> list[BlurMethod]:  # noqa: ARG001 - two orders, and no dial
    orders = ("depth_of_field_first", "motion_blur_first")
    ours = [
        BlurMethod(order, "both", "ours", _condition("both", order, True, True, effect_order=order))
        for order in orders
    ]
    return [no_blur("both"), *ours]


def no_blur(effect: Effect) -> BlurMethod:
    """Return the plain frame."""
    return BlurMethod("no blur", effect, "none", Condition(name="no_blur", focus=FOCUS))


def _sources(effect: Effect, settings: type[BaseModel], field: str, make: Any) -> list[BlurMethod]:
    """Return one method for each value of a setting that is not ours (the first or its name)."""
    names = kinds(settings, field)
    ours = OURS if OURS in names else settings.model_fields[field].default if names else None
    return [
        BlurMethod(name, effect, "source", make(name, **{field: name}))
        for name in names
        if name != ours
    ]


def _dial(
    effect: Effect, family: Family, field: str, steps: tuple[int, ...], make: Any
) -> list[BlurMethod]:
    return [
        BlurMethod(
            _name(step, field), effect, family, make(f"{field}_{step}", **{field: step}), step
        )
        for step in steps
    ]


def _name(step: int, field: str) -> str:
    return f"ours {step} {field if step > 1 else field.removesuffix('s')}"


def _views(quick: bool) -> list[BlurMethod]:
    if "views" not in DepthOfField.model_fields:
        return []
    steps = VIEWS[1:3] if quick else VIEWS
    return _dial("depth_of_field", "dial", "views", steps, _lens_condition)


def _few(steps: tuple[int, ...], quick: bool) -> tuple[int, ...]:
    return steps[::2] if quick else steps


def _lens_condition(name: str, **settings: Any) -> Condition:
    return Condition(name=name, focus=FOCUS, depth_of_field=DepthOfField(**{**LENS, **settings}))


def _shutter_condition(name: str, **settings: Any) -> Condition:
    return Condition(name=name, focus=FOCUS, motion_blur=MotionBlur(**{**SHUTTER, **settings}))


def _per_pixel_condition(name: str, **settings: Any) -> Condition:
    return _shutter_condition(name, **{"samples": PER_PIXEL_SAMPLES, **settings})


def _condition(_: Effect, name: str, lens: bool, shutter: bool, **settings: Any) -> Condition:
    return Condition(
        name=name,
        focus=FOCUS,
        depth_of_field=DepthOfField(**LENS) if lens else None,
        motion_blur=MotionBlur(**SHUTTER) if shutter else None,
        **settings,
    )
