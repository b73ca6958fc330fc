"""Parts headings into a question that several share, and what each asks of its own."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

_WORDS, _HEADINGS = 4, 3
"""Words of a question at the least, and headings that share it."""


class Stem(NamedTuple):
    """A heading: the question that others have, too (blank if there is none), and the rest."""

    stem: str
    rest: str


def shared_stems(headings: Sequence[str]) -> list[Stem]:
    """Return headings parted behind the longest question that at least three of them share."""
    ends = {h: [m.end() for m in re.finditer(r"\w+\W*", h)][_WORDS - 1 : -1] for h in headings}
    starts = Counter(heading[:end] for heading, places in ends.items() for end in places)
    found = []
    for heading in headings:
        shared = [end for end in ends[heading] if starts[heading[:end]] >= _HEADINGS]
        end = max(shared, default=0)
        found.append(Stem(heading[:end], heading[end:]))
    return found
