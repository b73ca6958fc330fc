"""What participants are asked: items, wording, scales."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property


@dataclass(frozen=True)
class Item:
    """One question.

    Parameters
    ----------
    name
        As it stands in ``questionnaires.csv``.
    text
        As it is asked.
    aliases
        Other headings under which labs export it, compared without case, spaces and punctuation.
    """

    name: str
    text: str
    aliases: tuple[str, ...] = ()

    @property
    def keys(self) -> frozenset[str]:
        """Return every spelling of this item, as `plain` writes them."""
        return frozenset(plain(word) for word in (self.name, self.text, *self.aliases))


@dataclass(frozen=True)
class Instrument:
    """A questionnaire or a rating scale with one answer range for all its items."""

    name: str
    title: str
    instruction: str
    items: tuple[Item, ...]
    low: int
    high: int
    labels: tuple[str, ...]
    """Names of the answers from `low` to `high`, or of the two ends."""
    citation: str

    @cached_property
    def _found(self) -> dict[str, Item | None]:
        """Items by headings that were looked up: a long file has each thousands of times."""
        return {}

    @cached_property
    def plain_answers(self) -> frozenset[str]:
        """Return the answers as they mostly stand in files."""
        return frozenset(map(str, range(self.low, self.high + 1)))

    def item(self, heading: str) -> Item | None:
        """Return the item that a human-readable heading means, or None."""
        if heading not in self._found:
            key = plain(heading)
            self._found[heading] = next((item for item in self.items if key in item.keys), None)
        return self._found[heading]

    def may_mean(self, heading: str, item: Item) -> bool:
        """Return whether a heading that names no item has the words of this one in it.

        As "8. Nausea", "ssq_nausea" and "Nausae" have; headings of sums and scores say so.
        """
        words = _words(heading)
        if self.item(heading) is not None or words & DERIVED:
            return False
        names = [_words(name) for name in (item.name, item.text, *item.aliases)]
        if any(name <= words for name in names):
            return True
        misspelt = any(key[:1] == plain(heading)[:1] for key in item.keys)  # "comfort" is another
        return misspelt and self.nearest(heading) == item.name

    def nearest(self, heading: str) -> str | None:
        """Return the item name that looks most like a heading that is none."""
        spellings = {key: item.name for item in self.items for key in item.keys}
        near = get_close_matches(plain(heading), spellings, n=1, cutoff=0.75)
        return spellings[near[0]] if near else None


DERIVED = frozenset(
    ["sum", "total", "score", "scores", "raw", "mean", "average", "scale", "subscale", "weighted",
     "rt", "time", "ms", "onset", "fms", "misc"]
)  # fmt: skip
"""Words of headings that stand over what was made of answers, beside them, or asked otherwise."""


def _words(heading: str) -> frozenset[str]:
    """Return the words of a heading in lower case, ``SsqNausea8`` being three."""
    parts = re.findall(r"[^\W\d_]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", heading))
    return frozenset(part.casefold() for part in parts)


def plain(heading: str) -> str:
    """Return the letters and digits of a heading in lower case."""
    return re.sub(r"[\W_]+", "", heading.casefold())


SSQ = Instrument(
    name="ssq",
    title="Simulator Sickness Questionnaire",
    instruction="How much does each symptom affect you right now?",
    items=(
        Item("general_discomfort", "General discomfort", ("discomfort",)),
        Item("fatigue", "Fatigue"),
        Item("headache", "Headache"),
        Item("eyestrain", "Eyestrain", ("eye strain", "strained eyes")),
        Item("difficulty_focusing", "Difficulty focusing", ("difficulty focussing",)),
        Item(
            "increased_salivation",
            "Increased salivation",
            ("salivation increasing", "salivation increase", "salivation"),
        ),
        Item("sweating", "Sweating", ("sweat",)),
        Item("nausea", "Nausea"),
        Item("difficulty_concentrating", "Difficulty concentrating"),
        Item(
            "fullness_of_head",
            "Fullness of head",
            ("fullness of the head", "fullness of head", "full head", "head fullness"),
        ),
        Item("blurred_vision", "Blurred vision", ("blurry vision",)),
        Item(
            "dizzy_eyes_open",
            "Dizziness with eyes open",
            ("dizzy eyes open", "dizziness eyes open", "dizzy with eyes open"),
        ),
        Item(
            "dizzy_eyes_closed",
            "Dizziness with eyes closed",
            ("dizzy eyes closed", "dizziness eyes closed", "dizzy with eyes closed"),
        ),
        Item("vertigo", "Vertigo"),
        Item("stomach_awareness", "Stomach awareness"),
        Item("burping", "Burping"),
    ),
    low=0,
    high=3,
    labels=("none", "slight", "moderate", "severe"),
    citation="Kennedy, Lane, Berbaum & Lilienthal (1993), Int. J. Aviation Psychology 3, 203-220",
)

FMS = Instrument(
    name="fms",
    title="Fast Motion Sickness scale",
    instruction="How sick do you feel, from 0 (not at all) to 20 (frank sickness)?",
    items=(Item("fms", "Motion sickness", ("sickness", "rating")),),
    low=0,
    high=20,
    labels=("no sickness", "frank sickness"),
    citation="Keshavarz & Hecht (2011), Human Factors 53(4), 415-426",
)

MISC = Instrument(
    name="misc",
    title="Misery Scale",
    instruction="How do you feel, from 0 (no problems) to 10 (vomiting)?",
    items=(Item("misc", "Misery", ("misery scale", "rating")),),
    low=0,
    high=10,
    labels=("no problems", "vomiting"),
    citation="Bos, MacKinnon & Patterson (2005), Aviation, Space, and Environ. Med. 76, 1111-1118",
)

INSTRUMENTS = {instrument.name: instrument for instrument in (SSQ, FMS, MISC)}
