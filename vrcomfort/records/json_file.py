"""Reads JSON that something may have damaged; every fault is one sentence with line and column."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from json.decoder import JSONDecoder
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.records.schema import check_schema_version
from vrcomfort.settings import in_words, read_text

KeyPath: TypeAlias = tuple[str | int, ...]

_ENCODER = json.JSONEncoder(ensure_ascii=False)
_SPACE = re.compile(r"[ \t\r\n]*")


def read_json(file: Path, model: type[BaseModel], what: str) -> dict[str, Any]:
    """Return the content of a file that has the shape of `model`.

    Parameters
    ----------
    what
        The file in words: "manifest".

    Raises
    ------
    InputError
        If it cannot be read, is no JSON, or a value is missing or of another shape; numbers must
        be finite.
    """
    text = read_text(file, what)
    content = _parse(text, file, what)
    if isinstance(content, dict):
        check_schema_version(content, file)  # first: a newer one may well have another shape
    path, fault = ((), "") if _is_writable(content) else next(_unwritable(content), ((), ""))
    if not fault:
        try:
            model.model_validate(content)
        except ValidationError as error:
            path, fault = _in_words(error.errors()[0])
    if fault:
        raise damaged(file, what, fault, text=text, path=path)
    return content if isinstance(content, dict) else {}


def indented(content: Mapping[str, Any]) -> str:
    """Return `json.dumps(content, indent=2)`; parts that were written before take no time.

    A manifest is written a dozen times in a session, and most of it is what it was.
    """
    parts = (
        f"  {_key(key)}: {_indented(_ENCODER.encode(value))}" for key, value in content.items()
    )
    return "{\n" + ",\n".join(parts) + "\n}"


@lru_cache(maxsize=256)
def _key(name: str) -> str:
    return _ENCODER.encode(name)


@lru_cache(maxsize=256)
def _indented(compact: str) -> str:
    """Return a value of a table, from its JSON in one line."""
    text = json.dumps(json.loads(compact), indent=2, ensure_ascii=False)
    return text.replace("\n", "\n  ")


def damaged(file: Path, what: str, fault: str, *, text: str = "", path: KeyPath = ()) -> InputError:
    """Return the error for a value that cannot be; `fault` says what is wrong."""
    line, column = _place(text, path) if text else (None, None)
    message = f"{fault}: this {what} is damaged; restore it"
    return InputError(message, file=file, line=line, column=column)


def _parse(text: str, file: Path, what: str) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        message = f"this {what} is damaged; restore it ({error.msg})"
        raise InputError(message, file=file, line=error.lineno, column=error.colno) from error
    except RecursionError:
        raise damaged(file, what, "it is nested too deep") from None
    except ValueError as error:  # a number of 5000 digits
        raise damaged(file, what, "a number is too long") from error


def _is_writable(content: Any) -> bool:
    """Return whether all of it can be written as it was read: much faster than to walk through."""
    try:
        json.dumps(content, allow_nan=False, ensure_ascii=False).encode()
    except (ValueError, RecursionError):
        return False
    return True


def _unwritable(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, str]]:
    """Yield what Python reads and no JSON in UTF-8 can hold."""
    if isinstance(value, float) and not math.isfinite(value):
        yield path, f"{_name(path)} is not a finite number"
    elif isinstance(value, str) and not _is_whole(value):
        yield path, f"{_name(path)} has half a character"
    elif isinstance(value, dict | list):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            if isinstance(key, str) and not _is_whole(key):
                yield path, "the name of a key has half a character"
            yield from _unwritable(each, (*path, key))


def _is_whole(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:  # half of a surrogate pair
        return False
    return True


def _name(path: Sequence[str | int]) -> str:
    return f"`{'.'.join(map(str, path))}`" if path else "the whole"


def _in_words(detail: ErrorDetails) -> tuple[KeyPath, str]:
    path = detail["loc"]
    if detail["type"] == "missing":
        return path[:-1], f"{_name(path)} is missing"
    if detail["type"] in ("model_type", "model_attributes_type", "dict_type"):
        return path, f"{_name(path)} should be an object {{...}}"
    return path, f"{_name(path)}: {in_words(detail)}"


def _place(text: str, path: KeyPath) -> tuple[int, int]:
    """Return the 1-based line and column of a value of a valid JSON text."""
    try:
        at = _offset(text, path)
    except (IndexError, ValueError):  # a path that the text does not have
        at = 0
    before = text[:at]
    return before.count("\n") + 1, at - before.rfind("\n")


def _offset(text: str, path: KeyPath, at: int = 0) -> int:
    at = _after_space(text, at)
    if not path:
        return at
    at, index = _after_space(text, at + 1), 0
    while True:
        key: str | int = index
        if isinstance(path[0], str):
            key, at = JSONDecoder().raw_decode(text, at)
            at = _after_space(text, at) + 1
        if key == path[0]:
            return _offset(text, path[1:], at)
        _, at = JSONDecoder().raw_decode(text, _after_space(text, at))
        at, index = _after_space(text, _after_space(text, at) + 1), index + 1


def _after_space(text: str, at: int) -> int:
    found = _SPACE.match(text, at)
    return found.end() if found else at
