"""Sorting names as people do: P2 before P10."""

from __future__ import annotations

import re
from functools import lru_cache

from vrcomfort.csv_table import whole_or_none

_NUMBER = re.compile(r"(\d+)")


@lru_cache(maxsize=65536)
def natural(text: str) -> tuple[tuple[int, int, str], ...]:
    """Return a sorting key in which runs of digits count as numbers."""
    parts = _NUMBER.split(text)
    numbers = ((part, whole_or_none(part)) for part in parts if part)
    keys = ((1, 0, part) if number is None else (0, number, "") for part, number in numbers)
    return (*keys, (-1, 0, text))  # P9 and P09 have an order too, the same each time
