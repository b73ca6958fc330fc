"""How people answered: how long it took them, and whether they gave one answer to everything."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.csv_table import CsvTable, number_or_none
from vrcomfort.records.names import natural
from vrcomfort.records.session_rows import QuestionnaireRow

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vrcomfort.questionnaire import Answer
    from vrcomfort.report.study_data import StudyData

FAST_S = 2.0
"""Seconds per question below which answers are suspected to be given without reading (Huang et
al., 2012)."""
# One or two equal answers are no pattern.
FEWEST_ITEMS = 3
_WHOSE = ("participant", "session", "trial", "condition", "timepoint", "instrument")


@dataclass(frozen=True)
class StraightLined:
    """A questionnaire with one answer, other than 0, to everything."""

    participant: str
    questionnaire: str
    place: str
    answer: Answer | None


@dataclass(frozen=True)
class AnsweringTimes:
    """Seconds from a question to its answer; `fast` questionnaires have a median below `fast_s`."""

    answers: int
    p5_s: float
    median_s: float
    p95_s: float
    questionnaires: int
    fast: int
    fast_people: tuple[str, ...]
    fast_s: float


@dataclass(frozen=True)
class AnsweringPatterns:
    """Answering patterns and times; `times` is None where none were recorded.

    `questionnaires` are those with enough items for a pattern, `all_zero` those of them with 0 for
    everything.
    """

    questionnaires: int
    all_zero: int
    straight_lined: tuple[StraightLined, ...]
    times: AnsweringTimes | None


def answering(study: StudyData) -> AnsweringPatterns:
    """Return answering times and patterns of all questionnaires."""
    whole = [s for s in study.sheets if len(s.answers) >= FEWEST_ITEMS]
    alike = [s for s in whole if len(set(s.answers.values())) == 1]
    same = [s for s in alike if not {0, None} & set(s.answers.values())]
    return AnsweringPatterns(
        questionnaires=len(whole),
        all_zero=sum(set(s.answers.values()) == {0} for s in alike),
        straight_lined=tuple(
            StraightLined(s.participant, s.name, s.place, next(iter(s.answers.values())))
            for s in same
        ),
        times=_times(study, {s.participant for s in study.sheets}),
    )


def _times(study: StudyData, people: set[str]) -> AnsweringTimes | None:
    """Describe the seconds from one question to its answer, by questionnaire."""
    taken: dict[tuple[str, ...], list[float]] = defaultdict(list)
    for table in study.folder.tables(QuestionnaireRow):
        for whose, seconds in _seconds(table):
            if whose[0] in people:
                taken[whose].append(seconds)
    if not taken:
        return None
    fast = [whose for whose, seconds in taken.items() if np.median(seconds) < FAST_S]
    low, median, high = np.percentile(list(chain.from_iterable(taken.values())), [5, 50, 95])
    return AnsweringTimes(
        answers=sum(map(len, taken.values())),
        p5_s=float(low),
        median_s=float(median),
        p95_s=float(high),
        questionnaires=len(taken),
        fast=len(fast),
        fast_people=tuple(sorted({whose[0] for whose in fast}, key=natural)),
        fast_s=FAST_S,
    )


def _seconds(table: CsvTable) -> Iterator[tuple[tuple[str, ...], float]]:
    """Yield the keys of each answer, and the seconds that it took."""
    header = [name.lower() for name in table.header]
    if not {"asked_s", "answered_s", "participant"} <= set(header):
        return
    asked, answered = header.index("asked_s"), header.index("answered_s")
    whose = [header.index(name) for name in _WHOSE if name in header]
    for cells in table.rows:
        start, end = number_or_none(cells[asked]), number_or_none(cells[answered])
        if start is not None and end is not None and end >= start:
            yield tuple([cells[place].strip() for place in whose]), end - start
