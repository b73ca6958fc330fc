"""Answers in, scores out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from vrcomfort.errors import InputError
from vrcomfort.questionnaire.answers import Answer
from vrcomfort.questionnaire.instruments import Instrument
from vrcomfort.questionnaire.scales import AnswerTable, RawScores, Scale, raw_scores
from vrcomfort.questionnaire.tables import Sheet, never_zero, read_sheets

Cell: TypeAlias = str | int | float | None


class Score(NamedTuple):
    """A score: `raw` steps of the scale's unit, and the points that they are."""

    raw: int
    points: float


class ScoredFile(NamedTuple):
    """Rows of scores, and the lines of the questionnaires that were left out."""

    rows: list[dict[str, Cell]]
    left_out: list[int]


def score(instrument: Instrument, answers: Mapping[str, Answer | None]) -> dict[str, Score | None]:
    """Score one questionnaire: item name → answer.

    Returns
    -------
    dict
        Scale → score; None where too few of its items are answered: a sum without them would be
        too low.

    Raises
    ------
    InputError
        If an item is unknown, an answer is none of its answers, or weights do not add up.
    """
    for name, answer in answers.items():
        item = next((each for each in instrument.items if each.name == name), None)
        if item is None:
            raise InputError(f"`{name}` is not an item of the {instrument.short}")
        if answer is not None and not item.answers.has(answer):
            taken = f"{instrument.short} answers are {item.answers.in_words}"
            raise InputError(f"`{name}` is {answer}; {taken}")
    if wrong := wrong_weights(instrument, answers):
        raise InputError(wrong)
    return _scores(instrument, score_all(instrument, [answers]), 0)


def score_all(instrument: Instrument, answers: Sequence[Mapping[str, Answer | None]]) -> RawScores:
    """Score many questionnaires of checked answers, in raw numbers."""
    steps, given = {}, {}
    for item in instrument.items:
        column = [each.get(item.name) for each in answers]
        found = np.array(column, dtype=np.float64)  # None is NaN
        given[item.name] = ~np.isnan(found)
        in_steps = np.nan_to_num(found) / float(item.answers.resolution)
        steps[item.name] = np.rint(in_steps).astype(np.int64)
    return raw_scores(instrument.scales, AnswerTable(steps, given))


def wrong_weights(instrument: Instrument, answers: Mapping[str, Answer | None]) -> str | None:
    """Note weights of a person that do not add up to their sum, as 15 comparisons do."""
    for scale in instrument.scales:
        weights = [answers.get(name) for _, name in scale.weights]
        given = [weight for weight in weights if weight is not None]
        if not scale.weights_sum or not given:
            continue
        if len(given) < len(weights):
            return f"only {len(given)} of the {len(weights)} weights are there; give all, or none"
        if sum(given) != scale.weights_sum:
            return f"the weights add up to {sum(given)}, not {scale.weights_sum}; correct them"
    return None


def _scores(instrument: Instrument, found: RawScores, row: int) -> dict[str, Score | None]:
    return {
        scale.name: _score(scale, int(found.raw[scale.name][row]))
        if found.known[scale.name][row]
        else None
        for scale in instrument.scales
    }


def _score(scale: Scale, raw: int) -> Score:
    return Score(raw, scale.points(raw))


def score_file(
    file: Path,
    instrument: Instrument,
    *,
    skip_incomplete: bool = False,
    coded_from: Answer | None = None,
) -> ScoredFile:
    """Score every questionnaire of a CSV file (wide or long; see `read_sheets`).

    Parameters
    ----------
    skip_incomplete
        Leave out questionnaires in which a score is missing that every complete one has.
    coded_from
        The number that stands for the lowest answer. Without it, that is the instrument's own, and
        answers of which none is 0 are refused.

    Returns
    -------
    ScoredFile
        One row per questionnaire in the file's order: the file's other columns (long files: the
        columns of `LONG_KEYS`), then raw numbers (integers) and scores. Blank (None) where too
        little is answered. Scales that no questionnaire has are left out.

    Raises
    ------
    InputError
        If a column or an answer is wrong, with line and column.
    """
    sheets = read_sheets(Path(file), instrument, allow_blank=skip_incomplete, coded_from=coded_from)
    if coded_from is None:
        _require_zeros(file, instrument, sheets)
    for sheet in sheets:
        if wrong := wrong_weights(instrument, sheet.answers):
            raise InputError(wrong, file=file, line=sheet.line)
    rows = score_sheets(instrument, sheets)
    if not skip_incomplete:
        return ScoredFile(rows, [])
    needed = [scale.column for scale in instrument.scales if scale.name in instrument.needed]
    complete = [all(row[name] is not None for name in needed) for row in rows]
    return ScoredFile(
        [row for row, whole in zip(rows, complete, strict=True) if whole],
        [sheet.line for sheet, whole in zip(sheets, complete, strict=True) if not whole],
    )


def score_sheets(instrument: Instrument, sheets: Sequence[Sheet]) -> list[dict[str, Cell]]:
    """Return a row for each questionnaire: its keys, raw numbers, and scores.

    Blank (None) where too little is answered. Scales that no questionnaire has are left out,
    unless every complete one has them.
    """
    found = score_all(instrument, [sheet.answers for sheet in sheets])
    scored = [_scores(instrument, found, row) for row in range(len(sheets))]
    there = [
        scale
        for scale in instrument.scales
        if scale.name in instrument.needed or found.known[scale.name].any()
    ]
    return [_row(sheet, scores, there) for sheet, scores in zip(sheets, scored, strict=True)]


def _require_zeros(file: Path, instrument: Instrument, sheets: Sequence[Sheet]) -> None:
    """Raise `InputError` where no answer is 0: all of them may be too high by one."""
    given = (answer for sheet in sheets for answer in sheet.answers.values())
    answered = never_zero(instrument, Counter(a for a in given if a is not None))
    if answered:
        high = instrument.high + 1
        message = f"none of {answered} answers is 0: are they 1 to {high}, with no {high} among"
        hint = "give --coded-from 1 to take 1 off each, or --coded-from 0 if they are right"
        raise InputError(f"{message} them? {hint}", file=file)


def _row(sheet: Sheet, scores: Mapping[str, Score | None], scales: list[Scale]) -> dict[str, Cell]:
    found = [(scale, scores[scale.name]) for scale in scales]
    raw = {f"{scale.column}_raw": each.raw if each else None for scale, each in found}
    return {**sheet.keys, **raw, **{s.column: each.points if each else None for s, each in found}}
