"""The JSON schema of settings, and a reference page of their keys."""

from __future__ import annotations

import ast
import inspect
import json
import sys
import typing
from collections.abc import Iterator, Mapping
from functools import cache
from itertools import pairwise
from typing import Any

from pydantic import BaseModel

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def json_schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON Schema of a file with `model` as its table.

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
            found += [inner for inner in tables_of(field.annotation) if inner not in found]
    return found


def tables_of(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the tables that a setting with this annotation may be, not those within them."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in typing.get_args(annotation):
        yield from tables_of(part)


@cache
def key_texts(model: type[BaseModel]) -> dict[str, str]:
    """Return key → the string that stands under it in the source, its own or that of a base."""
    texts: dict[str, str] = {}
    for base in reversed(model.__mro__):
        if not issubclass(base, BaseModel) or base.__module__.startswith("pydantic"):
            continue
        for key, text in pairwise(_classes_of(base.__module__).get(base.__name__, [])):
            if (
                isinstance(key, ast.AnnAssign)
                and isinstance(key.target, ast.Name)
                and isinstance(text, ast.Expr)
                and isinstance(text.value, ast.Constant)
            ):
                texts[key.target.id] = in_one_line(str(text.value.value))
    return texts


@cache
def _classes_of(module: str) -> dict[str, list[ast.stmt]]:
    """Return name → statements of the classes in a module's source.

    Those of `create_model` are in none; their fields have their descriptions.
    """
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except OSError:  # a file that is gone
        return {}
    return {each.name: each.body for each in tree.body if isinstance(each, ast.ClassDef)}


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


Table = dict[str, Any]
Notes = Mapping[str, Mapping[str, str]]


def reference(model: type[BaseModel], notes: Notes | None = None) -> str:
    """Return a section for each table of a file: its keys, their values, and their defaults.

    Parameters
    ----------
    notes
        Class of a table → key → what is said after its meaning.
    """
    schema = json_schema(model)
    for name, texts in (notes or {}).items():
        for key, text in texts.items():
            entry = schema["$defs"][name]["properties"][key]
            entry["description"] = f"{entry.get('description', '')} {text}".strip()
    tables = schema.get("$defs", {})
    places = _places(schema, tables)
    parts = [_section("Top of the file", schema, tables)]
    for name, where in places.items():
        title = ", ".join(f"`{each}`" for each in where)
        if kind := tables[name]["properties"].get("kind", {}).get("const"):
            title = f'{title} with `kind = "{kind}"`'
        parts.append(_section(title, tables[name], tables, anchor=name))
    return "\n".join(parts)


def _places(schema: Table, tables: dict[str, Table]) -> dict[str, list[str]]:
    """Return name of a table → where it stands in a file, in the order of the file."""
    found: dict[str, list[str]] = {}

    def walk(table: Table, path: str) -> None:
        for key, entry in table.get("properties", {}).items():
            for name, listed in _tables_of(entry):
                at = f"{path}.{key}" if path else key
                new = name not in found
                found.setdefault(name, []).append(f"[[{at}]]" if listed else f"[{at}]")
                if new:
                    walk(tables[name], at)

    walk(schema, "")
    return found


def _tables_of(entry: Table) -> Iterator[tuple[str, bool]]:
    """Yield the tables that a key holds, and whether it is a list of them."""
    for part in (entry, *_choices(entry)):
        if "$ref" in part:
            yield _name(part), False
        for key in ("items", "additionalProperties"):
            inner = part.get(key)
            if isinstance(inner, dict):
                yield from ((name, key == "items") for name, _ in _tables_of(inner))


def _choices(entry: Table) -> list[Table]:
    """Return the allowed values of a key with several types."""
    return [*entry.get("anyOf", ()), *entry.get("oneOf", ())]


def _name(part: Table) -> str:
    return str(part["$ref"]).rsplit("/", 1)[1]


def _section(title: str, table: Table, tables: dict[str, Table], *, anchor: str = "") -> str:
    target = f'<a id="{anchor.lower()}"></a>\n' if anchor else ""
    lines = [f"{target}## {title}", in_one_line(table.get("description", "")), ""]
    lines += ["| key | value | default | meaning |", "|---|---|---|---|"]
    required = table.get("required", [])
    for key, entry in table.get("properties", {}).items():
        default = "**needed**" if key in required else _default(entry)
        meaning = _cell(entry.get("description", ""))
        lines.append(f"| `{key}` | {_value(entry, tables)} | {default} | {meaning} |")
    return "\n".join([*lines, ""])


def _default(entry: Table) -> str:
    default = entry.get("default")
    if default is None or default in ([], "", {}):
        return ""
    return f"`{json.dumps(default, ensure_ascii=False)}`"


def _value(entry: Table, tables: dict[str, Table]) -> str:
    if "$ref" in entry:
        return f"[table](#{_name(entry).lower()})"
    if _choices(entry):
        return " or ".join(_value(each, tables) for each in _choices(entry))
    choices = entry.get("enum") or ([entry["const"]] if "const" in entry else [])
    if choices:
        return ", ".join(f"`{json.dumps(each)}`" for each in choices)
    kind = entry.get("type")
    if kind == "array":
        return _array(entry, tables)
    if kind == "object":
        return f"table of name = {_value(entry['additionalProperties'], tables)}"
    return f"{_WORDS[str(kind)]}{_limits(entry)}"


_WORDS = {
    "integer": "whole number",
    "number": "number",
    "string": "text",
    "boolean": "`true`, `false`",
}


def _array(entry: Table, tables: dict[str, Table]) -> str:
    if "prefixItems" in entry:
        inner = ", ".join(_value(each, tables) for each in entry["prefixItems"])
        return f"[{inner}]"
    what = _value(entry.get("items", {}), tables)
    least, most = entry.get("minItems"), entry.get("maxItems")
    count = f", {least or 0} to {most}" if most else f", at least {least}" if least else ""
    return f"list of {what}{count}"


def _limits(entry: Table) -> str:
    low, above = entry.get("minimum"), entry.get("exclusiveMinimum")
    high, below = entry.get("maximum"), entry.get("exclusiveMaximum")
    words = []
    if low is not None:
        words.append(f"from {low:g}")
    if above is not None:
        words.append(f"above {above:g}")
    if high is not None:
        words.append(f"to {high:g}")
    if below is not None:
        words.append(f"below {below:g}")
    return f" {' '.join(words)}" if words else ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
