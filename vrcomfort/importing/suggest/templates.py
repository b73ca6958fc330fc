"""Says several questionnaires whose headings are made alike in one: ``{condition}_{item}``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import NamedTuple

from vrcomfort.importing.mapping import template_pattern

_ITEM = "{item}"
_PART = re.compile(r"[^\W_]+|[\W_]+")


class Template(NamedTuple):
    """Headings of several questionnaires.

    Parameters
    ----------
    heading
        With ``{item}``, and ``{condition}`` and the like where they differ.
    items
        Item → what stands for it.
    values
        Fact → text in the heading → what it means.
    """

    heading: str
    items: dict[str, str]
    values: dict[str, dict[str, str]]


def template_of(
    headings: Sequence[Mapping[str, str]],
    facts: Sequence[Mapping[str, str]],
    others: Sequence[str],
) -> Template | None:
    """Return how headings are made; None where no one template says exactly these.

    Parameters
    ----------
    headings
        For each questionnaire, item → heading.
    facts
        For each questionnaire, what its headings say.
    others
        All other headings of the table, of which the template must take none.
    """
    split = [_split(each) for each in headings]
    items = split[0][2]
    if len(headings) < 2 or any(found != items for _, _, found in split):
        return None
    sides = [[*_PART.findall(left), _ITEM, *_PART.findall(right)] for left, right, _ in split]
    if len({len(side) for side in sides}) > 1:
        return None
    parts: list[str] = []
    values: dict[str, dict[str, str]] = {}
    for texts in zip(*sides, strict=True):
        if len(set(texts)) == 1:
            parts.append(texts[0])
            continue
        fact = _fact_of(texts, facts, values)
        if fact is None:
            return None
        values[fact] = {t: each[fact] for t, each in zip(texts, facts, strict=True)}
        parts.append(f"{{{fact}}}")
    found = Template("".join(parts), dict(items), values)
    whole = all(set(each) == set(values) for each in facts)
    return found if whole and _says(found, headings, others) else None


def _split(headings: Mapping[str, str]) -> tuple[str, str, dict[str, str]]:
    """Return what all headings begin and end with, and what stands between."""
    texts = list(headings.values())
    left = _common_start(texts)
    right = _common_start([text[len(left) :][::-1] for text in texts])[::-1]
    left = left[: len(left) - len(_tail(left))]
    right = right[len(_head(right)) :]
    end = -len(right) or None
    return left, right, {item: text[len(left) : end] for item, text in headings.items()}


def _common_start(texts: Sequence[str]) -> str:
    """Return the letters with which all texts begin."""
    same = takewhile(lambda letters: len(set(letters)) == 1, zip(*texts, strict=False))
    return "".join(letters[0] for letters in same)


def _tail(text: str) -> str:
    """Return the letters at the end, which may belong to the items."""
    found = re.search(r"[^\W_]+$", text)
    return found[0] if found else ""


def _head(text: str) -> str:
    found = re.match(r"[^\W_]+", text)
    return found[0] if found else ""


def _fact_of(
    texts: Sequence[str], facts: Sequence[Mapping[str, str]], taken: Mapping[str, object]
) -> str | None:
    """Return the fact that goes with the texts: one value for each, and another for another."""
    for fact in dict.fromkeys(name for each in facts for name in each):
        pairs = {(text, each.get(fact)) for text, each in zip(texts, facts, strict=True)}
        known = {text for text, value in pairs if value is not None}
        if fact not in taken and len(pairs) == len(known) == len(set(texts)):
            return fact
    return None


def _says(found: Template, headings: Sequence[Mapping[str, str]], others: Sequence[str]) -> bool:
    """Return whether a template takes exactly these headings, each for its item."""
    pattern = template_pattern(found.heading)
    pieces = {piece: item for item, piece in found.items.items()}
    for each in headings:
        for item, heading in each.items():
            match = pattern.fullmatch(heading)
            if match is None or pieces.get(match["item"]) != item:
                return False
            if any(match[fact] not in texts for fact, texts in found.values.items()):
                return False
    matches = (pattern.fullmatch(heading) for heading in others)
    return not any(match is not None and match["item"] in pieces for match in matches)
