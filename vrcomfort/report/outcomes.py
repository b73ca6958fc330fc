"""Outcomes that plans can name: scores of instruments, and measures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from functools import lru_cache

from vrcomfort.errors import InputError
from vrcomfort.questionnaire import Answer, Instrument, Scale, shipped_instruments
from vrcomfort.questionnaire.answers import exact
from vrcomfort.report.measures import SOURCES, Measure, MeasureSettings, fault_of, measure_of


@dataclass(frozen=True)
class Outcome:
    """A score of an instrument, in whole steps of one size.

    Parameters
    ----------
    name
        As plans and tables call it.
    title
        As readers know it; with the instrument's name where scores of several have one title.
    instrument
        Name of the instrument.
    scale
        How it is scored.
    unit
        Points per step.
    parts
        Names of the outcomes that it is made of; blank for a score of its own.
    sums
        Item → (slope, intercept) of what it adds in steps of its answer; blank where a person's
        weights decide.
    """

    name: str
    title: str
    instrument: str
    scale: Scale
    unit: float
    parts: tuple[str, ...] = ()
    unit_label = "points"
    better = ""
    sums: Mapping[str, tuple[Fraction, Fraction]] | None = None

    def prorated(
        self, answers: Mapping[str, Answer | None], instrument: Instrument
    ) -> Fraction | None:
        """Return the steps that the answered items give if the missing ones are like them."""
        if self.sums is None:
            return None
        added, counted = Fraction(0), Fraction(0)
        for item in instrument.items:
            answer = answers.get(item.name)
            if item.name in self.sums and answer is not None:
                slope, intercept = self.sums[item.name]
                added += slope * exact(answer) / item.answers.resolution + intercept
                counted += abs(slope)
        whole = sum((abs(slope) for slope, _ in self.sums.values()), Fraction(0))
        return added * whole / counted if counted else None


@lru_cache(maxsize=256)  # a report asks for those of every instrument, again and again
def outcomes_of(instrument: Instrument) -> tuple[Outcome, ...]:
    """Return the scores of an instrument, the primary one first."""
    names = {scale.name: _name(instrument, scale) for scale in instrument.scales}
    sums: dict[str, dict[str, tuple[Fraction, Fraction]] | None] = {}
    for scale in instrument.scales:
        sums[scale.name] = _sums(scale, sums)
    scales = {scale.name: scale for scale in instrument.scales}
    return tuple(
        Outcome(
            name=names[name],
            title=scales[name].title if len(scales) > 1 else instrument.title,
            instrument=instrument.name,
            scale=scales[name],
            unit=scales[name].weight,
            parts=tuple(names[part] for part, _ in scales[name].parts),
            sums=sums[name],
        )
        for name in instrument.outcomes
    )


def _name(instrument: Instrument, scale: Scale) -> str:
    if len(instrument.scales) == 1:
        return instrument.name
    return f"{instrument.name}.{scale.column}" if instrument.prefixed else scale.name


def _sums(
    scale: Scale, before: Mapping[str, dict[str, tuple[Fraction, Fraction]] | None]
) -> dict[str, tuple[Fraction, Fraction]] | None:
    """Return the weight of each item in a scale, in steps."""
    if scale.weights:
        return None
    if not scale.parts:
        times = scale.stretch[len(scale.terms)]
        return {t.item: (Fraction(t.slope * times), Fraction(t.intercept * times))
                for t in scale.terms}  # fmt: skip
    found: dict[str, tuple[Fraction, Fraction]] = {}
    for part, times in scale.parts:
        inner = before[part]
        if inner is None:
            return None
        for item, (slope, intercept) in inner.items():
            one, two = found.get(item, (Fraction(0), Fraction(0)))
            found[item] = one + times * slope, two + times * intercept
    return found


def items_of(instrument: Instrument) -> tuple[str, ...]:
    """Return the items that scales count; one that is a score of its own is among the outcomes."""
    alone = {scale.name for scale in instrument.scales if scale.alone}
    return tuple(item.name for item in instrument.asked if item.name not in alone)


def item_column(instrument: Instrument, item: str) -> str:
    """Return the column of an item's answers: two instruments may have items of one name.

    Nor is it that of a scale, which may be called as an item is.
    """
    name = f"{instrument.name}.{item}" if instrument.prefixed else item
    scales = {_name(instrument, scale) for scale in instrument.scales if not scale.alone}
    return f"{name}_item" if name in scales else name


def known_outcomes(instruments: Iterable[Instrument] | None = None) -> dict[str, Outcome]:
    """Return every score that a plan may name: of these instruments, or of the shipped ones."""
    known = shipped_instruments().values() if instruments is None else instruments
    return {outcome.name: outcome for each in known for outcome in outcomes_of(each)}


def outcome_of_plan(
    name: str, known: Mapping[str, Outcome], measures: Iterable[MeasureSettings]
) -> Outcome | Measure:
    """Return the score or the measure of that name.

    Parameters
    ----------
    known
        The scores; see `known_outcomes`.
    measures
        Those that the plan gives names to.

    Raises
    ------
    InputError
        If there is neither, with the nearest name.
    """
    named = {each.name: each for each in measures}
    if problem := fault_of_outcome(name, known, named):
        raise InputError(problem)
    if name in named:
        return measure_of(name, named[name])
    return known[name] if name in known else measure_of(name)


def fault_of_outcome(name: str, known: Iterable[str], named: Iterable[str]) -> str | None:
    """Say why a name is that of no outcome (no score, and no measure); None where it is one."""
    there = [*known, *named]
    if name in there:
        return None
    source, dot, _ = name.partition(".")
    if not dot or source not in SOURCES:
        return unknown_outcome(name, there)
    if name == "ratings.time_to":
        return (
            "`ratings.time_to` needs a threshold: name it in [[measures]] with measure = "
            '"ratings.time_to" and threshold'
        )
    return fault_of(name)


def unknown_outcome(name: str, known: Iterable[str]) -> str:
    """Say that there is no such score, and which may be meant."""
    choices = {each.casefold(): each for each in known}
    near = get_close_matches(name.casefold(), choices, n=1, cutoff=0.6)
    hint = f"did you mean `{choices[near[0]]}`?" if near else f"there are {', '.join(known)}"
    return f"`{name}` is no score of any instrument; {hint}"
