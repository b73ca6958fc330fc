"""The levels of the dial `quality`: settings by level, and the figures that ship with them.

Levels and figures are in ``analysis/measured/quality.toml``. A level says how blur is sampled, not
how strong it is: the same stimulus, faster or closer to the reference, up to the largest radius.
One view has that limit; levels with views through the lens have none, and show more blur where it
would act (`vrcomfort.render.effects.depth_of_field.lens_radius` says where that is).
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from typing import Any, Literal, TypeAlias, get_args

from pydantic import BaseModel, ConfigDict, RootModel

from vrcomfort.resources import data_folder

Quality: TypeAlias = Literal["fast", "balanced", "accurate", "reference"]
Effects: TypeAlias = Literal["depth_of_field", "motion_blur", "both"]
Value: TypeAlias = int | float | str

LENSLESS_LAW = "linear"
"""No lens follows this law of defocus, which is the one of a condition that names none."""

SAME_LENS = {"dioptre", "eye"}
"""Laws of a lens that is the same at any focus: settings of `lens` apply to no other."""


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class QualityLevel(RootModel[dict[str, dict[str, Value]]]):
    """Settings by effect; `lens` joins `depth_of_field` where its law is in `SAME_LENS`."""

    model_config = ConfigDict(frozen=True)

    def settings(self, effect: str, *, law: str | None = None) -> dict[str, Value]:
        """Return the settings of an effect (`law`: of its defocus)."""
        lens = self.root.get("lens", {}) if law in SAME_LENS else {}
        return {**self.root.get(effect, {}), **(lens if effect == "depth_of_field" else {})}


class MeasurementSource(_Table):
    """How the figures came about."""

    command: str
    device: str
    date: str
    how: str


class QualityFigure(_Table):
    """The measured cost and error of a level in one scene; None was not measured."""

    level: Quality
    effects: Effects
    scene: str
    cost_ratio: float
    """Time of a stereo frame over that of the same frame without effects, in the same run: the
    processor's on a software rasteriser."""
    psnr_db: float | None = None
    reads_per_pixel: float | None = None
    """Texture reads of the effects for each pixel of an eye's image."""
    flip: float | None = None
    """Mean HDR-FLIP against the reference; 0 is equal."""


class QualityTable(_Table):
    """Content of ``quality.toml``."""

    levels: dict[Quality, QualityLevel]
    measured: MeasurementSource | None = None
    figures: tuple[QualityFigure, ...] = ()


@cache
def quality_table() -> QualityTable:
    """Return the shipped table."""
    file = data_folder("analysis") / "measured" / "quality.toml"
    return QualityTable.model_validate(tomllib.loads(file.read_text(encoding="utf-8")))


def dialled() -> tuple[str, ...]:
    """Return the effects with settings in quality levels: a level decides their sampling."""
    names = (name for level in quality_table().levels.values() for name in level.root)
    return tuple(dict.fromkeys(name for name in names if name != "lens"))


def filled(condition: Any) -> Any:
    """Return a condition of a protocol file, completed with the settings of its level.

    Anything that is no condition with a known level is returned as it is, for others to refuse.
    """
    if not isinstance(condition, Mapping) or condition.get("quality") not in get_args(Quality):
        return condition
    level = quality_table().levels[condition["quality"]]
    effects = {
        name: _filled_effect(level, name, condition[name])
        for name in dialled()
        if condition.get(name) is not None
    }
    return {**condition, **effects}


def with_level(condition: Mapping[str, Any], level: Quality) -> dict[str, Any]:
    """Return the settings of a condition, all written out, as those of a level.

    What the level decides takes the place of what the condition has; the rest stays.
    """
    effects = {}
    for name in dialled():
        if own := condition.get(name):
            settings = quality_table().levels[level].settings(name, law=own.get("law"))
            effects[name] = {**own, **_fitting(settings, own)}
    return {**condition, **effects, "quality": level}


def _filled_effect(level: QualityLevel, name: str, given: Any) -> Any:
    if isinstance(given, Mapping):
        law = given.get("law", LENSLESS_LAW)
        return {**_fitting(level.settings(name, law=law), given), **given}
    if isinstance(given, BaseModel):
        settings = level.settings(name, law=getattr(given, "law", None))
        own = {field: getattr(given, field) for field in given.model_fields_set}
        return type(given)(**{**_fitting(settings, own), **own})
    return given


def _fitting(settings: dict[str, Value], own: Mapping[str, Any]) -> dict[str, Value]:
    """Drop settings that the condition excludes: views without a lens."""
    excluded = set()
    if own.get("peripheral") is not None or own.get("distance_along") == "ray":
        excluded.add("views")
    return {name: value for name, value in settings.items() if name not in excluded}
