"""Stored JSON with odd content: each of its values removed, or in the place of another kind."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

Path = tuple[str | int, ...]

GONE = object()
LONG = "x" * 10_000
ODD: tuple[Any, ...] = (
    GONE, None, True, 7, -1.5, "", LONG, [], ["x"], {}, {"x": 1}, [[{"x": [1]}]],
)  # fmt: skip


def odd_versions(content: Any) -> Iterator[tuple[Path, Any]]:
    """Yield each place in JSON, the whole last, with each odd value."""
    for path in (*_paths(content), ()):
        for value in ODD:
            if path or value is not GONE:
                yield path, value


def with_odd(content: Any, path: Path, value: Any) -> Any:
    """Return a copy of JSON with `value` in one place, or without what was there."""
    if not path:
        return value
    changed = copy.deepcopy(content)
    holder = changed
    for key in path[:-1]:
        holder = holder[key]
    if value is GONE:
        del holder[path[-1]]
    else:
        holder[path[-1]] = value
    return changed


def _paths(value: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the places in JSON; of a list, only the first element's."""
    items: Any = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = list(enumerate(value))[:1]
    for key, each in items:
        yield (*path, key)
        yield from _paths(each, (*path, key))
