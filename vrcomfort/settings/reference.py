"""The reference of a settings file in Markdown, made from its JSON Schema."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import BaseModel

from vrcomfort.settings.schema import in_one_line, json_schema

Table = dict[str, Any]
Notes = Mapping[str, Mapping[str, str]]


def reference(model: type[BaseModel], notes: Notes | None = None) -> str:
    """Return a section for each table of a file: its keys, what they may be, and their defaults.

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
    """Return what a key may be, where it may be one of several things."""
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
