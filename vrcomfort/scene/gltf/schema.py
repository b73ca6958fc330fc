"""Makes sure that a glTF file's JSON is what the loader takes it for; every fault has its place.

What the buffers hold is checked where it is read.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.scene.gltf.parts import Root

_LISTS = ("accessors", "buffers", "bufferViews", "images", "materials", "meshes", "nodes",
          "samplers", "scenes", "skins", "textures")  # fmt: skip
_LAMPS = "KHR_lights_punctual"
_INNER = {"primitives", "children", "nodes", "channels", "samplers", "joints"}
_AT_ONCE = 4096


def check_structure(root: dict[str, Any], path: Path) -> None:
    """Make sure that a file's JSON is what the loader takes it for.

    Raises
    ------
    InputError
        Says what is wrong, and of which node, material, … by number and name.
    """
    context = _counts(root)
    for part, start in _slices(root):
        try:
            Root.model_validate(part, context=context)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            where = _in_the_whole(first["loc"], start)
            message = f"{place(root, where)} {_in_words(first)}; export the file again"
            raise InputError(message, file=path) from None


def count_items(root: dict[str, Any]) -> int:
    """Return how many parts a file's JSON has, whether they are what they need to be or not."""
    lists = [items for items in root.values() if isinstance(items, list)]
    lamps = _extension(root).get("lights")
    inner = [
        each[key]
        for items in lists
        for each in items
        if isinstance(each, dict)
        for key in _INNER & each.keys()
        if isinstance(each[key], list)
    ]
    return sum(map(len, [*lists, *inner, lamps if isinstance(lamps, list) else []]))


def _slices(root: dict[str, Any]) -> Iterator[tuple[dict[str, Any], int]]:
    """Yield the JSON in parts of a few thousand items, and where in its list the part starts.

    What checks an item takes many times its memory.
    """
    yield {key: value for key, value in root.items() if not isinstance(value, list)}, 0
    for key, items in root.items():
        if isinstance(items, list):
            for start in range(0, max(len(items), 1), _AT_ONCE):
                yield {key: items[start : start + _AT_ONCE]}, start


def _in_the_whole(location: tuple[int | str, ...], start: int) -> tuple[int | str, ...]:
    if len(location) > 1 and isinstance(location[1], int):
        return (location[0], location[1] + start, *location[2:])
    return location


def _counts(root: dict[str, Any]) -> dict[str, int]:
    """Return how many items each list has that is referred to; 0 for what is no list."""
    found: dict[str, Any] = {key: root.get(key) for key in _LISTS}
    found["lights"] = _extension(root).get("lights")
    return {key: len(items) if isinstance(items, list) else 0 for key, items in found.items()}


def _extension(root: dict[str, Any]) -> dict[str, Any]:
    """Return what the file says of lamps, or an empty dict."""
    extensions = root.get("extensions")
    lamps = extensions.get(_LAMPS) if isinstance(extensions, dict) else None
    return lamps if isinstance(lamps, dict) else {}


def place(root: dict[str, Any], location: tuple[int | str, ...]) -> str:
    """Return a place in the JSON as people write it, with the names of what it is in."""
    words, value = "", root
    for part in location:
        words += f"[{part}]" if isinstance(part, int) else f".{part}" if words else part
        try:
            value = value[part]  # type: ignore[index]  # any JSON
        except (KeyError, IndexError, TypeError):
            continue
        name = value.get("name") if isinstance(value, dict) else None
        words += f" ({name!r})" if isinstance(name, str) else ""
    return words


def places_of(root: dict[str, Any], extension: str) -> Iterator[str]:
    """Yield the places in the JSON that use an extension, in words."""
    waiting: list[tuple[tuple[int | str, ...], Any]] = [((), root)]
    while waiting:
        location, value = waiting.pop()
        if isinstance(value, dict):
            if location and extension in (value.get("extensions") or {}):
                yield place(root, location)
            inner = list(value.items())
        else:
            inner = list(enumerate(value)) if isinstance(value, list) else []
        waiting += [((*location, key), each) for key, each in reversed(inner)]


def _in_words(detail: ErrorDetails) -> str:
    context = detail.get("ctx", {})
    if detail["type"] == "missing":
        return "is missing"
    if detail["type"] in ("too_short", "too_long"):
        needed = context.get("min_length", context.get("max_length"))
        return f"has {context['actual_length']} numbers, but needs {needed}"
    return detail["msg"].removeprefix("Input ").replace("a valid ", "a ")
