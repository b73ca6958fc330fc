"""Writes values as TOML."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from datetime import date, time

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_key(key: str) -> str:
    """Return a key, in quotes where it needs them."""
    return key if _BARE.fullmatch(key) else toml_value(key)


def toml_value(value: object) -> str:
    """Return a value in one line of TOML.

    Raises
    ------
    TypeError
        If TOML has no such type.
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):  # those of NumPy are such, and would write their type
        return repr(int(value) if isinstance(value, int) else float(value))
    if isinstance(value, str):  # as JSON has it, and DEL escaped
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs = [f"{toml_key(str(key))} = {toml_value(each)}" for key, each in value.items()]
        return f"{{ {', '.join(pairs)} }}" if pairs else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, date | time):
        return value.isoformat()
    raise TypeError(value)
