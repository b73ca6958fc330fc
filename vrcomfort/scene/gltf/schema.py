"""Makes sure that a glTF file's JSON is what the loader takes it for; every fault has its place.

What the buffers hold is checked where it is read.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from vrcomfort.errors import InputError
from vrcomfort.scene.gltf.parts import Root

_LISTS = ("accessors", "buffers", "bufferViews", "images", "materials", "meshes", "nodes",
          "samplers", "scenes", "textures")  # fmt: skip
_LAMPS = "KHR_lights_punctual"


def check_structure(root: dict[str, Any], path: Path) -> None:
    """Make sure that a file's JSON is what the loader takes it for.

    Raises
    ------
    InputError
        Says what is wrong, and of which node, material, … by number and name.
    """
    try:
        Root.model_validate(root, context=_counts(root))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        message = f"{place(root, first['loc'])} {_in_words(first)}; export the file again"
        raise InputError(message, file=path) from None


def _counts(root: dict[str, Any]) -> dict[str, int]:
    """Return how many items each list has that is referred to; 0 for what is no list."""
    found: dict[str, Any] = {key: root.get(key) for key in _LISTS}
    extensions = root.get("extensions")
    lamps = extensions.get(_LAMPS) if isinstance(extensions, dict) else None
    found["lights"] = lamps.get("lights") if isinstance(lamps, dict) else None
    return {key: len(items) if isinstance(items, list) else 0 for key, items in found.items()}


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


def _in_words(detail: ErrorDetails) -> str:
    context = detail.get("ctx", {})
    if detail["type"] == "missing":
        return "is missing"
    if detail["type"] in ("too_short", "too_long"):
        needed = context.get("min_length", context.get("max_length"))
        return f"has {context['actual_length']} numbers, but needs {needed}"
    return detail["msg"].removeprefix("Input ").replace("a valid ", "a ")
