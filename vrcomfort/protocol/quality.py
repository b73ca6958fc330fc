"""The dial `quality`: levels of settings, and what each was measured to cost and to get wrong.

Levels and figures are in ``analysis/measured/quality.toml``. A level says how blur is sampled, not
how strong it is: the same stimulus, faster or closer to the reference, up to the largest radius.
One view has that limit; levels with views through the lens have none, and show more blur where it
would act (`vrcomfort.render.effects.depth_of_field.blur_limit` says where that is).
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from pydantic import BaseModel, ConfigDict

from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from vrcomfort.protocol.conditions import Condition

Quality: TypeAlias = Literal["fast", "balanced", "accurate", "reference"]
Effects: TypeAlias = Literal["depth_of_field", "motion_blur", "both"]
Value: TypeAlias = int | float | str

MARK = "# Measured; written by the command named below, not by hand."

_DIALLED = ("depth_of_field", "motion_blur")
"""Effects whose sampling a level decides."""

_METHOD = {"kernel", "method", "over_blur", "views"}
"""Settings that say by which method, wherever an effect has them."""

LENSLESS_LAW = "linear"
"""No lens follows this law of defocus, which is the one of a condition that names none."""

SAME_LENS = {"dioptre", "eye"}
"""Laws of a lens that is the same at any focus: settings of `lens` apply to no other."""


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Level(_Table):
    """Settings by effect; `lens` joins `depth_of_field` where its law is in `SAME_LENS`."""

    depth_of_field: dict[str, Value] = {}
    lens: dict[str, Value] = {}
    motion_blur: dict[str, Value] = {}

    def settings(self, effect: str, *, law: str | None = None) -> dict[str, Value]:
        """Return the settings of an effect (`law`: of its defocus)."""
        if effect == "motion_blur":
            return dict(self.motion_blur)
        return {**self.depth_of_field, **(self.lens if law in SAME_LENS else {})}


class Measured(_Table):
    """How the figures came about."""

    command: str
    device: str
    date: str
    how: str


class Figure(_Table):
    """What a level was measured to cost and to get wrong in one scene; None was not measured."""

    level: Quality
    effects: Effects
    scene: str
    cost_ratio: float
    """Time of a stereo frame over that of the same frame without effects, in the same run."""
    psnr_db: float | None = None
    flip: float | None = None
    """Mean HDR-FLIP against the reference; 0 is equal."""


class QualityTable(_Table):
    """Content of ``quality.toml``."""

    levels: dict[Quality, Level]
    measured: Measured | None = None
    figures: tuple[Figure, ...] = ()


@cache
def quality_table() -> QualityTable:
    """Return the shipped table."""
    file = data_folder("analysis") / "measured" / "quality.toml"
    return QualityTable.model_validate(tomllib.loads(file.read_text(encoding="utf-8")))


def filled(condition: Any) -> Any:
    """Return a condition, as a protocol file has it, with what its level says and it does not.

    Anything that is no condition with a known level is returned as it is, for others to refuse.
    """
    if not isinstance(condition, Mapping) or condition.get("quality") not in get_args(Quality):
        return condition
    level = quality_table().levels[condition["quality"]]
    effects = {
        name: _filled_effect(level, name, condition[name])
        for name in _DIALLED
        if condition.get(name) is not None
    }
    return {**condition, **effects}


def _filled_effect(level: Level, name: str, given: Any) -> Any:
    if isinstance(given, Mapping):
        law = given.get("law", LENSLESS_LAW)
        return {**_fitting(level.settings(name, law=law), given), **given}
    if isinstance(given, BaseModel):
        settings = level.settings(name, law=getattr(given, "law", None))
        own = {field: getattr(given, field) for field in given.model_fields_set}
        return type(given)(**{**_fitting(settings, own), **own})
    return given


def _fitting(settings: dict[str, Value], own: Mapping[str, Any]) -> dict[str, Value]:
    """Leave out what a condition excludes: taps beside rings, views with peripheral blur."""
    excluded = {"taps"} if "rings" in own else set()
    if own.get("peripheral") is not None:
        excluded.add("views")
    return {name: value for name, value in settings.items() if name not in excluded}


def level_of(condition: Condition, drawn: Collection[str] = _DIALLED) -> Quality | None:
    """Return the level whose settings the effects have that are drawn, named there or not."""
    effects = {
        name: settings
        for name in _DIALLED
        if name in drawn and (settings := getattr(condition, name)) is not None
    }
    if not effects:
        return None
    found = (
        level
        for level in get_args(Quality)
        if all(_equals_level(name, settings, level) for name, settings in effects.items())
    )
    return next(found, None)


def _equals_level(name: str, settings: BaseModel, level: Quality) -> bool:
    """Compare what any level sets, and what names a method; strengths may differ."""
    levels = quality_table().levels
    wanted = levels[level].settings(name, law=getattr(settings, "law", None))
    known = type(settings).model_fields
    compared = {key for each in levels.values() for key in each.settings(name)} | _METHOD
    return all(
        getattr(settings, key) == wanted.get(key, known[key].default)
        for key in compared & known.keys()
    )


def effects_of(drawn: Collection[str]) -> Effects | None:
    """Return what figures call the passes that are drawn; None: no effect, or others too."""
    if "speed_blur" in drawn:
        return None
    lens, shutter = (name in drawn for name in _DIALLED)
    if lens and shutter:
        return "both"
    if lens:
        return "depth_of_field"
    return "motion_blur" if shutter else None


def figure_for(condition: Condition, scene: str, drawn: Collection[str]) -> Figure | None:
    """Return the shipped figures of a condition's level in a scene; None: not measured.

    They are those of a camera that moves: where only objects are blurred, nothing was measured.

    Parameters
    ----------
    drawn
        Names of the passes that are drawn.
    """
    blur = condition.motion_blur
    if blur is not None and blur.mode == "objects_only":
        return None
    wanted = level_of(condition, drawn), effects_of(drawn), scene
    found = (
        figure
        for figure in quality_table().figures
        if (figure.level, figure.effects, figure.scene) == wanted
    )
    return next(found, None)


def write_figures(file: Path, measured: Measured, figures: Iterable[Figure]) -> None:
    """Put new figures into a table; what is above :data:`MARK` stays as it is."""
    chosen = file.read_text(encoding="utf-8").partition(MARK)[0].rstrip()
    blocks = [_toml("[measured]", measured), *(_toml("[[figures]]", each) for each in figures)]
    text = "\n\n".join([chosen, MARK, *blocks]) + "\n"
    QualityTable.model_validate(tomllib.loads(text))
    file.write_text(text, encoding="utf-8")


def _toml(header: str, values: BaseModel) -> str:
    """Write a flat table; JSON's texts and numbers are TOML's, and None is left out."""
    lines = values.model_dump(exclude_none=True).items()
    return "\n".join(
        [header, *(f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in lines)]
    )
