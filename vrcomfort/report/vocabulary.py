"""What conditions, scores and questions are called where people read of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vrcomfort.questionnaire import INSTRUMENTS
from vrcomfort.report.figures_of_sources import Compared

if TYPE_CHECKING:
    from collections.abc import Mapping

NAMES = {"T": "Total severity", "N": "Nausea", "O": "Oculomotor", "D": "Disorientation"}
SCORING = (
    "The Simulator Sickness Questionnaire (SSQ; 16 items, 0–3) was scored after Kennedy et al. "
    "(1993): N = 9.54 ΣN, O = 7.58 ΣO, D = 13.92 ΣD, total = 3.74 (ΣN + ΣO + ΣD)."
)
BASES = {"difference_from_baseline": "change from baseline", "raw_post": "score after exposure"}


@dataclass(frozen=True)
class Vocabulary:
    """The words of one report.

    Parameters
    ----------
    conditions
        Condition → label, in the one order that everything has.
    outcomes, items
        Score → what it is called; item → its wording.
    units
        Score → points per step of its raw sum.
    basis
        What a score says: a change, or the score itself.
    questionnaire
        How sentences call the instrument, such as SSQ.
    """

    conditions: Mapping[str, str]
    outcomes: Mapping[str, str]
    items: Mapping[str, str]
    units: Mapping[str, float]
    basis: str
    questionnaire: str
    low: int
    high: int
    scoring: str
    cited: tuple[str, ...]
    compared: Compared

    @classmethod
    def of(cls, results: Mapping[str, Any]) -> Vocabulary:
        """Return the words of a report's results."""
        instrument = INSTRUMENTS[results["plan"]["instrument"]]
        return cls(
            conditions={c["name"]: c["label"] for c in results["conditions"]},
            outcomes={o: NAMES[o] for o in results["plan"]["outcomes"]},
            items={item.name: item.text for item in instrument.items},
            units=results["weights"],
            basis=BASES[results["score_basis"]],
            questionnaire=instrument.name.upper(),
            low=instrument.low,
            high=instrument.high,
            scoring=SCORING,
            cited=("kennedy_1993",),
            compared=Compared.of(results["study"]["protocol"]),
        )

    def condition(self, name: str) -> str:
        """Return a condition's label."""
        return self.conditions.get(name, name)

    def place(self, condition: str) -> int:
        """Return a condition's place in the order of all, which gives its colour and shape."""
        return list(self.conditions).index(condition)

    def outcome(self, name: str) -> str:
        """Return what a score is called."""
        return self.outcomes.get(name, name)

    def item(self, name: str) -> str:
        """Return a question's wording."""
        return self.items.get(name, name)

    def unit(self, outcome: str) -> float:
        """Return the points of a score per step of its raw sum."""
        return self.units[outcome]

    def family(self, plan: Mapping[str, Any]) -> str:
        """Return what p values are adjusted over; blank where they are not."""
        return f"{', '.join(map(self.outcome, plan['family']))} and all comparisons"

    def term(self, text: str) -> str:
        """Return a term of a model, such as ``condition: a − b``, with labels."""
        factor, found, levels = text.partition(": ")
        if not found:
            return text
        if factor == "condition":
            levels = " − ".join(map(self.condition, levels.split(" − ")))
        return f"{factor}: {levels}"
