"""Random studies and plans: designs, sizes, ties, drop-outs, ratings and every analysis."""

from __future__ import annotations

import json
import random
from pathlib import Path

from tests.support.report import Study, foreign, write_csv
from vrcomfort.records import ParticipantRow, RatingRow

HEADING = 'name = "p"\ntitle = "P"\n'
PAIR = '[[contrasts]]\na = "a"\nb = "b"\n'
GROUPS = '[[contrasts]]\na = "x"\nb = "y"\nbetween = "group"\n'
CORRELATED = '[[correlations]]\nx = "T"\ny = "N"\nmethod = "{}"\n'
DESIGNS = (
    "",
    PAIR,
    f'{PAIR}[[contrasts]]\na = "b"\nb = "a"\ntest = "paired_t"\n',
    f'{GROUPS}{GROUPS}test = "welch_t"\n{GROUPS}test = "student_t"\n',
    f'{PAIR}test = "sign"\n{PAIR}alternative = "less"\n',
    f'{PAIR}{PAIR}a_timepoint = "post"\nb_timepoint = "post"\n',
)
MORE = (
    CORRELATED.format("pearson"),
    CORRELATED.format("spearman"),
    CORRELATED.format("kendall"),
    CORRELATED.format("repeated_measures"),
    '[[equivalence]]\noutcome = "T"\na = "a"\nb = "b"\nlow = -9.0\nhigh = 9.0\n',
    '[[preferences]]\nname = "liked"\ncolumn = "liked"\na = "a"\nb = "b"\n',
    '[[agreement]]\noutcome = "T"\nover = "condition"\n',
    '[[ordinal]]\noutcome = "nausea"\n',
    '[[anova]]\nname = "c"\ncolumn = "condition"\n[[anova]]\nname = "g"\ncolumn = "group"\n',
    '[[exclusions]]\nname = "sick"\nscore = "T"\ntimepoint = "post"\nabove = 150.0\n',
)
CHOICES = ("", "", "",
           'zeros = "wilcox"\n', 'alternative = "greater"\n', 'p_value = "asymptotic"\n',
           "confidence = 0.9\n", "confidence = 0.99\n", 'withdrawals = "available_pairs"\n',
           'withdrawals = "worst_rank"\n', 'sums_of_squares = "II"\n', 'scores = "raw"\n',
           'mixed_model_errors = "model"\n', 'missing_items = "prorate"\n', "participants = 24\n",
           "aligned_ranks = true\n", "smallest_effect_power = 0.8\n",
           'z_scores = ["T"]\n')  # fmt: skip
FAMILIES = ("", '[[families]]\nname = "all"\noutcomes = ["T", "N", "O", "D"]\n',
            '[[families]]\nname = "parts"\noutcomes = ["N", "O", "D"]\n',
            '[[families]]\nname = "T"\noutcomes = ["T"]\nanalyses = ["tests", "anova"]\n',
            )  # fmt: skip
RATED = '[ratings]\nsummaries = ["peak", "mean", "last", "area", "slope"]\n'


def make(folder: Path, seed: int) -> tuple[Path, Path | None]:
    """Write a random study and its plan; without a plan in a third of them."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    conditions = "abcdefgh"[: chance.choice((1, 2, 2, 2, 3, 4, 8))]
    people = [f"P{i:02d}" for i in range(chance.choice((1, 2, 3, 5, 6, 8, 12, 20, 40)))]
    values = chance.choice(((0, 0, 0, 1, 5), (0, 1, 2, 5, 11, 30), (4,), (0, 48), range(20)))
    effect = chance.choice((0, 0, 2, 6, 15))
    kind = chance.choice(("recorded", "recorded", "elsewhere", "between"))
    missing = chance.choice((0, 0.05, 0.05, 0.3))
    scores = {
        who: {
            name: min(48, chance.choice(values) + effect * place)
            for place, name in enumerate(conditions)
            if chance.random() >= missing
            and (kind != "between" or conditions[i % len(conditions)] == name)
        }
        for i, who in enumerate(people)
    }
    source, rated = folder / "s", kind == "recorded" and chance.random() < 0.4
    if kind == "recorded":
        _recorded(source, scores, chance, rated=rated)
    else:
        _from_elsewhere(source, scores, chance)
    if chance.random() < 1 / 3:
        return source, None
    plan = folder / "plan.toml"
    plan.write_text(_plan(chance, len(conditions), between=kind == "between", rated=rated), "utf-8")
    return source, plan


def _plan(chance: random.Random, conditions: int, *, between: bool, rated: bool) -> str:
    """Return the text of a random plan of a study with so many conditions."""
    outcomes = ["T", "N", "O", "D"]
    if rated and chance.random() < 0.5:
        outcomes.insert(chance.choice((0, 4)), chance.choice(("ratings.peak", "ratings.area")))
    if chance.random() < 0.1:
        outcomes.insert(0, "vrsq.total")
    design = chance.choice(DESIGNS if conditions > 1 else DESIGNS[:1])
    if between and conditions > 1:
        test = chance.choice(("", 'test = "welch_t"\n'))
        design = f'{PAIR}between = "condition"\n{test}'
    wants = chance.sample(MORE if conditions > 1 else MORE[:3], chance.choice((0, 1, 3)))
    choices = {each.partition(" ")[0]: each for each in chance.choices(CHOICES, k=2)}
    return "".join([
        f"{HEADING}outcomes = {json.dumps(outcomes)}\n", *choices.values(), design, *wants,
        chance.choice(FAMILIES), RATED * rated,
    ])  # fmt: skip


def _person(who: str, chance: random.Random) -> dict[str, object]:
    status = "excluded" if chance.random() < 0.03 else "completed"
    return {"participant": who, "status": status, "group": chance.choice("xy"),
            "liked": chance.choice(("a", "a", "b", "none", ""))}  # fmt: skip


def _from_elsewhere(source: Path, scores: dict[str, dict[str, int]], chance: random.Random) -> None:
    foreign(source / "questionnaires.csv", scores)
    rows = [_person(who, chance) for who in scores]
    write_csv(source / "participants.csv", ("participant", "status", "group", "liked"), rows)


def _recorded(
    source: Path, scores: dict[str, dict[str, int]], chance: random.Random, *, rated: bool
) -> None:
    study, leave = Study(source), chance.choice((0, 0, 0.1, 0.4))
    study.describe("tiny")
    base, scenes, gap = chance.choice((None, 0, 2)), chance.choice((1, 1, 2)), chance.random() < 0.3
    for who, each in scores.items():
        order = list(each.items())
        chance.shuffle(order)
        exposures: list[tuple[str, str, int | None]] = [
            (c, f"scene {i}", min(48, t + i * chance.choice((0, 1))))
            for i in range(scenes)
            for c, t in order
        ]
        gone = bool(exposures) and chance.random() < leave
        if gone:
            exposures = exposures[: chance.randint(1, len(exposures))]
            exposures[-1] = (exposures[-1][0], exposures[-1][1], None)
        status = "withdrawn" if gone else "completed"
        if exposures:
            path = study.session(who, 1, base, exposures, status=status)
            if rated:
                _rate(path, who, exposures, chance, gone=gone, gap=gap)
        study.person(who, "s", status)
    people = [{**each, "group": chance.choice("xy"), "liked": chance.choice("aabb-").strip("-")}
              for each in study.people]  # fmt: skip
    write_csv(source / "participants.csv", (*ParticipantRow.columns(), "group", "liked"), people)


def _rate(
    folder: Path, who: str, exposures: list[tuple[str, str, int | None]], chance: random.Random, *,
    gone: bool, gap: bool,
) -> None:  # fmt: skip
    """Write FMS ratings every 10 s: some are missed, some are not there."""
    rows = []
    for trial, (condition, _, total) in enumerate(exposures, start=1):
        highest = (total or 0) // 3
        last = 40 if gone and trial == len(exposures) else 90
        silent = (20, 60) if gap and chance.random() < 0.2 else (0, 0)
        rows += [
            {"participant": who, "session": 1, "trial": trial, "condition": condition,
             "onset_s": 100.0 * trial + at, "latency_s": 1.0, "instrument": "fms",
             "response": "" if missed else min(20, highest + chance.choice((0, 0, 1, at // 20))),
             "missed": int(missed)}
            for at in range(10, last, 10) if not silent[0] < at < silent[1]
            for missed in [chance.random() < 0.05]
        ]  # fmt: skip
    write_csv(folder / "ratings.csv", RatingRow.columns(), rows)
