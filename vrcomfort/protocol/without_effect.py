"""Settings that a protocol writes down, and that do nothing beside the others it has chosen."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from vrcomfort.optics.refocus import LAWS
from vrcomfort.protocol.conditions import Condition
from vrcomfort.protocol.model import Protocol
from vrcomfort.settings import KeyPath, Problem, Settings

Needs = Mapping[str, Collection[Any]]
"""Other settings of the same table, and the values of theirs of which one is needed."""

_ZONE: Needs = {"method": ("autofocus_zone",)}
_ZONE_MEAN: Needs = {**_ZONE, "zone_statistic": ("mean",)}
_GAZE: Needs = {"method": ("gaze",)}
_RAYS_AHEAD: Needs = {"method": ("nine_ray",)}
_THIN_LENS: Needs = {"law": ("thin_lens",)}
_FOLLOWING: Needs = {"method": ("nine_ray", "autofocus_zone", "gaze")}
_LAWS_THAT_TAKE = {
    key: tuple(name for name, law in LAWS.items() if key in law.settings)
    for key in sorted(set().union(*(law.settings for law in LAWS.values())))
    if key != "infinity_m"  # which is also where the sky is
}

NEEDS: dict[str, dict[str, Needs]] = {
    "focus": {
        "fixed_m": {"method": ("fixed",)},
        "script": {"method": ("scripted",)},
        "script_every_s": {"method": ("scripted",)},
        "ring_deg": _RAYS_AHEAD,
        "mean": {"method": ("nine_ray", "autofocus_zone"), "zone_statistic": ("mean",)},
        "outlier_mad": _RAYS_AHEAD,
        "outlier_floor_fraction": {**_RAYS_AHEAD, "mean": ("metres",)},
        "outlier_floor_dioptre": {**_RAYS_AHEAD, "mean": ("dioptres",)},
        "zone_ratio": _ZONE,
        "zone_size_px": _ZONE,
        "zone_statistic": _ZONE,
        "zone_mean_on": _ZONE,
        "semantic_min": _ZONE,
        "semantic_max": _ZONE,
        "gauss_centre": _ZONE_MEAN,
        "gauss_border": _ZONE_MEAN,
        "gaze_radius_deg": _GAZE,
        "without_gaze": _GAZE,
        "law": _FOLLOWING,
        **{key: {**_FOLLOWING, "law": laws} for key, laws in _LAWS_THAT_TAKE.items()},
    },
    "depth_of_field": {
        "slices_m": {"kernel": ("mip_slices",)},
        "rotate_taps": {"kernel": ("poisson12",)},
        "full_blur_m": {"law": ("linear",)},
        "full_blur_dioptre": {"law": ("dioptre",)},
        "aperture_m": _THIN_LENS,
        "focal_length_m": _THIN_LENS,
        "distance_offset_m": _THIN_LENS,
        "pupil_mm": {"law": ("eye",)},
        "samples": {"kernel": ("vrcomfort",)},
        "over_blur": {"views": range(2, 257)},
    },
    "motion_blur": {"neck": {"mode": ("rotation_cancelled",)}},
}
"""What each setting needs to do anything, by effect; a setting that is not here always does."""


_ADD = {
    "autofocus_zone": 'write method = "autofocus_zone" under focus, beside depth_of_field,',
    "peripheral": "write a table depth_of_field.peripheral",
    "vignette": "write a table vignette",
}
"""What a condition needs so that it can be centred on the gaze."""


def without_effect(protocol: Protocol) -> Iterator[Problem]:
    """Yield a problem for each setting in the protocol's text that does nothing there.

    Only what is written counts: defaults, and what a level of `quality` fills in, may be idle. What
    a level of a factor writes must do something in one of the conditions that it is part of.
    """
    data = tomllib.loads(protocol.toml)
    for path, table, conditions in _written(protocol, data):
        if table.get("quality") and not any(map(_has_dials, conditions)):
            message = "`quality` does nothing without depth_of_field or motion_blur; remove it"
            yield Problem((*path, "quality"), message)
        for index, name in enumerate(table.get("gaze_centre", {}).get("of", ())):
            if not any(name in each.centred_on_gaze for each in conditions):
                message = f"`gaze_centre` centres `{name}`, which is not there; {_ADD[name]}"
                yield Problem((*path, "gaze_centre", "of", index), f"{message} or leave it out")
        for effect, needs in NEEDS.items():
            for key in needs.keys() & table.get(effect, {}).keys():
                reasons = [idle(getattr(each, effect), needs[key]) for each in conditions]
                if reasons and all(reasons):
                    message = f"`{key}` does nothing with {reasons[0]}; remove it or change that"
                    yield Problem((*path, effect, key), message)


def _written(
    protocol: Protocol, data: Mapping[str, Any]
) -> Iterator[tuple[KeyPath, Mapping[str, Any], list[Condition]]]:
    """Yield where settings are written, what is there, and the conditions that have them."""
    for index, table in enumerate(data.get("conditions", ())):
        yield ("conditions", index), table, [protocol.conditions[index]]
    for index, factor in enumerate(data.get("factors", ())):
        for number, table in enumerate(factor["levels"]):
            level = (factor["name"], table["name"])
            having = [each for each in protocol.conditions if level in each.levels.items()]
            yield ("factors", index, "levels", number), table, having


def _has_dials(condition: Condition) -> bool:
    return bool(condition.depth_of_field or condition.motion_blur)


def idle(settings: Settings, needs: Needs) -> str | None:
    """Return the choice beside which a setting with these needs does nothing."""
    for choice, values in needs.items():
        value = getattr(settings, choice)
        # Nine rays stand in for a gaze that no headset tracks.
        stand_in = getattr(settings, "without_gaze", None) if value == "gaze" else None
        if value not in values and stand_in not in values:
            return f'{choice} = "{value}"' if isinstance(value, str) else f"{choice} = {value}"
    return None
