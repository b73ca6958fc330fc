"""What the names of several files, or of sheets, say of their content."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from vrcomfort.importing.suggest.roles import timepoint

_PART = re.compile(r"([_\-\s.]+)")


@dataclass(frozen=True)
class NameParts:
    """How names are made.

    Parameters
    ----------
    template
        With ``{condition}`` and the like where they differ.
    texts
        Fact → the different texts that stand for it.
    """

    template: str
    texts: dict[str, list[str]]


def parts_of_names(names: Sequence[str], wanted: Sequence[str]) -> NameParts | None:
    """Return what differs between names, called by the wanted facts; None where nothing does.

    Timepoints are known by their words, sessions by theirs; of the rest, what differs most is
    the participant, where that is wanted.
    """
    split = [_PART.split(name) for name in names]
    if len(set(names)) < 2 or not wanted:
        return None
    if len({tuple(parts[1::2]) for parts in split}) > 1:  # made in different ways
        return _whole(names, wanted)
    columns = list(zip(*split, strict=True))
    differing = [i for i in range(0, len(columns), 2) if len(set(columns[i])) > 1]
    left = list(wanted)
    roles: dict[int, str] = {}
    for i in differing:
        if "timepoint" in left and all(timepoint(text) for text in columns[i]):
            roles[i] = "timepoint"
            left.remove("timepoint")
    for i in differing:
        session = all(re.fullmatch(r"(?i)(ses(sion)?|s|day|visit)\d+", t) for t in columns[i])
        if i not in roles and session and "session" in left and len(differing) > 1:
            roles[i] = "session"
            left.remove("session")
    rest = [i for i in differing if i not in roles]
    if "participant" in left and rest:
        most = max(rest, key=lambda i: len(set(columns[i])))
        roles[most] = "participant"
        left.remove("participant")
        rest.remove(most)
    if "condition" in left and rest:
        roles[rest[0]] = "condition"
        rest = rest[1:]
    return _made(columns, roles)


def _whole(names: Sequence[str], wanted: Sequence[str]) -> NameParts | None:
    fact = "condition" if "condition" in wanted else wanted[0]
    return NameParts(f"{{{fact}}}", {fact: list(dict.fromkeys(names))})


def _made(columns: Sequence[Sequence[str]], roles: dict[int, str]) -> NameParts | None:
    if not roles:
        return None
    parts = [
        f"{{{roles[i]}}}" if i in roles else column[0] if len(set(column)) == 1 else "{*}"
        for i, column in enumerate(columns)
    ]
    texts = {fact: list(dict.fromkeys(columns[i])) for i, fact in roles.items()}
    return NameParts("".join(parts), texts)
