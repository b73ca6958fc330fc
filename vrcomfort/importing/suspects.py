"""Names that may be one participant, written in two ways."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable

from vrcomfort.questionnaire import plain


def alike(names: Iterable[str]) -> list[list[str]]:
    """Return groups of names that differ in case, spaces, signs or leading zeros alone."""
    groups: dict[str, list[str]] = defaultdict(list)
    for name in names:
        groups[re.sub(r"(?<!\d)0+(?=\d)", "", plain(name))].append(name)
    return [group for group in groups.values() if len(group) > 1]


def suspects(names: Iterable[str]) -> list[str]:
    """Return a sentence for each group of names that may be one participant."""
    return [
        f"participants {', '.join(map(repr, group))} may be one person; they are kept apart "
        "(participant values in the mapping make them one)"
        for group in alike(names)
    ]
