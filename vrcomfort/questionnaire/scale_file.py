"""Compiles the scales of an instrument's file to whole numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from vrcomfort.questionnaire.answers import common_divisor, exact
from vrcomfort.questionnaire.scales import Scale, Term, stretch
from vrcomfort.settings import KeyPath, Name, Problem, Settings, Word, did_you_mean

if TYPE_CHECKING:
    from vrcomfort.questionnaire.instruments import Item


def _counted(given: Any) -> Any:
    """Return a list of names as a table in which each counts once."""
    if not isinstance(given, tuple) or not all(isinstance(name, str) for name in given):
        return given
    twice = next((name for name in given if given.count(name) > 1), None)
    if twice is not None:
        message = "`{name}` is there twice; to count it twice write {name} = 2"
        raise PydanticCustomError("twice", message, {"name": twice})
    return dict.fromkeys(given, 1.0)


Weights = Annotated[dict[str, Annotated[float, Field(ge=-1e6, le=1e6)]], BeforeValidator(_counted)]
Made = Literal["sum", "mean", "percent"]


class ScaleTable(Settings):
    """A `[[scales]]` table. Exactly one of `items`, `raw_sums_of` and `scores_of` is given."""

    name: Name
    title: str
    column: Word | None = None
    """Its heading in tables; the name in small letters without it."""
    items: Weights = Field(default_factory=dict)
    """Items, or item → how often its answer counts."""
    raw_sums_of: Weights = Field(default_factory=dict)
    """Scales whose sums of answers, before any factor, are added."""
    scores_of: Weights = Field(default_factory=dict)
    """Scales whose scores are added."""
    made: Made = "sum"
    """`sum`, `mean`, or `percent`: where between the lowest and the highest sum, 0 to 100."""
    factor: Annotated[float, Field(gt=0, le=1e6)] = 1.0
    """Multiplies the result."""
    min_valid: Annotated[int, Field(ge=1)] | None = None
    """Fewest answered items; the mean of those stands for the others. All of them without it."""
    weighted_by: dict[str, str] = Field(default_factory=dict)
    """Item → the item that says how much it counts for this person."""
    weights_sum: Annotated[int, Field(ge=1)] | None = None
    """What the weights of a person add up to."""


@dataclass(frozen=True)
class Compiled:
    """A scale, and the points of one raw step of its sum of answers before kind and factor."""

    scale: Scale
    sum_unit: Fraction


def scale_problems(
    path: KeyPath, table: ScaleTable, items: Mapping[str, Item], before: list[str]
) -> Iterator[Problem]:
    """Yield problems of a table beyond its types."""
    given = [n for n in ("items", "raw_sums_of", "scores_of") if getattr(table, n)]
    if len(given) != 1:
        said = " and ".join(given) or "none"
        message = "a scale is made of `items`, `raw_sums_of` or `scores_of`; this has"
        yield Problem(path, f"{message} {said}: give one")
        return
    (kind,) = given
    known: list[str] = list(items) if kind == "items" else before
    what = "item" if kind == "items" else "scale before this one"
    names = list(getattr(table, kind))
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known)
            yield Problem((*path, kind), f"there is no {what} `{name}`; {hint}")
    if any(weight == 0 for weight in _weights(getattr(table, kind)).values()):
        yield Problem((*path, kind), "something counts 0 times; leave it out")
    if table.made == "percent" and any(w < 0 for w in _weights(table.items).values()):
        message = "with `percent` nothing counts negatively; say `reversed = true` in the item"
        yield Problem((*path, kind), message)
    if kind != "items" and table.made == "percent":
        yield Problem((*path, "made"), "`percent` is of answers; write it in the scales of items")
    yield from _validity(path, table, kind)
    yield from _personal_weights(path, table, kind, items)


def _validity(path: KeyPath, table: ScaleTable, kind: str) -> Iterator[Problem]:
    if table.min_valid is None:
        return
    place = (*path, "min_valid")
    loadings = set(map(abs, _weights(table.items).values()))
    if kind != "items":
        yield Problem(place, "only a scale of items has missing items; write it there")
    elif table.min_valid > len(table.items):
        yield Problem(place, f"this is more than the {len(table.items)} items of the scale")
    elif len(loadings) > 1 and table.min_valid < len(table.items):
        message = "items with different weights cannot stand for each other"
        yield Problem(place, f"{message}; leave `min_valid` out")


def _personal_weights(
    path: KeyPath, table: ScaleTable, kind: str, items: Mapping[str, Item]
) -> Iterator[Problem]:
    place = (*path, "weighted_by")
    if not table.weighted_by:
        if table.weights_sum is not None:
            yield Problem((*path, "weights_sum"), "there are no weights; add `weighted_by`")
        return
    if kind != "items" or set(table.weighted_by) != set(table.items):
        yield Problem(place, "name each item of the scale here, with the item of its weight")
    if len(set(_weights(table.items).values())) > 1 or table.made != "sum":
        message = 'weights of the person need items that count alike, and `made = "sum"`'
        yield Problem(place, f"{message}; remove the other weights")
    if table.min_valid is not None and table.min_valid < len(table.items):
        yield Problem((*path, "min_valid"), "with `weighted_by` every item is needed; leave it out")
    for name in table.weighted_by.values():
        if name not in items:
            yield Problem(place, f"there is no item `{name}`; {did_you_mean(name, items)}")
        elif items[name].answers.resolution != 1:
            yield Problem(place, f"the answers to `{name}` are not whole; weights have to be")


def compile_scale(
    table: ScaleTable, items: Mapping[str, Item], before: Mapping[str, Compiled]
) -> Compiled:
    """Return the scale that a table without problems says."""
    if table.items:
        return _of_items(table, items)
    weights = _weights(table.raw_sums_of or table.scores_of)
    units = {
        name: weight * (before[name].sum_unit if table.raw_sums_of else before[name].scale.unit)
        for name, weight in weights.items()
    }
    base = common_divisor(*units.values())
    factor = exact(table.factor)
    if table.made == "mean":
        factor /= sum(map(abs, weights.values()))
    ends = [
        [units[name] * end / before[name].scale.unit * factor for end in _ends(before[name])]
        for name in units
    ]
    scale = Scale(
        name=table.name,
        title=table.title,
        column=_column(table),
        unit=base * factor,
        low=sum((min(pair) for pair in ends), Fraction(0)),
        high=sum((max(pair) for pair in ends), Fraction(0)),
        parts=tuple((name, int(unit / base)) for name, unit in units.items()),
    )
    return Compiled(scale, base)


def _ends(compiled: Compiled) -> tuple[Fraction, Fraction]:
    return compiled.scale.low, compiled.scale.high


def _of_items(table: ScaleTable, items: Mapping[str, Item]) -> Compiled:
    weights = _weights(table.items)
    sizes = {name: weight * items[name].answers.resolution for name, weight in weights.items()}
    base = common_divisor(*sizes.values())
    terms = tuple(
        _term(items[name], int(size / base), from_low=table.made == "percent")
        for name, size in sizes.items()
    )
    min_valid = table.min_valid or len(terms)
    whole = stretch(len(terms), min_valid)[len(terms)]
    factor = exact(table.factor) / (table.weights_sum or 1)
    if table.made == "mean":
        factor /= sum(map(abs, weights.values()))
    if table.made == "percent":
        ranges = (abs(w) * _range(items[name]) for name, w in weights.items())
        factor *= 100 / sum(ranges, Fraction(0))
    low, high = (end * base * factor for end in _limits(table, terms, items))
    scale = Scale(
        name=table.name,
        title=table.title,
        column=_column(table),
        unit=base / whole * factor,
        low=low,
        high=high,
        terms=terms,
        min_valid=min_valid,
        weights=tuple(table.weighted_by.items()),
        weights_sum=table.weights_sum or 0,
    )
    return Compiled(scale, base / whole)


def of_one_item(item: Item) -> Scale:
    """Return the scale of an item that no other scale counts."""
    table = ScaleTable(name=item.name, title=item.text, items={item.name: 1.0})
    made = _of_items(table, {item.name: item}).scale
    return Scale(**{**vars(made), "alone": True})


def _term(item: Item, loading: int, *, from_low: bool) -> Term:
    """Return an item's term: its answer, reversed if need be, or counted from the lowest."""
    answers = item.answers
    low, high = (int(exact(end) / answers.resolution) for end in (answers.low, answers.high))
    slope, intercept = (-1, low + high) if item.reversed else (1, 0)
    if from_low:
        intercept -= low
    return Term(item.name, loading * slope, loading * intercept)


def _limits(
    table: ScaleTable, terms: tuple[Term, ...], items: Mapping[str, Item]
) -> tuple[Fraction, Fraction]:
    """Return the smallest and the largest sum, weighted by the person where that is asked."""
    ends = []
    for term in terms:
        answers = items[term.item].answers
        steps = (exact(end) / answers.resolution for end in (answers.low, answers.high))
        ends.append(sorted(term.slope * step + term.intercept for step in steps))
    if table.weighted_by and table.weights_sum:  # as if all the weight were on one item
        whole = table.weights_sum
        return min(low for low, _ in ends) * whole, max(high for _, high in ends) * whole
    most = max((exact(items[n].answers.high) for n in table.weighted_by.values()), default=1)
    zero = Fraction(0)
    return sum((low for low, _ in ends), zero) * most, sum((high for _, high in ends), zero) * most


def _range(item: Item) -> Fraction:
    return exact(item.answers.high) - exact(item.answers.low)


def _weights(given: Weights) -> dict[str, Fraction]:
    return {name: exact(weight) for name, weight in given.items()}


def _column(table: ScaleTable) -> str:
    return table.column or table.name.lower().replace("-", "_")
