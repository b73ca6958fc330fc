"""Made studies, each with one thing that changes its answer: what a page has to say first."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

from tests.support.report import ITEMS, ONE_SCORE, WITHOUT_MODELS, Study, foreign, write_csv
from vrcomfort.importing import MappingFile, parse_mapping, write_study
from vrcomfort.importing.convert import import_files
from vrcomfort.records import RatingRow

SHORT_FORM = """\
format_version = 1
[[tables]]
files = ["answers.csv"]
participant = { column = "who" }
condition = { column = "what" }
timepoint = { column = "when" }
[[tables.questionnaires]]
instrument = "ssq"
not_asked = ["burping", "increased_salivation"]
"""
Totals = dict[str, dict[str, int]]


def totals(people: int, conditions: str = "ab", seed: int = 1, effect: int = 0) -> Totals:
    """Plain raw sums of SSQ items, with an effect of the second condition."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    return {
        f"P{i + 1:02d}": {
            name: max(0, chance.choice((0, 0, 1, 2, 4, 7)) + effect * (place == 1))
            for place, name in enumerate(conditions)
        }
        for i in range(people)
    }


def _answered(folder: Path, answer: Callable[[random.Random, int, str], int], people: int = 12,
              items: tuple[str, ...] = ITEMS) -> Path:  # fmt: skip
    """Write one answer for each person, condition and item."""
    chance = random.Random(3)  # noqa: S311 - no secret
    rows = [
        {"participant": f"P{i + 1:02d}", "condition": condition, "item": item,
         "response": answer(chance, i, condition)}
        for i in range(people) for condition in "ab" for item in items
    ]  # fmt: skip
    file = folder / "questionnaires.csv"
    write_csv(file, ("participant", "condition", "item", "response"), rows)
    return file


def primary_missing(folder: Path) -> Path:
    return foreign(folder / "questionnaires.csv", totals(12))


def short_form(folder: Path) -> Path:
    """Return an import whose mapping says that two items were not asked."""
    kept = tuple(item for item in ITEMS if item not in {"burping", "increased_salivation"})
    chance = random.Random(4)  # noqa: S311 - no secret
    rows = [
        {"who": f"P{i:02d}", "what": condition, "when": "post",
         **{item: chance.choice((0, 0, 1, 2)) for item in kept}}
        for i in range(12) for condition in "ab"
    ]  # fmt: skip
    file = folder / "answers.csv"
    write_csv(file, ("who", "what", "when", *kept), rows)
    mapping = MappingFile(parse_mapping(SHORT_FORM, None), folder / "map.toml", SHORT_FORM)
    write_study(folder / "study", import_files([file], mapping.mapping), mapping, [file])
    return folder / "study"


def unadjusted(folder: Path) -> Path:
    """Three contrasts: p of the first is .031 alone, .094 after Holm's adjustment."""
    scores = {
        f"P{i + 1:02d}": {"a": 6 + i, "b": 5 - i // 2, "c": 6 + i + (-1) ** i * (i + 1)}
        for i in range(6)
    }
    return foreign(folder / "questionnaires.csv", scores)


def left_under_one(folder: Path) -> Path:
    study = Study(folder)
    study.describe("tiny", a="Blur", b="No blur")
    for i, (name, each) in enumerate(totals(24, seed=5).items()):
        order = "ab" if i % 2 else "ba"
        gone = i % 3 == 0
        met = order if not gone else order[: order.index("a") + 1]
        shown = [(c, "x", None if gone and c == "a" else each[c]) for c in met]
        status = "withdrawn" if gone else "completed"
        study.session(name, 1, 0, shown, status=status)
        study.person(name, order, status)
    return folder


def many_conditions(folder: Path) -> Path:
    return foreign(folder / "questionnaires.csv", totals(6, "abcdefghijklm"))


def no_effect_at_all(folder: Path) -> Path:
    scores = {name: {"a": each["a"], "b": each["a"]} for name, each in totals(12).items()}
    return foreign(folder / "questionnaires.csv", scores)


def reversed_scale(folder: Path) -> Path:
    return _answered(folder, lambda c, *_: 3 - c.choice((0, 0, 0, 1, 1, 2)))


def from_one(folder: Path) -> Path:
    """Answers coded 1 to 4 without a 4, and 2 in 100 that were left out as 0."""

    def answer(chance: random.Random, *_: object) -> int:
        return 0 if chance.random() < 0.02 else chance.choice((1, 1, 1, 2, 2, 3))

    return _answered(folder, answer)


def two_people(folder: Path) -> Path:
    return foreign(folder / "questionnaires.csv", totals(2, effect=9))


def five_people(folder: Path) -> Path:
    return foreign(folder / "questionnaires.csv", totals(5, effect=12))


def rating_gaps(folder: Path) -> Path:
    """FMS every 10 s; of P03 nothing is there from 20 s to 70 s of one exposure."""
    study = Study(folder)
    study.describe("tiny", a="a", b="b")
    for i, (name, each) in enumerate(totals(8).items()):
        order = [(c, "x", t) for c, t in each.items()][:: 1 - 2 * (i % 2)]
        path = study.session(name, 1, 0, order)
        rows = [
            {"participant": name, "session": 1, "trial": trial, "condition": order[trial - 1][0],
             "onset_s": 100.0 * trial + at, "latency_s": 1.0, "instrument": "fms",
             "response": (i + at // 20) % 9, "missed": 0}
            for trial in (1, 2) for at in range(10, 90, 10)
            if not (name == "P03" and trial == 2 and 20 < at < 70)
        ]  # fmt: skip
        write_csv(path / "ratings.csv", RatingRow.columns(), rows)
    return folder


def one_id_of_two(folder: Path) -> Path:
    study = Study(folder)
    study.describe("tiny", a="a", b="b")
    for i, (name, each) in enumerate(totals(10).items()):
        order = [(c, "x", t) for c, t in each.items()][:: 1 - 2 * (i % 2)]
        study.session(name, 1, 0, order)
        if name == "P04":
            study.session(name, 2, 1, [("a", "x", 9), ("b", "x", 3)])
    return folder


def without_one_condition(folder: Path) -> Path:
    scores = totals(14)
    del scores["P07"]["b"]
    return foreign(folder / "questionnaires.csv", scores)


def identical_answers(folder: Path) -> Path:
    return _answered(folder, lambda *_: 1)


MADE: dict[str, tuple[Callable[[Path], Path], str]] = {
    "a planned primary outcome missing": (primary_missing, "No primary outcome"),
    "a designed short form": (short_form, "the SSQ is a short form"),
    "an unadjusted interval that excludes 0": (unadjusted, "its unadjusted .* excludes 0"),
    "all drop-outs under one condition": (
        left_under_one,
        "left did so under Blur: .*log-rank within people p.* ranked as worst p",
    ),
    "thirteen conditions": (many_conditions, "13 conditions make 78 comparisons"),
    "an effect of exactly zero": (no_effect_at_all, "is the same under a and b for every"),
    "a reversed scale": (reversed_scale, "is the scale reversed"),
    "coded 1 to 4 with 2 % zeros": (from_one, "are they coded 1 to 4"),
    "two people": (two_people, r"with 2 people no p below \.5 exists"),
    "five people": (five_people, r"with 5 people no p below \.0625 exists"),
    "silent gaps in ratings": (rating_gaps, "1 gap in the ratings of the FMS of P03"),
    "two people with one id": (one_id_of_two, "P04 has more exposures .* the id of two people"),
    "a participant without one condition": (without_one_condition, "P07 never met b"),
    "identical answers": (identical_answers, "all 384 answers to the SSQ are 1"),
}
"""Name → how it is made, and what the first screen says of it."""
CONTRASTS = "".join(f'[[contrasts]]\na = "{a}"\nb = "{b}"\n' for a, b in ("ab", "ac", "bc"))
LINES = {
    "a planned primary outcome missing": f'outcomes = ["vrsq.total", "T"]\n{WITHOUT_MODELS}',
    "an unadjusted interval that excludes 0": (
        f'{ONE_SCORE}{CONTRASTS}[[families]]\nname = "all"\noutcomes = ["T"]\n'
    ),
}
"""Lines of the plans of some; the others' are those of one score."""
