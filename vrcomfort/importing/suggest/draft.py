"""The doubts of a mapping under construction, and what depends on them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.plurals import counted

MOST_ASKED = 5
"""Doubts that a person is asked about at once."""


class Stake(NamedTuple):
    """What depends on an assumption: the consequence if it is wrong, and how much that is.

    Parameters
    ----------
    rank
        How much depends on the answer; the highest ranks are asked.
    instead
        The line to write in that case.
    """

    otherwise: str
    rank: int
    instead: str = ""


_HEADING = '["the heading", …]'


def _words(table: str, line: str = f"labels = {_HEADING}") -> str:
    return f"below [{table}] in words.toml: {line}"


WHOLE = _OUTCOMES = _words("outcomes")
_NO_OUTCOMES = f"{_words('ignored')}; below [people], if they are facts of people"
_ITEMS = 'below items: item = "the heading"'
_CONDITION = _words("facts", f"condition.labels = {_HEADING}")
_CONDITION += '; below [conditions], if headings of answers say them: words = ["A", "B"]'
_PERSON = _words("facts", f"participant.labels = {_HEADING}")
_MOMENT = (
    'timepoint = … in the mapping; or below [timepoints] in words.toml: baseline = ["the word"]'
)
_CODED = 'in the questionnaire: coded_from = 0, answers = { word = 0 } or missing = ["word"]'
_NAMES = 'in the table: file_name = "{participant}_{condition}_{*}"'
_SHORT = f"{_ITEMS}, and take it out of not_asked"
_SCALE = f"below instruments: answers = {{ low = 1, high = 7 }}; {_NO_OUTCOMES}"
_SAME_P, _SAME_C = (
    f'in `{fact}`: values = {{ {a} = "{b}" }}'
    for fact, a, b in (("participant", "p1", "P01"), ("condition", "a", "A"))
)
_REVERSED = "in the questionnaire: reverse_coded = true"
_OTHER_ITEMS = "columns would be questions that are none, or have other ends of their scale"
_STAYED = "who stayed would count as having left, or the other way round"
_UNIT = "times to a rating, areas and slopes would be of another unit"
_SHORTER = "a questionnaire would be scored as if it had been shorter"

REFUSED = Stake("nothing is imported", 100, f"{_OUTCOMES}; or {_CONDITION}")
LOST = Stake("answers would be missing", 92, f"in the mapping: items of those rows; {_OUTCOMES}")
NO_LABEL = Stake("what it says is not heeded", 94, "in words.toml: the heading as it stands")
LAYOUT = Stake("every cell would be read as another", 95, "in `read`: transpose = false, or so")
PEOPLE = Stake("one person's answers would count as another's", 90, _PERSON)
CODING = Stake("answers would count one too high, or not at all", 88, _CODED)
CONDITIONS = Stake("conditions would be compared that were none", 86, _CONDITION)
TIMEPOINTS = Stake("before and after would be exchanged", 84, _MOMENT)
ITEM_ORDER = Stake("every answer would count for another symptom", 82, _ITEMS)
NAMES_OF_FILES = Stake("answers would be of other people or conditions", 80, _NAMES)
STAYED = Stake(_STAYED, 76, "in left_at: planned_s = …")
DIRECTION = Stake("a low answer would count as a high one", 75, _REVERSED)
ITEM = Stake("an answer would count for another symptom", 74, _ITEMS)
_BLOCK = 'another block in the mapping: instrument = "…", first_columns = ["its first heading"]'
INSTRUMENT = Stake("scores would be made by another formula", 72, _BLOCK)
SHORT_FORM = Stake(_SHORTER, 70, _SHORT)
SCORE_KIND = Stake("scores would be called what they are not", 68, 'below scores: kind = "other"')
NOT_MADE = Stake("two scores of the same answers would differ", 67, _words("ignored"))
SAME_PERSON = Stake("one person would count as two", 66, _SAME_P)
SAME_CONDITION = Stake("one condition would count as two", 64, _SAME_C)
TIMES = Stake(_UNIT, 62, 'in the questionnaire: time_unit = "min"')
OWN = Stake(_OTHER_ITEMS, 60, _SCALE)
LEFT = Stake("columns would be outcomes that are none", 58, _NO_OUTCOMES)
WORDS = Stake(
    "answers or facts in words would be missing",
    61,
    f"{_words('people')}; or below [outcomes], if the words have an order, and below [degrees]",
)
ORDER = Stake(
    "exposures would be numbered in another order",
    55,
    _words("facts", f"trial.labels = {_HEADING}"),
)
ROWS = Stake("rows with answers would be missing", 50, _OUTCOMES)
CURIOUS = Stake("something is left out that an analysis might need", 10, _OUTCOMES)


class OpenDoubt(NamedTuple):
    """A question that the files do not answer, and the assumption meanwhile.

    Parameters
    ----------
    like
        Doubts with one such text are asked as one.
    """

    question: str
    assumed: str
    stake: Stake
    like: str = ""

    @property
    def words(self) -> str:
        """Return the doubt in one line."""
        stop = "" if self.assumed[-1:] in {".", "…", "?"} else "."
        return f"{self.question} Assumed: {self.assumed}{stop} If not: {self.stake.otherwise}."


def listed(names: Sequence[str], most: int, between: str = ", ") -> str:
    """Return the first names, and how many more there are."""
    more = f"{between.strip(', ')} and {len(names) - most} more" if names[most:] else ""
    return between.join(names[:most]) + more


def pattern_of(name: str) -> str:
    """Return the pattern of a name of a file or sheet: bytes that are no UTF-8 are any."""
    return re.sub("[\ud800-\udfff]", "?", re.sub(r"[*?[]", r"[\g<0>]", name))


def write_doubts(draft: TomlDraft, doubts: Iterable[OpenDoubt]) -> list[OpenDoubt]:
    """Write the doubts of the highest rank as questions, the others as guesses; return the first.

    One question hardly matters beside five that do, and a person who is asked forty reads none.
    """
    ranked = sorted(_joined(doubts), key=lambda doubt: -doubt.stake.rank)
    asked, guessed = ranked[:MOST_ASKED], ranked[MOST_ASKED:]
    draft.lists["doubts"] = [TomlDraft({**_said(doubt), "answer": ""}) for doubt in asked]
    if guessed:
        draft.lists["guesses"] = [TomlDraft(_said(doubt)) for doubt in guessed]
        line = "Not asked, since less depends on it: mend what is wrong."
        draft.lists["guesses"][0].note(line)
    return asked


_NAMED = re.compile(r"'[^']*'|\"[^\"]*\"|`[^`]*`|\d+")
"""What differs between doubts that are asked as one: names, and numbers."""


def _joined(doubts: Iterable[OpenDoubt]) -> list[OpenDoubt]:
    """Return the doubts with those that are alike as one."""
    groups: dict[str, list[OpenDoubt]] = {}
    for doubt in dict.fromkeys(doubts):
        alike = (_NAMED.sub("…", doubt.question), _NAMED.sub("…", doubt.assumed), doubt.stake)
        groups.setdefault(doubt.like or str(alike), []).append(doubt)
    found = []
    for first, *more in groups.values():
        blocks = f"{counted(len(more), 'more blocks')} like it"
        if more and not first.like:
            names = [min(_NAMED.findall(doubt.question), default="") for doubt in more]
            blocks = f"{len(more)} more like it: {listed(names, MOST_ASKED)}"
        asked = f"{first.question} (And {blocks}.)" if more else first.question
        found.append(first._replace(question=asked))
    return found


def _said(doubt: OpenDoubt) -> dict[str, object]:
    said = {**doubt._asdict(), **doubt.stake._asdict()}
    keys = ("question", "assumed", "otherwise", "instead")
    return {key: said[key] for key in keys if said[key]}


def placed_in_short(drafts: Sequence[TomlDraft]) -> list[TomlDraft]:
    """Merge questionnaires that are known by their first columns, and alike otherwise."""
    merged: list[TomlDraft] = []
    for draft in drafts:
        own = {k: v for k, v in draft.values.items() if k not in {"first_columns", "beside"}}
        before = merged[-1] if merged else None
        alike_so_far = before is not None and own == {
            k: v for k, v in before.values.items() if k not in {"first_columns", "beside"}
        }
        if before is None or not alike_so_far:
            merged.append(draft)
            continue
        for key in ("first_columns", "beside"):
            before.values[key] = _together(before.values.get(key), draft.values.get(key))
    return merged


def _together(one: object, other: object) -> object:
    """Return two lists as one, or of two tables the values of each key."""
    if isinstance(one, dict) and isinstance(other, dict):
        return {key: _together(one[key], other[key]) for key in one}
    return [
        *(one if isinstance(one, list) else [one]), *(other if isinstance(other, list) else [other])
    ]  # fmt: skip
