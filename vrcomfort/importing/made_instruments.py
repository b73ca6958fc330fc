"""Makes instruments of scores without answers, and of rating time courses.

The items of such an instrument are the scales, or the summaries of a time course: nothing takes
them for answers, and everything that analyses answers analyses them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from math import isclose

from vrcomfort.importing.mapping import ScoreKind, Summary
from vrcomfort.importing.rows import Administration, Imported, ImportedResponse, Rating, SourceRow
from vrcomfort.importing.toml_draft import TomlDraft
from vrcomfort.questionnaire import Answer, Instrument, Scale, parse_instrument
from vrcomfort.questionnaire.answers import common_divisor, exact, plain_number

ROUNDED = 0.051
"""Labs round scores to one decimal or more."""
MOST = 1e12
"""Of a score of another formula: an instrument has no larger answer."""
MOST_DECIMALS = 9
_DIGITS = 12
"""Of such a score: 22.740000000000002 is 22.74, and ties with it."""

_NAMES: Mapping[ScoreKind, str] = {
    "score": "scores",
    "raw_sum": "raw_sums",
    "other": "other_scores",
}
_TITLES: Mapping[ScoreKind, str] = {
    "score": "scores alone",
    "raw_sum": "raw sums alone",
    "other": "scores made in another way",
}


def name_of(instrument: Instrument, kind: ScoreKind) -> str:
    """Return the name of the instrument of a lab's scores: ``ssq_scores``."""
    return f"{instrument.name}_{_NAMES[kind]}"


def step_of(scale: Scale, kind: ScoreKind) -> Fraction | None:
    """Return the unit of scores, or None where it is no decimal number."""
    if kind == "other":
        return None
    step = Fraction(1) if kind == "raw_sum" else scale.unit
    return step if Fraction(str(float(step))) == step else None


def on_scale(value: float, scale: Scale, kind: ScoreKind) -> Answer | None:
    """Return the score that a rounded number means; None where it is none of the scale's."""
    if kind == "other":
        found = round(float(f"{value:.{_DIGITS}g}"), MOST_DECIMALS)
        return plain_number(exact(found)) if abs(found) <= MOST else None
    unit = Fraction(1) if kind == "raw_sum" else scale.unit
    steps = round(value / unit)
    score = steps * unit
    low, high = scale.low / scale.unit * unit, scale.high / scale.unit * unit
    if not isclose(float(score), value, abs_tol=ROUNDED) or not low <= score <= high:
        return None
    step = step_of(scale, kind)
    return plain_number(score if step is not None else round(score, 2))


@dataclass
class ScoreInstrument:
    """The instrument of a lab's scores in the making, with the values of its scales."""

    of: Instrument
    kind: ScoreKind
    values: dict[str, list[Answer]] = field(default_factory=dict)

    def made(self) -> Instrument:
        """Return the instrument, with the text of its file."""
        scales = [scale for scale in self.of.scales if scale.column in self.values]
        title, words = _TITLES[self.kind], _NAMES[self.kind].replace("_", " ")
        said = {
            "name": name_of(self.of, self.kind),
            "short": f"{self.of.short} {words}",
            "title": f"{self.of.title}, {title}",
            "rule": "scores as the file has them, without the answers that they were made of",
            "primary": _primary(self.of, scales),
            "answers": self._range(scales[0]),
        }
        items = [(each.column, each.title, self._range(each)) for each in scales]
        return _made(self.of, f"an import: the file has {title} of {self.of.name}.", said, items)

    def _range(self, scale: Scale) -> dict[str, Answer]:
        step = step_of(scale, self.kind)
        if self.kind == "other":
            values = self.values[scale.column] or [0]
            low, high = exact(min(0, *values)), exact(max(1, *values))
            step = Fraction(1, 10 ** _decimals(values))
        else:
            unit = Fraction(1) if self.kind == "raw_sum" else scale.unit
            low, high = (each / scale.unit * unit for each in (scale.low, scale.high))
        found = {"low": low, "high": high, "step": Fraction(1, 100) if step is None else step}
        return {name: plain_number(number) for name, number in found.items()}


def _made(
    of: Instrument,
    by: str,
    said: Mapping[str, object],
    items: Iterable[tuple[str, str, Mapping[str, Answer]]],
) -> Instrument:
    """Return an instrument that is made of another; of each item: name, text and answers."""
    draft = TomlDraft({**said, **({"citation": of.citation} if of.citation else {})})
    draft.note(f"Made by {by}", "name")
    draft.lists["items"] = [
        TomlDraft({"name": name, "text": text, "answers": answers}) for name, text, answers in items
    ]
    return parse_instrument(draft.text())


def _primary(instrument: Instrument, scales: Iterable[Scale]) -> str:
    columns = {scale.name: scale.column for scale in scales}
    return columns.get(instrument.primary, next(iter(columns.values())))


def _decimals(values: Iterable[Answer]) -> int:
    """Return the number of decimals needed; `on_scale` has left at most `MOST_DECIMALS`."""
    return next(
        digits
        for digits in range(MOST_DECIMALS + 1)
        if all((exact(value) * 10**digits).denominator == 1 for value in values)
    )


DECIMALS = 4
"""Of means."""
_TEXTS: Mapping[Summary, str] = {
    "peak": "highest rating",
    "mean": "mean rating",
    "last": "last rating",
}


def course_instrument(instrument: Instrument, summaries: Sequence[Summary]) -> Instrument:
    """Return the instrument of rating time courses, summaries as items: ``fms_course``."""
    answers = instrument.answers
    of_ratings = {"low": answers.low, "high": answers.high, "step": answers.step}
    fine = common_divisor(Fraction(1, 10**DECIMALS), answers.resolution, exact(answers.high))
    said = {
        "name": f"{instrument.name}_course",
        "short": f"{instrument.short} during exposure",
        "title": f"{instrument.title}, during exposure",
        "rule": "of the ratings of an exposure, in the order of their times; missed ones left out",
        "primary": summaries[0],
        "answers": of_ratings,
    }
    steps = {name: plain_number(fine) if name == "mean" else answers.step for name in summaries}
    items = [(name, _TEXTS[name], {**of_ratings, "step": step}) for name, step in steps.items()]
    return _made(instrument, f"an import of ratings ({instrument.name}).", said, items)


def sum_up(
    imported: Imported,
    ratings: Mapping[tuple[str, Administration], tuple[SourceRow, Sequence[Summary], list[Rating]]],
    known: Mapping[str, Instrument],
) -> None:
    """Add the summaries of every rating time course to an import."""
    wanted: dict[str, dict[Summary, None]] = defaultdict(dict)
    for (name, administration), (place, summaries, course) in ratings.items():
        if not summaries:
            continue
        wanted[name] |= dict.fromkeys(summaries)
        given = [r.response for r in sorted(course, key=lambda r: r.onset_s)]
        answers = [answer for answer in given if answer is not None]
        response = ImportedResponse(place, {each: _summary(each, answers) for each in summaries})
        imported.responses[f"{name}_course", administration] = response
    for name, items in wanted.items():
        made = course_instrument(known[name], [*items])
        imported.instruments[made.name] = made


def _summary(name: Summary, answers: Sequence[Answer]) -> Answer | None:
    if not answers:
        return None
    if name == "mean":
        return round(sum(answers) / len(answers), DECIMALS)
    return max(answers) if name == "peak" else answers[-1]
