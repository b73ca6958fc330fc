"""JSON Schemas of settings files, with what the source says of each key: for editors, and docs."""

from __future__ import annotations

import ast
import inspect
import textwrap
import typing
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import Any

from pydantic import BaseModel

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON Schema of a file whose table is `model`.

    Keys are described by the strings under them in the source. There is no null in TOML, so what
    may be absent is described as what it is where it is there.
    """
    schema = model.model_json_schema()
    for each in models_in(model):
        table = schema if each is model else schema.get("$defs", {}).get(each.__name__)
        if table is not None:
            _describe(table, each)
    return {"$schema": DIALECT, **_without_null(schema)}


def models_in(model: type[BaseModel]) -> list[type[BaseModel]]:
    """Return a model and all tables in it, in the order in which they are first met."""
    found = [model]
    for each in found:  # grows on the way
        for field in each.model_fields.values():
            found += [inner for inner in _models(field.annotation) if inner not in found]
    return found


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in typing.get_args(annotation):
        yield from _models(part)


@cache
def key_texts(model: type[BaseModel]) -> dict[str, str]:
    """Return key → the string that stands under it in the source, its own or that of a base."""
    texts: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if not issubclass(base, BaseModel) or base.__module__.startswith("pydantic"):
            continue
        try:
            source = inspect.getsource(base)
        except OSError:  # of `create_model`, whose fields have their descriptions
            continue
        (tree,) = ast.parse(textwrap.dedent(source)).body
        body = tree.body if isinstance(tree, ast.ClassDef) else []
        for key, text in pairwise(body):
            if isinstance(key, ast.AnnAssign) and isinstance(key.target, ast.Name):
                if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
                    texts[key.target.id] = in_one_line(str(text.value.value))
                else:
                    texts.pop(key.target.id, None)
    return texts


def in_one_line(text: str) -> str:
    """Return a text without the line breaks of the source."""
    return " ".join(text.split())


def _describe(table: dict[str, Any], model: type[BaseModel]) -> None:
    texts = key_texts(model)
    if model.__doc__:
        table["description"] = inspect.cleandoc(model.__doc__)
    for key, entry in table.get("properties", {}).items():
        entry.pop("title", None)
        if key in texts:
            entry["description"] = texts[key]


def _without_null(part: Any) -> Any:
    if isinstance(part, list):
        return [_without_null(each) for each in part]
    if not isinstance(part, dict):
        return part
    kept = {key: _without_null(value) for key, value in part.items() if not _is_null(key, value)}
    choices = kept.get("anyOf")
    if isinstance(choices, list):
        there = [each for each in choices if each != {"type": "null"}]
        kept["anyOf"] = there
        if len(there) == 1:
            del kept["anyOf"]
            kept = {**there[0], **kept}
    return kept


def _is_null(key: str, value: Any) -> bool:
    return key == "default" and (value is None or isinstance(value, dict))


def or_one_table(schema: dict[str, Any]) -> None:
    """Let the schema of a list of tables take a single table, too: `[name]` for `[[name]]`."""
    array = {key: schema.pop(key) for key in ("type", "items")}
    schema["anyOf"] = [array, array["items"]]
