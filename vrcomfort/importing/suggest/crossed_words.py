"""Finds the words for conditions that stand before, or behind, the same questions each."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence, Set
from dataclasses import replace

from vrcomfort.importing.suggest.found_answers import Context
from vrcomfort.importing.suggest.own_instruments import OwnQuestion
from vrcomfort.importing.suggest.vocabulary import LabVocabulary, tokens, words_of
from vrcomfort.questionnaire import plain

_MEANS = frozenset(["overall", "total", "mean", "average", "avg"])
"""Words before means over conditions."""
_ENDS = ((0, 1), (-1, None), (0, 2), (-2, None))
"""Where a word stands for a condition, or a word with its number: first, or last."""
_NUMBERED = ([[False], [False, True]], [[False], [False, True], [True]])
"""Which of the words is a number. One alone stands for a moment or condition if it is the first."""


def crossed(questions: Sequence[OwnQuestion], vocabulary: LabVocabulary) -> list[OwnQuestion]:
    """Return questions without the words for conditions, of one factor after the other."""
    found = [*questions]
    for start, end in _ENDS:
        while (once := _without_factor(found, start, end, vocabulary)) != found:
            found = once
    return found


def _without_factor(
    questions: Sequence[OwnQuestion], start: int, end: int | None, vocabulary: LabVocabulary
) -> list[OwnQuestion]:
    """Return questions without words at one end that others stand in the place of."""
    asking = vocabulary.asking_words | vocabulary.asking_sentences
    if any(each.how == "measure" for each in questions):
        asking |= vocabulary.asking_others | vocabulary.measures
    asking |= vocabulary.item_fillers
    groups: dict[Context, dict[tuple[str, Context], OwnQuestion]] = defaultdict(dict)
    for each in questions:
        words = words_of(each.text)
        said = tuple(word.casefold() for word in words[start:end])
        others = words[:start] if end is None else words[end:]
        if others and [word.isdecimal() for word in said] in _NUMBERED[start == 0]:
            groups[said][" ".join(others), each.context] = each
    found = [*questions]
    for said, own in groups.items():
        alike = [other for other in groups.values() if other.keys() == own.keys()]
        asked = {text for text, _ in own}  # at two moments, one question is still one
        rest = {word for text in asked for word in tokens(text)}
        asks = rest & asking or (len(said) > 1 and all(each.how != "name" for each in own.values()))
        if min(len(alike), len(asked)) < _FEWEST or {*said} & (asking | _MEANS) or not asks:
            continue  # a single question told apart by a word is several questions
        for (text, context), each in own.items():
            new = (*context, *said) if start == 0 else (*said, *context)
            code = "" if each.code in said or plain(each.code) == plain(text) else each.code
            found[found.index(each)] = replace(each, text=text, context=new, code=code)
    return found


_FEWEST = 2
"""Words that stand in one place, and questions that they stand beside."""


def differing(names: Sequence[Sequence[str]], asking: Set[str]) -> list[list[str]]:
    """Return for each name the words in which it differs from others that ask the same."""
    asked = [tuple(word if word in asking else "" for word in name) for name in names]
    alike: dict[tuple[str, ...], list[Sequence[str]]] = defaultdict(list)
    for key, name in zip(asked, names, strict=True):
        alike[key].append(name)
    return [
        [
            word
            for place, word in enumerate(name)
            if any(key) and len({other[place] for other in alike[key]}) > 1
        ]
        for key, name in zip(asked, names, strict=True)
    ]
