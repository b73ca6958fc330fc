"""Settings read from text: pydantic models, with problems in plain words and their places."""

from __future__ import annotations

import re
import tomllib
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import BaseModel, ConfigDict, Field, Tag, ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.file_names import is_reserved
from vrcomfort.json_text import MOST_NESTED, is_nested_deeper
from vrcomfort.settings.locate import Path as KeyPath
from vrcomfort.settings.locate import locate

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
    """Return `` did you mean `x`?`` for the nearest known word, or a list of the known words."""
    choices = sorted(known)
    near = get_close_matches(word, choices, n=1, cutoff=0.6)
    if near:
        return f"did you mean `{near[0]}`?"
    return f"known here: {', '.join(choices)}" if choices else "nothing is known here"


_RENAMED = {"rings": "samples", "taps": "samples"}
"""Settings of earlier versions → their present names."""


def renamed(key: str, known: Iterable[str]) -> str | None:
    """Return the present name of a setting of an earlier version, where it is known here."""
    now = _RENAMED.get(key)
    if now not in set(known):
        return None
    return f"`{key}` is `{now}` since there is one dial for it: write `{now} = 36`, or leave it out"


def wrong_unit(key: str, known: Iterable[str]) -> str | None:
    """Say which unit is wanted where `key` is a known key with another unit or without one."""
    stem, unit = _split_unit(key)
    for name in known:
        if not name.startswith(stem):
            continue
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


Model = TypeVar("Model", bound=BaseModel)

MOST_CHARACTERS = 2**22
"""Of a TOML text; protocols have some thousands."""
_DOTTED = re.compile(
    rf"""(?<![\w"'.-])(?>(?>[\w-]+|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{MOST_NESTED}}}"""
)
"""A key of more parts than tables may stand in each other."""
_QUOTED = re.compile("'([^']*)'")
_PLACE = re.compile(r" \(at line (\d+), column (\d+)\)$")
_REMEDIES = (
    ("overwrite a value", "this key is there already: keep one of the lines"),
    ("twice", "put a table's keys below one heading, or write [[…]] above entries of a list"),
    ("Invalid value", 'a text needs quotes ("…"), true and false small letters'),
    ("Unterminated string", "close the quotes"),
    ("character '\\n'", "close the quotes in the same line"),
    ("after a statement", "a text needs quotes, a comment #, and each key a line of its own"),
    ("'=' after a key", "write key = value"),
    ("Unclosed array", "close the list with ], and put commas between its values"),
    ("Unclosed inline table", "close the table with } in the same line"),
    ("end of a table declaration", "close the heading with ], of a list with ]]"),
    ("Unescaped '\\'", "write / for \\ in paths"),
    ("Invalid hex value", "write / for \\ in paths"),
    ("character for a key part", "write a key, or take the comma before } away"),
    ("Invalid statement", "a line is key = value, [a heading] or # a comment"),
)
"""Part of what the parser says → what to do."""
_NAME, _WORD = r"^[A-Za-z0-9_-]+$", r"^[a-z][a-z0-9_]*$"
_LONGEST_SHOWN = 60
_PATTERNS = {
    _NAME: "may have only letters, digits, - and _",
    _WORD: "must start with a small letter; then small letters, digits and _",
}
Name = Annotated[str, Field(pattern=_NAME)]
Word = Annotated[str, Field(pattern=_WORD)]


class Settings(BaseModel):
    """A frozen table of a settings file; unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=False)


def union_tag(name: str) -> str:
    """Return the tag of a table that may be one of several kinds: no key of a file is like it."""
    return f"<{name}>"


def is_union_tag(part: str | int) -> bool:
    """Return whether a part of a key path is no key of the file, but says which kind it is."""
    return isinstance(part, str) and part.startswith("<")


MOST_TOLD = 100
"""Faults of one file."""


@dataclass(frozen=True)
class Problem:
    """One fault and the key path where it stands."""

    path: KeyPath
    message: str
    missing: bool = False


def parse_settings(model: type[Model], text: str, file: Path | None) -> Model:
    """Return the settings written in `text`.

    Raises
    ------
    InputError
        If it is not TOML, or a key or value is wrong, with line and column.
    """
    data = read_toml(text, file)
    return parse_data(model, data, lambda found: first_problem(found, text, file))


def parse_data(
    model: type[Model],
    data: Mapping[str, Any],
    refuse: Callable[[Iterable[Problem]], InputError],
) -> Model:
    """Return the settings of a table; `refuse` makes the error of its problems."""
    try:
        # Strict: "900" is not a number and true is not 1. Lists become tuples, which strict wants.
        return model.model_validate(_frozen(data), strict=True)
    except ValidationError as error:
        raise refuse(problems_of(model, error)) from error


def problems_of(model: type[BaseModel], error: ValidationError) -> list[Problem]:
    """Return pydantic's problems with a table, in the words of TOML."""
    found = _causes(error.errors())
    return _without_echoes(
        [_explain(model, each, near=place < MOST_TOLD) for place, each in enumerate(found)]
    )


def _without_echoes(found: list[Problem]) -> list[Problem]:
    """Drop "missing key" problems for keys that are present but misspelt."""
    return [
        each
        for each in found
        if not each.missing
        or not any(
            other.path[:-1] == each.path[:-1] and f"`{each.path[-1]}`" in other.message
            for other in found
            if not other.missing
        )
    ]


def first_problem(found: Iterable[Problem], text: str, file: Path | None) -> InputError:
    """Return the fault that stands first in the text; the others are its `others`.

    What is missing comes last: it is often there, misspelt.
    """
    places = locate(text)
    return problems_at(found, lambda path: SourcePlace(0, file, *places.of(path)))


class SourcePlace(NamedTuple):
    """Where something stands; places of several files sort by `part` first."""

    part: int
    file: Path | None
    line: int
    column: int


def problems_at(
    found: Iterable[Problem], place_of: Callable[[Sequence[str | int]], SourcePlace]
) -> InputError:
    """Return the fault that stands first; the `MOST_TOLD` after it are its `others`.

    See `first_problem`.
    """

    def moment(problem: Problem) -> tuple[bool, int, int, int]:
        place = place_of(problem.path)
        return problem.missing, place.part, place.line, place.column

    errors = []
    for each in sorted(found, key=moment)[: MOST_TOLD + 1]:
        _, file, line, column = place_of(each.path)
        errors.append(InputError(each.message, file=file, line=line, column=column))
    first, others = errors[0], errors[1:]
    return InputError(
        first.message, file=first.file, line=first.line, column=first.column, others=others
    )


def read_toml(text: str, file: Path | None) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    InputError
        If it is not TOML, has more than `MOST_CHARACTERS`, or is nested deeper than `MOST_NESTED`.
    """
    too_deep = InputError("this TOML is nested too deep; write it flatter", file=file)
    if len(text) > MOST_CHARACTERS:
        message = f"this TOML has {len(text):,} characters, and may have {MOST_CHARACTERS:,}"
        raise InputError(f"{message}; is it the right file?", file=file)
    if _DOTTED.search(text):  # the parser's memory grows with the square of a key's length
        raise too_deep
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise too_deep from None
    except ValueError as error:  # TOMLDecodeError is one, and so are numbers of 5000 digits
        message = str(error)
        place = _PLACE.search(message)
        line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, None)
        found = _PLACE.sub("", message)
        hint = next((said for part, said in _REMEDIES if part in found), "")
        what = f"this is not valid TOML: {found}{hint and f'; {hint}'}"
        raise InputError(what, file=file, line=line, column=column) from error
    if is_nested_deeper(content, MOST_NESTED):
        raise too_deep
    return content


def _frozen(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _frozen(item) for key, item in value.items()}
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def _causes(details: list[ErrorDetails]) -> list[ErrorDetails]:
    """Leave out lists that are too short only because an entry of theirs is wrong."""
    parents = {detail["loc"][:depth] for detail in details for depth in range(len(detail["loc"]))}
    return [d for d in details if d["type"] != "too_short" or d["loc"] not in parents]


def _explain(model: type[BaseModel], detail: ErrorDetails, *, near: bool) -> Problem:
    """Turn pydantic's finding into a sentence for the writer of the file.

    Parameters
    ----------
    near
        Whether to look for the key that was meant, which takes a while.
    """
    tagged = detail["loc"]
    *parent, key = path = tuple(part for part in tagged if not is_union_tag(part))
    if detail["type"] == "extra_forbidden":
        known = fields_at(model, tagged[:-1])
        better = renamed(str(key), known) or wrong_unit(str(key), known)
        meant = f"; {did_you_mean(str(key), known)}" if near else ""
        return Problem(path, better or f"unknown key `{key}`{meant}")
    if detail["type"] == "missing":
        return Problem(path, f"`{key}` is missing{_inside(parent)}; add it", missing=True)
    given = detail["input"]
    got = f", got {_shortened(given)}" if isinstance(given, str | int | float | bool) else ""
    name = next((part for part in reversed(path) if isinstance(part, str)), "this file")
    return Problem(path, f"`{name}`: {in_words(detail)}{got}{_nearest(detail)}")


def _shortened(given: str | float) -> str:
    """Return a value as it is shown in a sentence: a long one by its beginning."""
    shown = repr(given)
    return shown if len(shown) <= _LONGEST_SHOWN else f"{shown[:_LONGEST_SHOWN]} …"


def _nearest(detail: ErrorDetails) -> str:
    """Return which of the words that can stand there was probably meant."""
    if detail["type"] != "literal_error" or not isinstance(detail["input"], str):
        return ""
    near = get_close_matches(detail["input"], _QUOTED.findall(detail["ctx"]["expected"]), n=1)
    return f"; did you mean `{near[0]}`?" if near else ""


def _inside(parent: list[str | int]) -> str:
    names = [str(part) for part in parent if isinstance(part, str)]
    return f" in [{'.'.join(names)}]" if names else ""


def in_words(detail: ErrorDetails) -> str:
    """Return pydantic's finding in the words of TOML; it follows the name of a key."""
    if detail["type"] == "too_short":
        return f"needs at least {detail['ctx']['min_length']}"
    if detail["type"] in ("model_type", "model_attributes_type", "dict_type"):
        return "should be a table { key = value, ... }"
    if detail["type"] in ("tuple_type", "list_type"):
        return "should be a list [...]"
    if detail["type"] == "string_pattern_mismatch":
        return _PATTERNS[detail["ctx"]["pattern"]]
    message = (
        detail["msg"].removeprefix("Input ").removeprefix("Value error, ").replace("a valid ", "a ")
    )
    return message.replace("a integer", "a whole number")


def repeated(path: KeyPath, names: Iterable[str]) -> Iterator[Problem]:
    """Yield a problem for each name that is there a second time, also in another case."""
    seen: dict[str, list[str]] = {}
    for index, name in enumerate(names):
        alike = seen.setdefault(name.casefold(), [])
        alike.append(name)
        if alike.count(name) == 2:
            yield Problem((*path, index), f"`{name}` is there twice; give each a name of its own")
        elif alike[0] != name and alike.count(name) == 1:
            message = f"`{alike[0]}` and `{name}` are one name to some file systems"
            yield Problem((*path, index), f"{message}; let more than the case differ")


def reserved(path: KeyPath, name: str) -> Iterator[Problem]:
    """Yield a problem if no file or folder on Windows can have a name."""
    if is_reserved(name):
        message = f"Windows takes `{name}` for a device; choose another name"
        yield Problem(path, message)
