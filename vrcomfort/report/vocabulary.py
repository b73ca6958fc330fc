"""What conditions, scores and questions are called where people read of them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vrcomfort.report.figures_of_sources import SameFigures

if TYPE_CHECKING:
    from collections.abc import Mapping

BASES = {"difference_from_baseline": "change from baseline", "raw_post": "score after exposure"}


@dataclass(frozen=True)
class Vocabulary:
    """The words of one report.

    Parameters
    ----------
    conditions
        Condition → label, in the one order that everything has.
    labels
        The same, and those of other sides of comparisons (a moment, a condition at a moment).
    outcomes, units, bases
        Score → what it is called, points per step of its raw sum, and what it says.
    instruments
        Those of the scores, as results have them.
    same
        Figures of the paper whose protocol this is.
    """

    conditions: Mapping[str, str]
    labels: Mapping[str, str]
    outcomes: Mapping[str, str]
    units: Mapping[str, float]
    bases: Mapping[str, str]
    instruments: tuple[Mapping[str, Any], ...]
    same: SameFigures

    @classmethod
    def of(cls, results: Mapping[str, Any]) -> Vocabulary:
        """Return the words of a report's results."""
        outcomes = results["outcomes"]
        return cls(
            conditions={c["name"]: c["label"] for c in results["conditions"]},
            labels=results["labels"],
            outcomes=_titles(results),
            units={each["name"]: each["unit"] for each in outcomes},
            bases={each["name"]: BASES[each["basis"]] for each in outcomes},
            instruments=tuple(results["instruments"]),
            same=SameFigures.of(results["study"]["protocol"]),
        )

    def condition(self, name: str) -> str:
        """Return the label of a condition, or of another side of a comparison."""
        return self.labels.get(name, name)

    def place(self, name: str) -> int:
        """Return the place in the order of all, which gives colour and shape."""
        return list(self.labels).index(name)

    def outcome(self, name: str) -> str:
        """Return what a score is called."""
        return self.outcomes.get(name, name)

    @property
    def basis(self) -> str:
        """Return what the primary score says: a change, or the score itself."""
        return next(iter(self.bases.values()), "")

    @property
    def questionnaire(self) -> str:
        """Return how sentences call the instruments, such as SSQ, before the word scores."""
        return " and ".join(short(each).removesuffix(" scores") for each in self.instruments)

    def item(self, instrument: str, name: str) -> str:
        """Return a question's wording."""
        found = next((i for i in self.instruments if i["name"] == instrument), {"items": ()})
        return next((i["text"] for i in found["items"] if i["name"] == name), name)

    def answers(self, instrument: str) -> str:
        """Return the range of an instrument's answers, such as 0 to 3."""
        found = next((i for i in self.instruments if i["name"] == instrument), None)
        return answers_in_words(found) if found else ""

    def term(self, text: str) -> str:
        """Return a term of a model, such as ``condition: a − b``, with labels."""
        factor, found, levels = text.partition(": ")
        if not found:
            return text
        if factor == "condition":
            levels = " − ".join(map(self.condition, levels.split(" − ")))
        return f"{factor}: {levels}"


def short(instrument: Mapping[str, Any]) -> str:
    """Return what sentences call an instrument."""
    return str(instrument["short"])


def answers_in_words(instrument: Mapping[str, Any]) -> str:
    """Return the range of an instrument's answers."""
    return str(instrument["answers"])


def _titles(results: Mapping[str, Any]) -> dict[str, str]:
    """Return score → title; with the instrument's name where two have the same one."""
    outcomes = results["outcomes"]
    count = Counter(each["title"] for each in outcomes)
    shorts = {each["name"]: short(each) for each in results["instruments"]}
    return {
        each["name"]: each["title"]
        if count[each["title"]] == 1
        else f"{shorts[each['instrument']]} {each['title'].lower()}"
        for each in outcomes
    }
