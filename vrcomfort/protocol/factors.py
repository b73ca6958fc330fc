"""Crossed factors: conditions made of one level of each factor."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Annotated, Any

from pydantic import Field

from vrcomfort.protocol.conditions import Condition, ConditionSettings
from vrcomfort.settings import KeyPath, Name, Problem, Settings, Word

MOST_CONDITIONS = 64  # as many as a Latin square may have (`order_check.MOST_TREATMENTS`)


class LevelName(Settings):
    """A level's name and label."""

    name: Name
    """Part of the names of conditions."""
    label: str = ""
    """In words; part of the labels of conditions."""


class FactorLevel(ConditionSettings, LevelName):
    """A level of a factor: the settings of a condition that it changes."""


class CrossedFactor(Settings):
    """A within-subject factor; its levels are crossed with those of the others."""

    name: Word
    """Name of the factor in conditions' `levels`, and in `max_run`."""
    levels: Annotated[tuple[FactorLevel, ...], Field(min_length=2, max_length=16)]
    """At least two."""


def crossed(factors: tuple[CrossedFactor, ...]) -> tuple[Condition, ...]:
    """Return a condition for every combination of levels, called by their names joined by `_`."""
    return tuple(_condition(factors, levels) for levels in product(*(f.levels for f in factors)))


def _condition(factors: tuple[CrossedFactor, ...], levels: tuple[FactorLevel, ...]) -> Condition:
    settings: dict[str, Any] = {}
    for level in levels:
        _merge(settings, level.model_dump(exclude_unset=True, exclude=set(LevelName.model_fields)))
    return Condition(
        name="_".join(level.name for level in levels),
        label=" + ".join(level.label or level.name for level in levels),
        levels={factor.name: level.name for factor, level in zip(factors, levels, strict=True)},
        **settings,
    )


def _merge(into: dict[str, Any], more: dict[str, Any]) -> None:
    for key, value in more.items():
        if isinstance(value, dict) and isinstance(into.get(key), dict):
            _merge(into[key], value)
        else:
            into[key] = value


def factor_problems(factors: tuple[CrossedFactor, ...]) -> Iterator[Problem]:
    """Yield why factors cannot be crossed: too many levels, or two that set the same thing."""
    count = 1
    for factor in factors:
        count *= len(factor.levels)
    if factors and count > MOST_CONDITIONS:
        message = f"these factors cross to {count} conditions; at most {MOST_CONDITIONS} are made"
        yield Problem(("factors",), message)
    owners: dict[KeyPath, str] = {}
    for index, factor in enumerate(factors):
        for number, level in enumerate(factor.levels):
            # Merging would let the factor that comes last win, without a word.
            for key in _set_by(level):
                owner = owners.setdefault(key, factor.name)
                if owner != factor.name:
                    message = f"factor `{owner}` sets `{'.'.join(map(str, key))}`, too"
                    path = ("factors", index, "levels", number, *key)
                    yield Problem(path, f"{message}; let one factor alone say it")


def _set_by(level: FactorLevel) -> Iterator[KeyPath]:
    """Yield the key paths that a level sets; an effect's table is the effect itself, too."""
    for name, value in level.model_dump(exclude_unset=True).items():
        if name in LevelName.model_fields:
            continue
        if isinstance(value, dict):
            yield from ((name, key) for key in value)
        else:
            yield (name,)
