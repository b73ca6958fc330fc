"""Reads timepoint and condition in headings of answers, and the template that headings share."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence, Set
from itertools import takewhile
from typing import NamedTuple

from vrcomfort.importing.mapping import template_pattern
from vrcomfort.importing.suggest.draft import CONDITIONS, TIMEPOINTS, OpenDoubt
from vrcomfort.importing.suggest.vocabulary import LabVocabulary

_ITEM = "{item}"
_PART = re.compile(r"[^\W_]+|[\W_]+")


def heading_facts(
    contexts: Sequence[tuple[str, ...]], vocabulary: LabVocabulary, *, numbers: str = "condition"
) -> tuple[list[dict[str, str]], list[OpenDoubt]]:
    """Return for each questionnaire of a row the facts that its headings say, and doubts.

    Parameters
    ----------
    numbers
        The fact that numbers are taken for that stand alone.
    """
    contexts = [tuple(_unglued(word, vocabulary) for word in each) for each in contexts]
    contexts = _without_numbers(_before_one_rest(contexts, vocabulary), vocabulary)
    if len(contexts) == 1:
        when = {vocabulary.timepoints[w] for w in contexts[0] if w in vocabulary.timepoints}
        return [{"timepoint": when.pop()} if len(when) == 1 else {}], []
    lettered, letters = _lettered(contexts)
    if letters:
        said, others = heading_facts(lettered, vocabulary, numbers=numbers)
        return said, [*others, letters]
    shared = set.intersection(*map(set, contexts))
    telling = _telling(contexts, vocabulary)
    if any(set(context) <= shared for context in contexts) and max(map(len, contexts)) <= 4:
        shared = set()  # such as Blur and No Blur
    # The baseline lacks words that all others share: nach Brille, nach Leinwand.
    worded = [c for c in contexts if {*c} - vocabulary.condition_fillers]
    later = [{*c} for c in worded if "baseline" not in map(vocabulary.timepoints.get, c)]
    alike = set[str]().union(*later).intersection(*later)
    if len(later) > 1 and all(c - alike for c in later):
        shared |= alike
    facts: list[dict[str, str]] = []
    doubts: list[OpenDoubt] = []
    for context in contexts:
        # Words for timepoints and numbers say something even where all headings have them.
        rest = [
            word
            for word in context
            if word not in shared or word in vocabulary.timepoints or word in vocabulary.numbered
        ]
        facts.append(_facts(rest, vocabulary, telling))
    _numbered_times(facts, doubts)
    _later(facts, doubts)
    _one_baseline(facts)
    _two_unnamed(facts, doubts)
    _first_before(facts, doubts)
    _name_the_rest(facts, doubts, numbers, contexts)
    return facts, doubts


def _without_numbers(
    contexts: Sequence[tuple[str, ...]], vocabulary: LabVocabulary
) -> list[tuple[str, ...]]:
    """Return words of headings without numbers and letters of blocks that words tell apart, too.

    Survey programs number the questions whose texts name conditions: ``2_Q7``, *Blur*.
    """
    if vocabulary.conditions.keys() & {word for context in contexts for word in context}:
        return [*contexts]

    def says(words: tuple[str, ...], place: int) -> bool:
        beside = {*words[place + 1 : place + 2]} & vocabulary.units
        before = [word for word in words[max(place - 1, 0) : place] if len(word) > 1]
        return bool(beside or {*before} & vocabulary.numbered.keys())

    bare = [
        tuple(w for n, w in enumerate(c) if not (w.isdecimal() or len(w) == 1) or says(c, n))
        if any(map(str.isdecimal, c))
        else c
        for c in contexts
    ]
    # Loops are counted: 1_Q7 of 60 Hz, 2_Q7 of 90 Hz.
    led = {c[0] for c in contexts if c and c[0].isdecimal()}
    if len({*bare}) < len({*contexts}) and led == {str(n + 1) for n in range(len(led))}:
        bare = [c[1:] if {*c[:1]} & led else c for c in contexts]
    return bare if len({*bare}) == len({*contexts}) else [*contexts]


def _telling(contexts: Sequence[Sequence[str]], vocabulary: LabVocabulary) -> set[str]:
    """Return the words that say a condition, as others stand in their place: ``VR`` beside ``AR``.

    Fillers do, and codes of two letters that could be timepoints: ``po`` beside ``pd`` and ``pe``.
    """
    told = {word for name in vocabulary.conditions for word in name.split("_")}
    if len({*map(len, contexts)}) > 1:
        return told
    fillers, times = vocabulary.condition_fillers, vocabulary.timepoints
    return told | {
        word
        for words in zip(*contexts, strict=True)
        for word in words
        if word in fillers or (word in times and len(word) <= _CODE)
        if any(w not in fillers and w not in times for w in words)
    }


_CODE = 2


def _unglued(word: str, vocabulary: LabVocabulary) -> str:
    """Return the timepoint at the end of a word such as ``qprae``, or else the word."""
    if word in vocabulary.timepoints or word in vocabulary.condition_fillers:
        return word
    ends = (when for when in vocabulary.timepoints if len(when) >= _LETTERS and word.endswith(when))
    found = max(ends, key=len, default=word)
    return found if len(word) - len(found) <= _GLUED else word


def _before_one_rest(
    contexts: Sequence[tuple[str, ...]], vocabulary: LabVocabulary
) -> list[tuple[str, ...]]:
    """Return words of headings with the moments alone in ``presick``, ``postsick``."""
    times = vocabulary.timepoints
    for place in range(min(map(len, contexts))):
        words = [context[place] for context in contexts]
        ends = [[n for n in range(_LETTERS, len(w)) if w[:n] in times] for w in words]
        said = [(w[: n[-1]], w[n[-1] :]) for w, n in zip(words, ends, strict=True) if n]
        moments, rests = {when for when, _ in said}, {rest for _, rest in said}
        if len(said) == len(contexts) and len(moments) > 1 and len(rests) == 1:
            pairs = zip(contexts, said, strict=True)
            contexts = [(*c[:place], when, *c[place + 1 :]) for c, (when, _) in pairs]
    return [*contexts]


def _lettered(
    contexts: Sequence[tuple[str, ...]],
) -> tuple[list[tuple[str, ...]], OpenDoubt | None]:
    """Return words of headings with the moments that V and N say in SSQV, or b and a; and ask."""
    for place in range(min(map(len, contexts))):
        words = {context[place] for context in contexts}
        stems = {word[:-1] for word in words}
        means = _ENDS.get(frozenset(word[-1] for word in words))
        # a and b may be conditions: not where b comes first.
        first = contexts[0][place][-1:] == next(iter(means or ""), None)
        named = len(stems) == 1 and (len(min(stems)) >= _LETTERS or stems == {""})
        if means and len(words) == 2 and named and first:
            shown = ", ".join(f"{word} {means[word[-1]]}" for word in sorted(words))
            found = [(*c[:place], means[c[place][-1]], *c[place + 1 :]) for c in contexts]
            question = f"Do {' and '.join(sorted(words))} say before and after exposure?"
            return found, OpenDoubt(question, shown, TIMEPOINTS)
    return [*contexts], None


_ENDS = {
    frozenset("vn"): {"v": "vorher", "n": "nachher"},
    frozenset("ba"): {"b": "before", "a": "after"},
}
_LETTERS, _GLUED = 3, 2
"""Letters of a timepoint that is known inside a word, and the most before it."""


def _facts(
    words: Sequence[str], vocabulary: LabVocabulary, telling: Set[str] = frozenset()
) -> dict[str, str]:
    numbered, timepoints = vocabulary.numbered, vocabulary.timepoints
    facts: dict[str, str] = {}
    rest: list[str] = []
    place = 0
    while place < len(words):
        word = words[place]
        following = words[place + 1] if place + 1 < len(words) else ""
        fact = numbered.get(word, "")
        if fact and following.isdecimal():
            facts[fact] = f"t{following}" if fact == "timepoint" else following
            place += 1
        elif word.isdecimal() and following in vocabulary.units and "timepoint" not in facts:
            facts["timepoint"] = f"{word}{following}"
            place += 1
        elif word in timepoints and "timepoint" not in facts and word not in telling:
            facts["timepoint"] = timepoints[word]
        elif word not in telling and timepoints.get(word, "") == facts.get("timepoint"):
            pass  # the question says again what its code says: SSQpre_1, BEFORE THE SESSION
        elif fact in {"", "timepoint"} and (
            word not in vocabulary.condition_fillers or word in telling
        ):
            rest.append(word)
        place += 1
    if rest:
        said = "_".join(rest)
        facts["condition"] = next(
            (n for n in vocabulary.conditions if f"_{n}_" in f"_{said}_"), said
        )
    return facts


def _later(facts: list[dict[str, str]], doubts: list[OpenDoubt]) -> None:
    """Call a moment such as ``30min`` beside before and after the recovery, and ask."""
    later = sorted({f["timepoint"] for f in facts if f.get("timepoint", "")[:1].isdecimal()})
    if len(later) != 1 or "recovery" in {f.get("timepoint") for f in facts}:
        return
    for each in facts:
        if each.get("timepoint") == later[0]:
            each["timepoint"] = "recovery"
    question = f"Is {later[0]!r} that long after exposure?"
    doubts.append(OpenDoubt(question, "it is: the timepoint recovery", TIMEPOINTS))


def _numbered_times(facts: list[dict[str, str]], doubts: list[OpenDoubt]) -> None:
    """Call T0, T1, T2 baseline, post and recovery, and ask."""
    said = sorted({f["timepoint"] for f in facts if f.get("timepoint", "")[1:].isdecimal()})
    if not said:
        return
    shown = _names_of_times(facts, said)
    question = "Which timepoints are T0, T1 …: before exposure, after it, later?"
    doubts.append(OpenDoubt(question, shown, TIMEPOINTS))


def _names_of_times(facts: Sequence[dict[str, str]], said: Sequence[str]) -> str:
    """Call timepoints baseline, post and recovery in their order; return what was called what."""
    names = dict(zip(said, ("baseline", "post", "recovery"), strict=False))
    for each in facts:
        when = each.get("timepoint", "")
        each["timepoint"] = names.get(when, when)
    return ", ".join(f"{old.upper()} {names.get(old, old)}" for old in said)


def _name_times(facts: Sequence[dict[str, str]], doubts: list[OpenDoubt]) -> None:
    """Take numbers for timepoints, and ask that in place of their meaning."""
    said = sorted({each["timepoint"] for each in facts}, key=lambda text: (len(text), text))
    shown = _names_of_times(facts, said)
    doubts[-1] = OpenDoubt(doubts[-1].question, f"timepoints: {shown}", TIMEPOINTS)


def _one_baseline(facts: list[dict[str, str]]) -> None:
    """Take other words of the only baseline for none of the conditions, which others say."""
    first = [each for each in facts if each.get("timepoint") == "baseline"]
    others = [each.get("condition") for each in facts if each not in first]
    if len(first) == 1 < len(others) and not {None, first[0].get("condition")} & {*others}:
        first[0].pop("condition", None)


def _two_unnamed(facts: list[dict[str, str]], doubts: list[OpenDoubt]) -> None:
    """Take two blocks of the same headings, the second marked with a number, for before, after."""
    bare = [f for f in facts if not f]
    second = [f for f in facts if {*f} == {"condition"}]
    second = [f for f in second if f["condition"].isdecimal() or f["condition"] == "p"]
    if len(facts) == 2 and len(bare) == 1 and len(second) == 1:
        bare[0]["timepoint"] = "baseline"
        second[0].pop("condition")
        second[0]["timepoint"] = "post"
        question = "The same items are asked twice in a row: are these before and after exposure?"
        doubts.append(
            OpenDoubt(question, "the first columns are baseline, the second post", TIMEPOINTS)
        )


def _first_before(facts: list[dict[str, str]], doubts: list[OpenDoubt]) -> None:
    """Take the first block, which says nothing, for before, where all others say after; and ask.

    So it is where several others say conditions. Likewise the last of two is after; of two, other
    words are those of their questions.
    """
    first, *others = facts
    bare, when = facts[-1], "post"
    later = all(each.get("timepoint", "baseline") != "baseline" for each in others)
    named = [f["condition"] for f in others if {*f} == {"condition"}]
    worded = len(others) == len({*named}) > 1 and not any(
        n.isdecimal() and len(n) < _CODE for n in named
    )
    if not first and (later or worded):
        bare, when = first, "baseline"
    elif len(facts) != 2 or bare or first.get("timepoint") != "baseline":
        return
    bare["timepoint"] = when
    if len(facts) == 2:
        for each in facts:
            each.pop("condition", None)
    place = "first" if bare is first else "last"
    question = f"Are the {place} answers, of which no heading says when, {_WHEN[when]} exposure?"
    doubts.append(OpenDoubt(question, "they are", TIMEPOINTS))


_WHEN = {"baseline": "before", "post": "after"}


def _name_the_rest(
    facts: list[dict[str, str]],
    doubts: list[OpenDoubt],
    fact: str,
    contexts: Sequence[Sequence[str]],
) -> None:
    """Ask for the meaning of numbers that stand alone; tell equal administrations apart."""
    first = [f for f in facts if "condition" not in f]
    others = {f["condition"] for f in facts if "condition" in f}
    if len(first) == 1 and others == {str(n) for n in range(2, len(facts) + 1)}:
        first[0]["condition"] = "1"  # forms number a question that comes again from the second on
    numbers = [f for f in facts if f.get("condition", "").replace("_", "").isdecimal()]
    if numbers:
        if any("timepoint" in f for f in numbers):
            fact = "condition"  # words say the moments
        shown = ", ".join(dict.fromkeys(f["condition"] for f in numbers))
        question = f"What do the numbers {shown} in the headings stand for?"
        doubts.append(OpenDoubt(question, f"each is a {fact}", CONDITIONS))
        for each in numbers:
            each[fact] = each.pop("condition")
        if fact == "timepoint":
            _name_times(numbers, doubts)
    several = len({f.get("condition", "") for f in facts}) > 1
    for place, each in enumerate(facts, start=1):
        nameless = several and "condition" not in each and each.get("timepoint") != "baseline"
        nameless = nameless and fact not in each
        if nameless or (not each and len(facts) > 1):
            said = "_".join(contexts[place - 1])  # words that else say nothing: VR
            alone = said[1:] and sum(tuple(c) == tuple(contexts[place - 1]) for c in contexts) == 1
            each["condition"] = said if alone else f"questionnaire_{place}"
            question = f"Of which condition is questionnaire {place} of a row?"
            doubts.append(OpenDoubt(question, f"`{each['condition']}`", CONDITIONS))


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
    """Return the common start and end of all headings, and the rest of each."""
    texts = list(headings.values())
    left = common_start(texts)
    right = common_start([text[len(left) :][::-1] for text in texts])[::-1]
    # Letters beside the rest may belong to the items.
    left, right = re.sub(r"[^\W_]+$", "", left), re.sub(r"^[^\W_]+", "", right)
    end = -len(right) or None
    return left, right, {item: text[len(left) : end] for item, text in headings.items()}


def common_start(texts: Sequence[str]) -> str:
    """Return the letters with which all texts begin."""
    same = takewhile(lambda letters: len(set(letters)) == 1, zip(*texts, strict=False))
    return "".join(letters[0] for letters in same)


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
