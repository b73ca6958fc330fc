"""Typed rows of results, and their plain forms at the edge: JSON objects and cells of a CSV."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import Field, fields, is_dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Cells = Mapping[str, object]
"""Column → cell of one line of a CSV table."""
HIDDEN = {"hidden": True}
"""Metadata of a dataclass field that renderings need and results.json does not have."""
Value = TypeVar("Value")
INLINE = {"inline": True}
"""Metadata of a dataclass field whose own fields stand in its place in JSON, or none for None."""


def as_json(value: object) -> Any:
    """Return dataclasses as objects, tuples as lists; all else as it is."""
    if value is None or isinstance(value, str | int | float):  # most are
        return value
    if is_dataclass(value) and not isinstance(value, type):
        found: dict[str, Any] = {}
        for each, inner in _fields(value):
            if each.metadata == HIDDEN:
                continue
            if each.metadata == INLINE:
                found |= {} if inner is None else as_json(inner)
            else:
                found[each.name] = as_json(inner)
        return found
    if isinstance(value, Mapping):
        return {str(key): as_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [as_json(item) for item in value]
    return value


def rounded(value: Value) -> Value:
    """Return the same structure with numbers to 12 digits, NaN and infinity as None.

    The page prints numbers that results.json has: both are of the rounded ones.
    """
    return cast("Value", _rounded(value))


def _rounded(value: object) -> object:
    if isinstance(value, float):
        return float(f"{value:.12g}") if math.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    if is_dataclass(value) and not isinstance(value, type):
        changed: dict[str, Any] = {
            each.name: tuple(map(_rounded, inner)) if type(inner) is tuple else _rounded(inner)
            for each, inner in _fields(value)
        }
        return replace(value, **changed)
    if isinstance(value, dict):
        return {str(key): _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return value


def _fields(row: DataclassInstance) -> list[tuple[Field[Any], object]]:
    return [(each, getattr(row, each.name)) for each in _declared(type(row))]


_declared = cache(fields)


def cells(row: object, without: tuple[str, ...] = ()) -> dict[str, object]:
    """Return a row's fields as the cells of a CSV line; lists of names stay, as a line of CSV."""
    return {name: value for name, value in as_json(row).items() if name not in without}
