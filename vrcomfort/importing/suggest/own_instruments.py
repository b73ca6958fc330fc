"""Declares the lab's own questions as instruments: those that are asked together are one."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import pairwise, product
from math import inf
from typing import NamedTuple

from vrcomfort.importing.suggest.draft import OWN, OpenDoubt, listed
from vrcomfort.importing.suggest.found_answers import Context, Found
from vrcomfort.importing.suggest.item_names import How, Named
from vrcomfort.importing.suggest.vocabulary import bare, free_name, tokens
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.questionnaire import Instrument, parse_instrument, plain, shipped_instruments
from vrcomfort.questionnaire.instrument_file import TAKEN

USUAL = (
    (0, 3), (1, 5), (0, 4), (-2, 2), (1, 7), (0, 6), (-3, 3), (1, 9), (0, 10), (1, 10), (-5, 5),
    (0, 20), (0, 100), (-50, 50), (-100, 100), (0, 150),
)  # fmt: skip
"""Lowest and highest answers of scales, the narrowest first."""
AGREEMENT, DEGREES = "agreement", "degrees"
"""Kinds of words in which questions are answered: numbers stand with the first one."""
_STEPS, FEWEST_OF_SERIES = (10, 20), 3
_LONGEST_NAME = 40
_SHOWN = 4
"""Questions that a doubt lists."""


class AnswerRange(NamedTuple):
    """The ends of the scale of a column's answers, and the step between them."""

    low: int
    high: int
    step: float = 1.0

    def __or__(self, other: AnswerRange) -> AnswerRange:
        return AnswerRange(
            min(self.low, other.low), max(self.high, other.high), min(self[2], other[2])
        )

    @property
    def usual(self) -> AnswerRange:
        """Return the narrowest usual scale with these answers."""
        fitting = (e for e in USUAL if e[0] <= self.low and self.high <= e[1])
        return AnswerRange(*next(fitting, (self.low, self.high)), self.step)


class TakenFor(NamedTuple):
    """What a column that nothing knows is taken for: a rating, or a measurement as it stands."""

    scale: AnswerRange
    measured: bool


@dataclass(frozen=True)
class OwnQuestion:
    """A column that asks, with the words around its item, and the code that stands before it.

    Parameters
    ----------
    how
        By what it was found: its name, or as nothing else knows it.
    words
        The kind of words in which it is answered, where it is.
    """

    column: int
    text: str
    context: Context
    code: str
    seen: AnswerRange
    said: AnswerRange | None
    how: How = "name"
    words: str = ""


def own_instruments(questions: Sequence[OwnQuestion]) -> list[Found]:
    """Return the lab's own questions as instruments: those that are asked together are one.

    What is measured in one administration is measured in all.
    """
    measured = {plain(each.text) for each in questions if each.how == "measure"}
    questions = [
        replace(each, how="measure", said=each.seen)
        if each.how == "left" and plain(each.text) in measured
        else each
        for each in questions
    ]
    met: dict[str, set[Context]] = defaultdict(set)
    for each in questions:
        met[plain(each.text)].add(each.context)
    groups: dict[tuple[str, str, str, frozenset[Context]], list[OwnQuestion]] = defaultdict(list)
    codes = Counter(each.code for each in questions)
    contexts_of = {key: frozenset(found) for key, found in met.items()}
    both = {AGREEMENT, DEGREES} <= {each.words for each in questions}
    for each in questions:
        words = each.words if both and each.words == DEGREES else ""
        code = each.code if codes[each.code] >= FEWEST_OF_SERIES and len(each.code) > 1 else ""
        kind = "own_measures" if each.how == "measure" else "own_questions"
        groups[kind, code, words, contexts_of[plain(each.text)]].append(each)
    found: list[Found] = []
    names: set[str] = {*shipped_instruments(), *TAKEN}
    for (kind, code, *_), group in groups.items():
        found += _blocks(name_of(code or kind, names), group)
    return found


def _blocks(name: str, group: Sequence[OwnQuestion]) -> list[Found]:
    """Return one instrument's questions for each administration."""
    items: dict[str, str] = {}
    scales: dict[str, AnswerRange] = {}
    taken: set[str] = {*TAKEN}
    for each in group:
        key = plain(each.text)
        items.setdefault(key, "") or items.update({key: name_of(each.text, taken)})
        scale = each.said or each.seen
        scales[key] = scales[key] | scale if key in scales else scale
    texts_of = {plain(each.text): each.text for each in reversed(group)}
    said = {plain(each.text) for each in group if each.said}
    known = {plain(each.text) for each in group if each.how == "name"}
    kinds: dict[int | None, dict[str, AnswerRange]] = defaultdict(dict)
    ruled = [scales[key] for key in scales if key in known - said]
    whole = reduce(lambda one, other: one | other, ruled).usual if ruled else None
    for key in (key for key in scales if key not in said):
        # Those that no rule knows widen no scale of others, and counts from 0 none from 1.
        low, high = scales[key].usual.low, scales[key].high
        within = whole is not None and whole.low == low and high <= whole.high
        kinds[None if key in known or within else low][key] = scales[key]
    for kind in kinds.values():
        scales |= together(kind)
    instrument = declared(name, [(items[k], texts_of[k], scales[k]) for k in items])
    found = []
    for context in dict.fromkeys(each.context for each in group):
        named = {
            items[plain(e.text)]: Named(e.column, name, items[plain(e.text)], e.how, (), ())
            for e in group
            if e.context == context
        }
        found.append(Found(instrument, context, named))
    return found


def together(scales: Mapping[str, AnswerRange]) -> dict[str, AnswerRange]:
    """Return usual scales, one for all questions of about as many steps.

    Means of answers, which have fractions, have one of their own.
    """
    found: dict[str, AnswerRange] = {}
    for (above, most), whole in product(pairwise((-inf, *_STEPS, inf)), (True, False)):
        alike = {
            k: s for k, s in scales.items() if above < s.high <= most and (s.step == 1) == whole
        }
        if alike:
            widest = reduce(lambda one, other: one | other, alike.values())
            found |= dict.fromkeys(alike, widest.usual)
    return found


def declared(name: str, items: Sequence[tuple[str, str, AnswerRange]]) -> Instrument:
    """Return an instrument of these items: name, text and scale."""
    return parse_instrument(declaration(name, items).text())


def questions_of(instrument: Instrument) -> dict[str, tuple[str, AnswerRange]]:
    """Return item → text and scale of an instrument that was declared."""
    said = ((item, item.answers) for item in instrument.items)
    return {i.name: (i.text, AnswerRange(int(a.low), int(a.high), a.step)) for i, a in said}


def declaration(name: str, items: Sequence[tuple[str, str, AnswerRange]]) -> TomlDraft:
    """Return how an instrument of these items is declared."""
    shared = Counter(scale for *_, scale in items).most_common(1)[0][0]
    short = name.replace("_", " ").capitalize()
    draft = TomlDraft({"name": name, "short": short, "title": f"{short}, as asked by the lab"})
    draft.put("answers", _answers(shared))
    draft.lists["items"] = [
        TomlDraft(
            {"name": item, "text": text} | ({} if scale == shared else {"answers": _answers(scale)})
        )
        for item, text, scale in items
    ]
    return draft


def _answers(scale: AnswerRange) -> dict[str, float]:
    return {"low": scale.low, "high": scale.high} | (
        {} if scale.step == 1 else {"step": scale.step}
    )


def ask_about(
    instrument: Instrument, headings: Sequence[str], among: Collection[str] = ()
) -> OpenDoubt:
    """Return the question whether these are the lab's own, on this scale: all items, or some."""
    items = [item for item in instrument.items if not among or item.name in among]
    answers = {(item.answers.low, item.answers.high) for item in items}
    shown = listed([*map(repr, headings)], _SHOWN)
    ends = " or ".join(f"{low} to {high}" for low, high in sorted(answers))
    question = f"Are these the lab's own questions: {shown}?"
    assumed = f"they are, with answers from {ends}, the narrowest usual scale of all answers"
    return OpenDoubt(question, assumed, OWN, f"own {instrument.name}")


def name_of(text: str, taken: set[str]) -> str:
    """Return a name that is not taken yet, of the first words of a text; and take it."""
    whole = "_".join(tokens(bare(text.casefold().replace("ß", "ss"))))
    whole = re.sub(r"[^a-z0-9_]", "", whole).strip("_")
    short = whole if len(whole) <= _LONGEST_NAME else whole[:_LONGEST_NAME].rpartition("_")[0]
    short = short if short[:1].isalpha() else f"question_{short}".strip("_")
    name = free_name(short, taken)
    taken.add(name)
    return name
