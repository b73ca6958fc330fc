"""Writes characters that break lines, rows and files so that people see them."""

from __future__ import annotations

import re

_BREAKING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")
"""Control characters but tab and line feed, other ends of lines, and halves of pairs.

Halves are also what Python makes of the bytes of arguments and names of files that are no UTF-8.
"""


def visible(text: str, hidden: re.Pattern[str] = _BREAKING) -> str:
    r"""Return a text in which characters that break things are ``\u0000``: harmless and visible.

    Whatever people typed passes through here before it is written or shown.

    Parameters
    ----------
    hidden
        Finds single characters that are to be written so.
    """
    return hidden.sub(lambda found: f"\\u{ord(found[0]):04x}", text)
