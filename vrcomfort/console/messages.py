"""What a page may send: read strictly, and refused in a sentence."""

from __future__ import annotations

import json
import math
from typing import Any

from vrcomfort.escaping import escape_unprintable
from vrcomfort.operator_interface import Command

LONGEST_CHARACTERS = 4096
"""Of a message; a note of a page's length fits."""

LONGEST_WORD = 100
ACTIONS_PER_S = 20
"""More than a person asks for."""


def read_command(message: str) -> Command | str:
    """Return what a page has sent, or the sentence that refuses it."""
    if len(message) > LONGEST_CHARACTERS:
        found, most = len(message), LONGEST_CHARACTERS
        return f"a message of {found} characters is too long; {most} is the most: shorten the text"
    try:
        content = json.loads(message)
    except (ValueError, RecursionError):
        return "a message is not JSON; reload the page"
    if not isinstance(content, dict):
        return "a message is not a JSON object; reload the page"
    if unknown := sorted(set(content) - {"id", "action", "step", "text", "value"}):
        return f"a message has {unknown[0][:LONGEST_WORD]!r}, which means nothing; reload the page"
    return _checked(content)


def _checked(content: dict[str, Any]) -> Command | str:
    for name in ("id", "action"):
        word = content.get(name)
        if not isinstance(word, str) or not 0 < len(word) <= LONGEST_WORD:
            return f"`{name}` of a message is no word; reload the page"
    step, text, value = content.get("step"), content.get("text", ""), content.get("value")
    if type(step) is not int or not 0 <= step < 10**9:
        return "`step` of a message is no number of a step; reload the page"
    if not isinstance(text, str):
        return "`text` of a message is no text; reload the page"
    numeric = isinstance(value, int | float) and not isinstance(value, bool)
    if value is not None and not (numeric and math.isfinite(value) and abs(value) < 1e9):
        return "`value` of a message is no number; reload the page"
    own_words = content["action"] == "write"  # kept to the letter, escaped: `one_line`
    said = text.strip() if own_words else escape_unprintable(" ".join(text.split()))
    number, action = (escape_unprintable(content[key]) for key in ("id", "action"))
    return Command(number, action, step, said, value)
