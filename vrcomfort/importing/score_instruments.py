"""Scores of which the answers are not there, as answers to an instrument of their own.

Its items are the scales of the instrument that they are scores of, so that nothing takes them for
answers, and everything that analyses answers analyses them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from math import isclose

from vrcomfort.importing.mapping import ScoreKind
from vrcomfort.questionnaire import Answer, Instrument, Scale, parse_instrument

ROUNDED = 0.051
"""Labs round scores to one decimal or more."""

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
    """Return the name of the instrument of somebody's scores: ``ssq_scores``."""
    return f"{instrument.name}_{_NAMES[kind]}"


def scale_named(instrument: Instrument, name: str) -> Scale | None:
    """Return a scale by its name, column or title."""
    return next((s for s in instrument.scales if name in {s.name, s.column, s.title}), None)


def step_of(scale: Scale, kind: ScoreKind) -> Fraction | None:
    """Return what scores are whole multiples of; None where no decimal number is that."""
    if kind == "other":
        return None
    step = Fraction(1) if kind == "raw_sum" else scale.unit
    return step if Fraction(str(float(step))) == step else None


def on_scale(value: float, scale: Scale, kind: ScoreKind) -> Answer | None:
    """Return the score that a rounded number means; None where it is none of the scale's."""
    if kind == "other":
        return value
    unit = Fraction(1) if kind == "raw_sum" else scale.unit
    steps = round(value / unit)
    exact = steps * unit
    low, high = scale.low / scale.unit * unit, scale.high / scale.unit * unit
    if not isclose(float(exact), value, abs_tol=ROUNDED) or not low <= exact <= high:
        return None
    step = step_of(scale, kind)
    found = float(exact) if step is not None else round(float(exact), 2)
    return int(found) if found.is_integer() else found


@dataclass
class ScoreInstrument:
    """The instrument of somebody's scores in the making: what values its scales have."""

    of: Instrument
    kind: ScoreKind
    values: dict[str, list[Answer]] = field(default_factory=dict)

    def made(self) -> Instrument:
        """Return the instrument, whose text is its file."""
        scales = [scale for scale in self.of.scales if scale.column in self.values]
        title = f"{self.of.title}, {_TITLES[self.kind]}"
        lines = [
            f"# Made by an import: the file has {_TITLES[self.kind]} of the {self.of.short}.",
            f'name = "{name_of(self.of, self.kind)}"',
            f'short = "{self.of.short} {_NAMES[self.kind].replace("_", " ")}"',
            f'title = "{title}"',
            f'citation = "{self.of.citation}"' if self.of.citation else "",
            'rule = "scores as the file has them, without the answers that they were made of"',
            f'primary = "{_primary(self.of, scales)}"',
            "",
            "[answers]",
            *self._range(scales[0]),
        ]
        for scale in scales:
            lines += ["", "[[items]]", f'name = "{scale.column}"', f'text = "{scale.title}"']
            inside = ", ".join(self._range(scale))
            lines.append(f"answers = {{ {inside} }}")
        return parse_instrument("\n".join(lines) + "\n")

    def _range(self, scale: Scale) -> list[str]:
        step = step_of(scale, self.kind)
        if self.kind == "other":
            values = self.values[scale.column] or [0]
            low, high, steps = min(0, *values), max(1, *values), 10.0 ** -_decimals(values)
        else:
            unit = Fraction(1) if self.kind == "raw_sum" else scale.unit
            low, high = (float(each / scale.unit * unit) for each in (scale.low, scale.high))
            steps = float(step) if step is not None else 0.01
        return [f"low = {_plain(low)}", f"high = {_plain(high)}", f"step = {_plain(steps)}"]


def _primary(instrument: Instrument, scales: Iterable[Scale]) -> str:
    columns = {scale.name: scale.column for scale in scales}
    return columns.get(instrument.primary, next(iter(columns.values())))


def _decimals(values: Iterable[Answer]) -> int:
    texts = (repr(float(value)).partition(".")[2] for value in values)
    return max((len(text) for text in texts if text != "0"), default=0)


def _plain(value: float) -> str:
    return str(int(value)) if float(value).is_integer() else f"{value:.10f}".rstrip("0")
