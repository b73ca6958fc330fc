"""Plausibility warnings: answers and ratings that may mean something else."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.plurals import counted
from vrcomfort.questionnaire import never_zero
from vrcomfort.recordings import GAP
from vrcomfort.records.names import natural
from vrcomfort.report.words import number

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from vrcomfort.questionnaire import Answer, Instrument
    from vrcomfort.report.study_data import StudyData

FEWEST_ANSWERS = 100
"""Answers to an instrument from which on their distribution says something."""
FEW_ZEROS = 0.05
"""Share of answers up to which “none” is too rare for symptoms."""
HIGH = 0.6
"""Share of the scale from which on the mean answer about symptoms is implausible."""
MOST_STEPS = 6
"""Of a scale that answers coded from 1 may be mistaken for."""
MOST_NAMED = 8


def plausibility_warnings(study: StudyData, of_choices: Collection[str]) -> list[str]:
    """Return the sentences, without their full stops; `of_choices` are no scores."""
    found: list[str] = []
    for name, counts in answers_by_instrument(study).items():
        if name not in of_choices:
            found += _of_answers(study.instruments[name], counts)
    return [*found, *_same_answer_always(study, of_choices), *_gaps_in_ratings(study)]


def answers_by_instrument(study: StudyData) -> dict[str, Counter[Answer]]:
    """Return how often each answer was given, by instrument."""
    counts: dict[str, Counter[Answer]] = defaultdict(Counter)
    for sheet in study.sheets:
        counts[sheet.keys["instrument"]].update(
            answer for answer in sheet.answers.values() if answer is not None
        )
    return counts


def _of_answers(instrument: Instrument, counts: Mapping[Answer, int]) -> Iterator[str]:
    """Yield the likeliest fault of an instrument's answers as a whole."""
    low, high, answered = instrument.low, instrument.high, sum(counts.values())
    if len(counts) == 1 and answered >= FEWEST_ANSWERS:
        (only,) = counts
        yield (
            f"all {answered} answers to the {instrument.short} are {only}: is this what people "
            "answered, or a default of the form?"
        )
        return
    symptoms = instrument.asks == "symptoms" and low == 0 and answered >= FEWEST_ANSWERS
    mean = sum(float(answer) * n for answer, n in counts.items()) / max(answered, 1)
    if symptoms and mean >= HIGH * high:
        yield (
            f"the mean answer to the {instrument.short} is {number(mean, 1)} of 0 (no symptom) to "
            f"{high}: is the scale reversed? Then 0 stands for the strongest symptoms, and "
            "differences have the wrong sign"
        )
    elif never_zero(instrument, counts):
        yield (
            f"none of {answered} answers to the {instrument.short} is 0: are they coded 1 to "
            f"{high + 1}, with no {high + 1} among them? Then every score is too high; take 1 off "
            "each answer"
        )
    elif symptoms and high <= MOST_STEPS and _few_zeros(counts, answered):
        yield (
            f"only {counts[0]} of {answered} answers to the {instrument.short} are 0, and most are "
            f"1: are they coded 1 to {high + 1}, with 0 where an answer is missing? Then every "
            "score is too high; take 1 off each answer, and leave the zeros blank"
        )


def _few_zeros(counts: Mapping[Answer, int], answered: int) -> bool:
    return counts[0] <= FEW_ZEROS * answered and counts.get(1, 0) == max(counts.values())


def _same_answer_always(study: StudyData, of_choices: Collection[str]) -> Iterator[str]:
    """Yield the participants with one answer, not 0, to every question at every timepoint."""
    given: dict[tuple[str, str], list[Counter[Answer]]] = defaultdict(list)
    for sheet in study.sheets:
        answers = Counter(each for each in sheet.answers.values() if each is not None)
        if sum(answers.values()) >= 4:
            given[sheet.keys["instrument"], sheet.participant].append(answers)
    alike: dict[str, list[str]] = defaultdict(list)
    for (name, who), sheets in given.items():
        together = sum(sheets, Counter())
        if len(sheets) > 1 and len(together) == 1 and 0 not in together and name not in of_choices:
            alike[name].append(who)
    everybody = {name: sum(key[0] == name for key in given) for name in alike}
    for name, people in alike.items():
        if len(people) == everybody[name] > 1 and len(answers_by_instrument(study)[name]) == 1:
            continue  # said of all answers
        who = some_of(sorted(people, key=natural))
        yield (
            f"{who} gave one answer to every question of the {study.instruments[name].short}, each "
            "time: were the questions read?"
        )


def some_of(people: Sequence[str]) -> str:
    """Return names in a sentence, the first of them where they are many."""
    shown = ", ".join(people[:MOST_NAMED])
    return f"{shown} and {len(people) - MOST_NAMED} more" if people[MOST_NAMED:] else shown


def _gaps_in_ratings(study: StudyData) -> Iterator[str]:
    """Yield the number of gaps in which ratings are neither there nor recorded as missed."""
    for instrument, usual in sorted(study.rating_intervals_s.items()):
        steps = [
            (s.participant, s.intervals_s) for s in study.ratings if s.instrument == instrument
        ]
        gaps = [(who, each[each > GAP * usual]) for who, each in steps]
        people = sorted({who for who, lengths in gaps if lengths.size}, key=natural)
        if not people:
            continue
        lengths = np.concatenate([each for _, each in gaps])
        known = study.instruments.get(instrument)
        yield (
            f"{counted(lengths.size, 'gaps')} in the ratings"
            f"{f' of the {known.short}' if known else ''} of {some_of(people)}, up to "
            f"{number(float(lengths.max()), 0)} s where a rating comes every {number(usual, 0)} s, "
            "and none is recorded as missed: peaks and times to a rating may lie in them; areas "
            "are missing, and means over time leave the gaps out"
        )
