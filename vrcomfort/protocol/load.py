"""Reads a protocol file; every fault is one sentence with file, line and column."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.protocol.check import Problem, problems
from vrcomfort.protocol.hints import did_you_mean, fields_at, wrong_unit
from vrcomfort.protocol.locate import Places, locate
from vrcomfort.protocol.model import Protocol
from vrcomfort.resources import data_folder

_PLACE = re.compile(r" \(at line (\d+), column (\d+)\)$")


def load_protocol(name_or_path: str | Path) -> Protocol:
    """Read a protocol: a file, or the name of a shipped one such as ``carnegie_2015``.

    Raises
    ------
    InputError
        If the file is missing or not TOML, or a key or value is wrong, with line and column.
    """
    file = _find(name_or_path)
    try:
        text = file.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read this protocol: {error.strerror}", file=file) from error
    except UnicodeDecodeError as error:
        message = f"byte {error.start} is not UTF-8; save the protocol as UTF-8"
        raise InputError(message, file=file) from error
    return parse_protocol(text, file=file)


def parse_protocol(text: str, *, file: Path | None = None) -> Protocol:
    """Return the protocol written in `text`; `file` is where relative scene files are looked for.

    Raises
    ------
    InputError
        As `load_protocol`.
    """
    data = _toml(text, file)
    try:
        # Strict: "900" is not a number and true is not 1. Lists become tuples, which strict wants.
        protocol = Protocol.model_validate(_frozen(data), strict=True)
    except ValidationError as error:
        found = [_explain(detail) for detail in error.errors()]
        raise _first(found, locate(text), file) from error
    protocol._text, protocol._file = text, file
    if found := list(problems(protocol)):
        raise _first(found, locate(text), file)
    return protocol


def _find(name_or_path: str | Path) -> Path:
    path = Path(name_or_path)
    if path.is_file():
        return path
    shipped = {file.stem: file for file in data_folder("protocols").glob("*.toml")}
    if str(name_or_path) in shipped:
        return shipped[str(name_or_path)]
    hint = did_you_mean(path.stem, shipped)
    raise InputError(f"there is no protocol file or shipped protocol `{name_or_path}`; {hint}")


def _toml(text: str, file: Path | None) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        place = _PLACE.search(message)
        line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, None)
        what = f"this is not valid TOML: {_PLACE.sub('', message)}"
        raise InputError(what, file=file, line=line, column=column) from error


def _frozen(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _frozen(item) for key, item in value.items()}
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def _first(found: list[Problem], places: Places, file: Path | None) -> InputError:
    """Return the fault that stands first in the file, and say how many follow.

    What is missing comes last: it is often there, misspelt.
    """
    first = min(found, key=lambda problem: (problem.missing, places.of(problem.path)))
    (line, column), message = places.of(first.path), first.message
    more = len(found) - 1
    tail = f" ({more} more problem{'s' if more > 1 else ''} in this file)" if more else ""
    return InputError(f"{message}{tail}", file=file, line=line, column=column)


def _explain(detail: ErrorDetails) -> Problem:
    """Turn pydantic's finding into a sentence for the writer of the file."""
    *parent, key = path = detail["loc"]
    if detail["type"] == "extra_forbidden":
        known = fields_at(Protocol, parent)
        unit = wrong_unit(str(key), known)
        return Problem(path, unit or f"unknown key `{key}`; {did_you_mean(str(key), known)}")
    if detail["type"] == "missing":
        return Problem(path, f"`{key}` is missing{_inside(parent)}; add it", missing=True)
    given = detail["input"]
    got = f", got {given!r}" if isinstance(given, str | int | float | bool) else ""
    name = next((part for part in reversed(path) if isinstance(part, str)), "this file")
    return Problem(path, f"`{name}`: {_lower(detail['msg'])}{got}")


def _inside(parent: list[str | int]) -> str:
    names = [str(part) for part in parent if isinstance(part, str)]
    return f" in [{'.'.join(names)}]" if names else ""


def _lower(message: str) -> str:
    message = message.replace("Input should be a valid", "Input should be a")
    return message.removeprefix("Input ") if message.startswith("Input") else message.lower()
