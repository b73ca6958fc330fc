"""Courses of ratings during exposure, summed up as an instrument of their own."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from vrcomfort.importing.mapping import Summary
from vrcomfort.importing.rows import Imported, Moment, Sheet
from vrcomfort.questionnaire import Answer, Instrument, parse_instrument
from vrcomfort.questionnaire.answers import common_divisor, exact, plain_number
from vrcomfort.settings import toml_value

if TYPE_CHECKING:
    from vrcomfort.importing.rows import Place, Rating

DECIMALS = 4
"""Of means."""
_TEXTS: Mapping[Summary, str] = {
    "peak": "highest rating",
    "mean": "mean rating",
    "last": "last rating",
}


def course_instrument(instrument: Instrument, summaries: Sequence[Summary]) -> Instrument:
    """Return the instrument whose items are summaries of courses: ``fms_course``."""
    answers = instrument.answers
    of_ratings = {"low": answers.low, "high": answers.high, "step": answers.step}
    fine = common_divisor(Fraction(1, 10**DECIMALS), answers.resolution, exact(answers.high))
    lines = [
        f"# Made by an import of ratings during exposure ({instrument.name}).",
        f"name = {toml_value(f'{instrument.name}_course')}",
        f"short = {toml_value(f'{instrument.short} during exposure')}",
        f"title = {toml_value(f'{instrument.title}, during exposure')}",
        f"citation = {toml_value(instrument.citation)}",
        'rule = "of the ratings of an exposure, in the order of their times; missed ones left out"',
        f"primary = {toml_value(summaries[0])}",
        f"answers = {toml_value(of_ratings)}",
    ]
    for name in summaries:
        step = plain_number(fine) if name == "mean" else answers.step
        lines += ["[[items]]", f"name = {toml_value(name)}", f"text = {toml_value(_TEXTS[name])}"]
        lines += [f"answers = {toml_value({**of_ratings, 'step': step})}"]
    return parse_instrument("\n".join(lines) + "\n")


def sum_up(
    imported: Imported,
    ratings: Mapping[tuple[str, Moment], tuple[Place, Sequence[Summary], list[Rating]]],
    known: Mapping[str, Instrument],
) -> None:
    """Add the summaries of every course to what was imported."""
    wanted: dict[str, dict[Summary, None]] = defaultdict(dict)
    for (name, moment), (place, summaries, course) in ratings.items():
        if not summaries:
            continue
        wanted[name] |= dict.fromkeys(summaries)
        given = [r.response for r in sorted(course, key=lambda r: r.onset_s)]
        answers = [answer for answer in given if answer is not None]
        sheet = Sheet(place, {each: _summary(each, answers) for each in summaries})
        imported.sheets[f"{name}_course", moment] = sheet
    for name, items in wanted.items():
        made = course_instrument(known[name], [*items])
        imported.instruments[made.name] = made


def _summary(name: Summary, answers: Sequence[Answer]) -> Answer | None:
    if not answers:
        return None
    if name == "mean":
        return round(sum(answers) / len(answers), DECIMALS)
    return max(answers) if name == "peak" else answers[-1]
