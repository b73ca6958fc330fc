"""Sorting names as people do: P2 before P10."""

from __future__ import annotations

import re
from functools import lru_cache

_NUMBER = re.compile(r"(\d+)")


@lru_cache(maxsize=65536)
def natural(text: str) -> tuple[tuple[int, int, str], ...]:
    """Return a sorting key in which runs of digits count as numbers."""
    parts = _NUMBER.split(text)
    numbers = ((0, int(p), "") if p.isdecimal() else (1, 0, p) for p in parts if p)
    return (*numbers, (-1, 0, text))  # P9 and P09 have an order too, the same each time
