"""Reads and writes JSON of a study folder; what is not of its shape is told with its place."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.json_text import KeyPath, escape_surrogates, name_of, parse_json, place_of
from vrcomfort.records.schema import check_schema_version
from vrcomfort.settings import in_words, read_text

_ENCODER = json.JSONEncoder(ensure_ascii=False)


def read_json(file: Path, model: type[BaseModel], what: str) -> dict[str, Any]:
    """Return the content of a file that has the shape of `model`.

    Parameters
    ----------
    what
        The file in words: "manifest".

    Raises
    ------
    DamagedError
        If a value is missing or of another shape; numbers must be finite.
    InputError
        If it cannot be read, is no JSON, or a newer version of this program wrote it.
    """
    text = read_text(file, what)
    content = parse_json(text, file, what=what)
    if isinstance(content, dict):
        check_schema_version(content, file)  # first: a newer one may well have another shape
    path, fault = ((), "") if _is_finite(content) else next(_endless(content), ((), ""))
    if not fault:
        try:
            model.model_validate(content)
        except ValidationError as error:
            path, fault = _in_words(error.errors()[0])
    if fault:
        raise damaged(file, what, fault, text=text, path=path)
    return content if isinstance(content, dict) else {}


def indented(content: Mapping[str, Any]) -> str:
    """Return `json_of(content)`; parts that were written before take no time.

    A manifest is written a dozen times in a session, and most of it is what it was.
    """
    parts = (
        f"  {_key(key)}: {_indented(_ENCODER.encode(value))}" for key, value in content.items()
    )
    return escape_surrogates("{\n" + ",\n".join(parts) + "\n}")


@lru_cache(maxsize=256)
def _key(name: str) -> str:
    return _ENCODER.encode(name)


@lru_cache(maxsize=256)
def _indented(compact: str) -> str:
    """Return a value of a table, from its JSON in one line."""
    text = json.dumps(json.loads(compact), indent=2, ensure_ascii=False)
    return text.replace("\n", "\n  ")


class DamagedError(InputError):
    """JSON with a value that cannot be; `fault` says which and why."""

    fault = ""


def damaged(
    file: Path, what: str, fault: str, *, text: str = "", path: KeyPath = ()
) -> DamagedError:
    """Return the error for a value that cannot be, at `path` of `text`."""
    line, column = place_of(text, path) if text else (None, None)
    message = f"{fault}: this {what} is damaged; restore it"
    error = DamagedError(message, file=file, line=line, column=column)
    error.fault = fault
    return error


def _is_finite(content: Any) -> bool:
    """Return whether all numbers are: much faster than to walk through."""
    try:
        json.dumps(content, allow_nan=False)
    except ValueError:
        return False
    return True


def _endless(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, str]]:
    """Yield what Python reads and JSON does not have."""
    if isinstance(value, float) and not math.isfinite(value):
        yield path, f"{name_of(path)} is not a finite number"
    elif isinstance(value, dict | list):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _endless(each, (*path, key))


def _in_words(detail: ErrorDetails) -> tuple[KeyPath, str]:
    path = detail["loc"]
    if detail["type"] == "missing":
        return path[:-1], f"{name_of(path)} is missing"
    if detail["type"] in ("model_type", "model_attributes_type", "dict_type"):
        return path, f"{name_of(path)} should be an object {{...}}"
    return path, f"{name_of(path)}: {in_words(detail)}"
