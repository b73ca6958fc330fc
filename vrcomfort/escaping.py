"""Escapes characters that break lines, rows or files."""

from __future__ import annotations

import re

_UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
"""Control characters but tab and line feed, other line separators, and lone surrogates.

Python also makes surrogates of bytes that are not UTF-8 in arguments and names of files.
"""


def escape_unprintable(text: str, hidden: re.Pattern[str] = _UNPRINTABLE) -> str:
    r"""Return a text with ``\u0000`` in place of each unprintable character.

    All text that people type passes through here before it is written or shown.

    Parameters
    ----------
    hidden
        Matches single characters to be escaped.
    """
    return hidden.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def is_utf8(text: str) -> bool:
    """Return whether a text has no lone surrogates, which UTF-8 does not have."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True
