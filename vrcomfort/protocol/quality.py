"""The level of `quality` of a condition, and its measured cost and error.

The levels are those of `vrcomfort.protocol.quality_levels`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import get_args

from pydantic import BaseModel

from vrcomfort.protocol.conditions import EFFECTS, Condition
from vrcomfort.protocol.quality_levels import (
    Effects,
    MeasurementSource,
    Quality,
    QualityFigure,
    QualityTable,
    dialled,
    quality_table,
)
from vrcomfort.settings import toml_value

MARK = "# Measured; written by the command named below, not by hand."

_METHOD = {"kernel", "method", "over_blur", "views"}
"""Settings that say by which method, wherever an effect has them."""


def level_of(condition: Condition, drawn: Collection[str] | None = None) -> Quality | None:
    """Return the quality level that the drawn effects' settings amount to, or None."""
    effects = {
        name: settings
        for name in dialled()
        if (drawn is None or name in drawn) and (settings := getattr(condition, name)) is not None
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
    """Compare the settings of all levels, and those that name a method; strengths may differ."""
    levels = quality_table().levels
    wanted = levels[level].settings(name, law=getattr(settings, "law", None))
    known = type(settings).model_fields
    compared = {key for each in levels.values() for key in each.settings(name)} | _METHOD
    return all(
        getattr(settings, key) == wanted.get(key, known[key].default)
        for key in compared & known.keys()
    )


def effects_of(drawn: Collection[str]) -> Effects | None:
    """Return the figures' name for a set of passes; None: no effect, or others too."""
    measured = ("depth_of_field", "motion_blur")
    if any(name in drawn for name in EFFECTS if name not in measured):
        return None
    lens, shutter = (name in drawn for name in measured)
    if lens and shutter:
        return "both"
    if lens:
        return "depth_of_field"
    return "motion_blur" if shutter else None


def figure_for(condition: Condition, scene: str, drawn: Collection[str]) -> QualityFigure | None:
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


def write_figures(
    file: Path, measured: MeasurementSource, figures: Iterable[QualityFigure]
) -> None:
    """Put new figures into a table; the text above :data:`MARK` stays as it is."""
    chosen = file.read_text(encoding="utf-8").partition(MARK)[0].rstrip()
    blocks = [_toml("[measured]", measured), *(_toml("[[figures]]", each) for each in figures)]
    text = "\n\n".join([chosen, MARK, *blocks]) + "\n"
    QualityTable.model_validate(tomllib.loads(text))
    file.write_text(text, encoding="utf-8")


def _toml(header: str, values: BaseModel) -> str:
    """Write a flat table; None is left out."""
    lines = values.model_dump(exclude_none=True).items()
    return "\n".join([header, *(f"{key} = {toml_value(value)}" for key, value in lines)])
