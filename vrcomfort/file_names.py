"""Names that are safe as files on every system, though they are made on one.

Source: Microsoft, "Naming Files, Paths, and Namespaces".
"""

from __future__ import annotations

import re

_RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³])(\..*)?", re.IGNORECASE)


def is_reserved(name: str) -> bool:
    """Return whether Windows reserves a name for a device, with any ending and case."""
    return _RESERVED.fullmatch(name) is not None


def same_file(a: str, b: str) -> bool:
    """Return whether two names are one file where case makes no difference."""
    return a.casefold() == b.casefold()
