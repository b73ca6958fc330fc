"""What a writer of a protocol probably meant: misspelt names and wrong units."""

from __future__ import annotations

import re
import typing
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, Tag

_UNITS = {
    "m_s": "metres per second",
    "km_h": "kilometres per hour",
    "ns": "nanoseconds",
    "us": "microseconds",
    "ms": "milliseconds",
    "s": "seconds",
    "sec": "seconds",
    "seconds": "seconds",
    "min": "minutes",
    "minutes": "minutes",
    "per_min": "per minute",
    "per_s": "per second",
    "mm": "millimetres",
    "cm": "centimetres",
    "m": "metres",
    "km": "kilometres",
    "deg": "degrees",
    "rad": "radians",
    "arcmin": "minutes of arc",
    "dioptre": "dioptres",
    "diopter": "dioptres",
    "px": "pixels",
    "percent": "percent",
    "fraction": "a fraction",
    "hz": "hertz",
}
_SUFFIX = re.compile(rf"_({'|'.join(sorted(_UNITS, key=len, reverse=True))})$")


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return `` did you mean `x`?`` for the nearest known word, or what there is to choose from."""
    choices = sorted(known)
    near = get_close_matches(word, choices, n=1, cutoff=0.6)
    if near:
        return f"did you mean `{near[0]}`?"
    return f"known here: {', '.join(choices)}" if choices else "nothing is known here"


_RENAMED = {"rings": "samples", "taps": "samples"}
"""Settings of earlier versions, and what says the same now."""


def renamed(key: str, known: Iterable[str]) -> str | None:
    """Say what a setting of an earlier version is called now, where that is known here."""
    now = _RENAMED.get(key)
    if now not in set(known):
        return None
    return f"`{key}` is `{now}` since there is one dial for it: write `{now} = 36`, or leave it out"


def wrong_unit(key: str, known: Iterable[str]) -> str | None:
    """Say which unit is wanted where `key` is a known key with another unit or without one."""
    stem, unit = _split_unit(key)
    for name in known:
        wanted_stem, wanted = _split_unit(name)
        if wanted and wanted != unit and wanted_stem == stem:
            given = f"in {_UNITS[unit]}" if unit else "without a unit"
            return f"`{key}` is {given}, but this is given in {_UNITS[wanted]}: use `{name}`"
    return None


def _split_unit(key: str) -> tuple[str, str]:
    found = _SUFFIX.search(key)
    return (key[: found.start()], found[1]) if found else (key, "")


def fields_at(model: type[BaseModel], path: Sequence[str | int]) -> list[str]:
    """Return the keys that the table at `path` of a model may have."""
    current: Any = model
    for part in path:
        if isinstance(part, int):
            continue
        if part.startswith("<"):  # which of several kinds of table it is
            current = _tagged(current, part)
            continue
        if typing.get_origin(current) is dict:
            current = typing.get_args(current)[1]
            continue
        models = _models(current)
        current = models[0].model_fields[part].annotation if models else None
    return [name for found in _models(current) for name in found.model_fields]


def _tagged(annotation: Any, tag: str) -> Any:
    """Return the member of a union that has a tag, None where none has it."""
    parts = typing.get_args(annotation)
    if any(isinstance(part, Tag) and part.tag == tag for part in parts):
        return parts[0]
    found = (_tagged(part, tag) for part in parts)
    return next((each for each in found if each is not None), None)


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Return the models inside an annotation such as ``tuple[Condition, ...] | None``."""
    if isinstance(annotation, type):
        return [annotation] if issubclass(annotation, BaseModel) else []
    return [found for part in typing.get_args(annotation) for found in _models(part)]
