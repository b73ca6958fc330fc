"""Names of conditions, scores and questions for readers."""

from __future__ import annotations

import tomllib
from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vrcomfort.resources import data_folder

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from vrcomfort.report.exposures import Basis

BASES = {
    "difference_from_baseline": "change from baseline",
    "raw_post": "score after exposure",
    "measured": "",
}
"""What the scores of an outcome are; a measure has its unit instead."""


@dataclass(frozen=True)
class ReportedOutcome:
    """An outcome: its title, unit and basis."""

    name: str
    title: str
    instrument: str
    unit: float
    basis: Basis
    parts: tuple[str, ...]
    unit_label: str
    better: str
    definition: str
    low: float | None
    high: float | None
    """The lowest and the highest value that it can have at one moment; None: not known."""


@dataclass(frozen=True)
class ReportedItem:
    """A question of an instrument."""

    name: str
    text: str


@dataclass(frozen=True)
class ReportedInstrument:
    """An instrument that outcomes are scores of."""

    name: str
    short: str
    title: str
    citation: str
    rule: str
    asks: str
    answers: str
    low: float
    high: float
    items: tuple[ReportedItem, ...]


@dataclass(frozen=True)
class ReportedCondition:
    """A condition and its label."""

    name: str
    label: str


@dataclass(frozen=True)
class SameFigures:
    """A paper's figures of the same, cited in reports of its protocol."""

    figures: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, protocol: str | None) -> SameFigures:
        """Return those of a protocol's paper; none for any other protocol."""
        file = data_folder("analysis") / "report" / "figures_of_sources.toml"
        known = tomllib.loads(file.read_text(encoding="utf-8"))
        return cls(known.get(protocol or "", {}))

    def with_figure(self, name: str) -> str:
        """Return “ (cf. …)”, or nothing."""
        found = self.figures.get(name)
        return f" (cf. {found})" if found else ""


@dataclass(frozen=True)
class Vocabulary:
    """The words of one report.

    Parameters
    ----------
    conditions
        Condition → label, in the one order that everything has.
    labels
        The same, and those of other sides of comparisons (a moment, a condition at a moment).
    outcomes, units, bases, unit_labels
        Score → what it is called, points per step of its raw sum, what it says, and its unit.
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
    unit_labels: Mapping[str, str]
    instruments: tuple[ReportedInstrument, ...]
    same: SameFigures

    @classmethod
    def of(
        cls,
        conditions: Iterable[ReportedCondition],
        labels: Mapping[str, str],
        outcomes: Sequence[ReportedOutcome],
        instruments: tuple[ReportedInstrument, ...],
        protocol: str | None,
    ) -> Vocabulary:
        """Return the words of a report; `labels` are those of all sides of comparisons."""
        return cls(
            conditions={each.name: each.label for each in conditions},
            labels=labels,
            outcomes=_titles(outcomes, instruments),
            units={each.name: each.unit for each in outcomes},
            bases={each.name: BASES[each.basis] for each in outcomes},
            unit_labels={each.name: each.unit_label for each in outcomes},
            instruments=instruments,
            same=SameFigures.of(protocol),
        )

    def condition(self, name: str) -> str:
        """Return the label of a condition, or of another side of a comparison."""
        return self.labels.get(name, name)

    def place(self, name: str) -> int:
        """Return the place in the order of all, which gives colour and shape."""
        return list(self.labels).index(name)

    def outcome(self, name: str) -> str:
        """Return the title of a score."""
        return self.outcomes.get(name, name)

    def unit(self, name: str) -> str:
        """Return an outcome's unit, such as points or s; blank for a pure number."""
        return self.unit_labels.get(name, "")

    def axis(self, name: str, *, raw: bool = False) -> str:
        """Return the title of an axis with an outcome's values; `raw`: scores, not changes."""
        basis = ("score" if raw and self.bases[name] else self.bases[name]) or self.unit(name)
        return f"{self.outcome(name)}, {basis}" if basis else self.outcome(name)

    @property
    def basis(self) -> str:
        """Return the noun for scores: changes, or the scores themselves."""
        return next((basis for basis in self.bases.values() if basis), "")

    @property
    def scores(self) -> str:
        """Return how captions call the outcomes, such as SSQ scores and measures."""
        asked = " and ".join(each.short.removesuffix(" scores") for each in self.instruments)
        measures = "measures" if "" in self.bases.values() else ""
        named = [name for name in (f"{asked} scores" if asked else "", measures) if name]
        return " and ".join(named) or "outcomes"

    def item(self, instrument: str, name: str) -> str:
        """Return a question's wording."""
        asked = (
            item for each in self.instruments if each.name == instrument for item in each.items
        )
        return next((item.text for item in asked if item.name == name), name)

    def asks(self, instruments: Iterable[str]) -> str:
        """Return the noun for items (of all instruments, if none): symptoms, if all ask those."""
        names = set(instruments)
        found = [each for each in self.instruments if not names or each.name in names]
        return "symptoms" if found and all(i.asks == "symptoms" for i in found) else "questions"

    def answers(self, instrument: str) -> str:
        """Return the range of an instrument's answers, such as 0 to 3."""
        return next((each.answers for each in self.instruments if each.name == instrument), "")

    def term(self, text: str) -> str:
        """Return a term of a model, such as ``condition: a − b``, with labels."""
        factor, found, levels = text.partition(": ")
        if not found:
            return text
        if factor == "condition":
            levels = " − ".join(map(self.condition, levels.split(" − ")))
        return f"{factor}: {levels}"

    def not_fitted(self, reason: str, term: str | None) -> str:
        """Return why a model has no numbers, with labels in the term that it is about."""
        return reason if term is None else reason.replace(term, self.term(term))


def _titles(
    outcomes: Sequence[ReportedOutcome], instruments: Iterable[ReportedInstrument]
) -> dict[str, str]:
    """Return score → title; with the instrument's name where two have the same one."""
    count = Counter(each.title for each in outcomes)
    shorts = {each.name: each.short for each in instruments}
    return {
        each.name: each.title
        if count[each.title] == 1
        else f"{shorts[each.instrument]} {each.title.lower()}"
        if each.instrument in shorts
        else f"{each.title} ({each.name})"
        for each in outcomes
    }
