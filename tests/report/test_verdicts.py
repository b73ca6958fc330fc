"""What a sentence says and the interval beside it agree, and a mean difference has one interval."""

import random
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.support.made_studies import left_under_one
from tests.support.report import (
    HEAD,
    ONE_SCORE,
    Study,
    answers,
    build_report,
    foreign,
    planned_report,
    results_of,
    write_csv,
)
from vrcomfort.report.analyses import outcome_sentences, sentences
from vrcomfort.report.derived_plan import plan_of
from vrcomfort.report.families import disagreement, holds, is_shown, verdict_alone
from vrcomfort.report.plan_files import load_plan
from vrcomfort.report.results import Results, analyse
from vrcomfort.report.rows import as_json
from vrcomfort.report.study_data import read_study
from vrcomfort.report.words import interval, p_value
from vrcomfort.stats.means import MeanInterval
from vrcomfort.stats.multiplicity import holm, holm_levels

SHOWN = re.compile(r"higher (?:under|in) |lower (?:under|in) |more preferred|more of one went")
NOT_SHOWN = re.compile(r"no (?:difference|preference|correlation)\b.* (?:was|could be) shown")
INTERVAL = re.compile(
    r"(?P<left>[\[(])(?P<low>[−\d.∞]+),\u00a0(?P<high>[−\d.∞]+)(?P<right>[\])])"
    r"(?P<hole> without 0)?(?P<said> \(which (?:in|ex)cludes [.\d]+, though the test)?"
)
PLAN = """\
name = "p"
title = "P"
outcomes = ["T", "N", "D"]
mixed_model = []
anova = []
{choices}
[[families]]
name = "all"
outcomes = ["T", "N", "D"]
"""
DESIGNS = (
    '[[contrasts]]\na = "a"\nb = "b"\n[[contrasts]]\na = "a"\nb = "c"\n',
    '[[contrasts]]\na = "b"\nb = "c"\ntest = "sign"\n'
    '[[contrasts]]\na = "a"\nb = "c"\ntest = "paired_t"\n[[contrasts]]\na = "a"\nb = "c"\n',
    '[[contrasts]]\na = "x"\nb = "y"\nbetween = "group"\n'
    '[[contrasts]]\na = "x"\nb = "y"\nbetween = "group"\ntest = "welch_t"\n',
    '[[correlations]]\nx = "T"\ny = "N"\n[[correlations]]\nx = "T"\ny = "D"\nmethod = "kendall"\n'
    '[[preferences]]\nname = "liked"\ncolumn = "liked"\na = "x"\nb = "y"\n',
)
CHOICES = (
    "", 'zeros = "wilcox"\n', 'alternative = "greater"\n', 'alternative = "less"\n',
    'p_value = "asymptotic"\n', 'shift_interval = "order_statistics"\n', "confidence = 0.9\n",
    'rank_biserial_interval = "effectsize"\n',
)  # fmt: skip


def random_study(folder: Path, seed: int) -> Path:
    """Three conditions, few people, scores with zeros and ties, and an effect or none."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    people = [f"P{i}" for i in range(chance.randint(4, 14))]
    effect = chance.choice((0, 0, 3, 6))
    scores = {
        who: {
            name: max(0, chance.choice((0, 0, 1, 2, 5, 11)) + effect * place)
            for place, name in enumerate("abc")
        }
        for who in people
    }
    rows = [
        {"participant": who, "status": "completed", "group": chance.choice("xy"),
         "liked": chance.choice(("x", "x", "y", ""))}
        for who in people
    ]  # fmt: skip
    write_csv(folder / "participants.csv", ("participant", "status", "group", "liked"), rows)
    return foreign(folder / "questionnaires.csv", scores).parent


def results_by(folder: Path, text: str) -> Results:
    """Return the results of a study, without a page."""
    study = read_study(folder)
    file = folder / "plan.toml"
    file.write_text(text, "utf-8")
    return analyse(study, load_plan(file, study.instruments.values()))[0]


def contradictions(line: str, claim: str) -> list[str]:
    """Return the intervals of a sentence that say another thing of the null value than it."""
    null = {"share of": 0.5, "share above": 0.5}
    of = next((value for words, value in null.items() if words in line), 0.0)
    wrong = []
    for found in INTERVAL.finditer(line):
        low, high = (float(found[end].replace("−", "-").replace("∞", "inf")) for end in (2, 3))
        share = "share" in line[: found.start()].rpartition(";")[2]
        value = of if share else 0.0
        above = low < value or (low == value and found["left"] == "[")
        below = high > value or (high == value and found["right"] == "]")
        held = above and below and not found["hole"]
        if held == bool(SHOWN.search(claim)) and not found["said"]:
            wrong.append(found[0])
    return wrong


@pytest.mark.parametrize(
    ("p", "smallest_p", "higher", "verdict"),
    [
        (None, 0.001, True, None),
        (0.05, 0.001, True, "higher"),
        (0.05, 0.001, False, "lower"),
        (0.051, 0.05, True, "not_shown"),
        (0.2, 0.051, True, "not_possible"),
    ],
)
def test_a_test_in_no_family_decides_by_its_own_p(p, smallest_p, higher, verdict):
    assert verdict_alone(p, smallest_p, 0.95, higher=higher) == verdict


@pytest.mark.parametrize("seed", range(8))
def test_no_sentence_contradicts_an_interval_beside_it(tmp_path, seed):
    choices = CHOICES[seed] + 'withdrawals = "complete_pairs"\n'
    design = DESIGNS[seed % len(DESIGNS)]
    if "preferences" in design:
        choices = choices.replace('alternative = "less"\n', "")
    results = results_by(random_study(tmp_path, seed), PLAN.format(choices=choices) + design)
    words = results.vocabulary
    rows = results.rows
    said = [line for _, line in outcome_sentences(rows, words)] + sentences(rows, words)
    assert said
    for line in said:
        if "could not be" in line.claim or "nobody" in line.claim:
            continue
        assert bool(SHOWN.search(line.claim)) != bool(NOT_SHOWN.search(line.claim)), line
        assert not contradictions(line.text, line.claim), line.text


@pytest.mark.parametrize("seed", range(4))
def test_the_default_intervals_agree_with_the_decision_by_construction(tmp_path, seed):
    """Of the differences in points: those of r may not, and say so."""
    design = DESIGNS[seed % 3]
    results = results_by(random_study(tmp_path, seed), PLAN.format(choices="") + design)
    for row in (*results.tests, *results.comparisons):
        decision = row.decision
        if row.not_tested:
            assert decision.verdict is None
            continue
        p = row.p if decision.p_holm is None else decision.p_holm
        assert is_shown(decision.verdict) == (p <= 0.05) == (row.p <= decision.level)
        said = row.reported
        found = said.shift if hasattr(said, "shift") else said.difference and said.difference.of
        if found and (found.low, found.high) != (None, None):
            assert is_shown(decision.verdict) != holds(found, 0.0)
            assert not disagreement(decision.verdict, found)
        assert (decision.simultaneous is None) == (decision.level >= 1 - 0.95)


@pytest.mark.parametrize("seed", range(2))
def test_a_mean_difference_has_one_interval(tmp_path, seed):
    """That of its t test, of the pairs or where the plan asks for one; none beside the ranks."""
    plan = PLAN.partition("[[families]]")[0] + "families = []\n" + DESIGNS[1]
    results = as_json(results_by(random_study(tmp_path, seed), plan.format(choices="")))
    ends: dict[tuple[str, ...], set[tuple[float | None, ...]]] = {}
    for test in results["tests"]:
        pair = test["outcome"], test["a"], test["b"]
        found = ends.setdefault(pair, set())
        described, t_test = test["descriptives"]["difference"], test["t_test"]
        assert "mean_low" not in described
        if t_test:
            assert t_test["mean"] == described["mean"]
            found.add((t_test["mean"], t_test["low"], t_test["high"]))
    for row in results["comparisons"]:
        if row["test"] == "paired_t" and not row["not_tested"]:
            found = row["difference"]
            pair = row["outcome"], row["a"], row["b"]
            ends[pair].add((found["estimate"], found["low"], found["high"]))
    assert all(len(found) <= 1 for found in ends.values()), ends
    assert any(None not in each for found in ends.values() for each in found)


def test_holm_decides_on_each_test_at_its_own_level():
    """At or below it exactly where the adjusted p is at most .05."""
    chance = random.Random(1)  # noqa: S311 - no secret
    for _ in range(300):
        p = [
            None if chance.random() < 0.1 else chance.choice((0.001, 0.01, 0.02, chance.random()))
            for _ in range(chance.randint(1, 7))
        ]
        for each, adjusted, level in zip(p, holm(p), holm_levels(p), strict=True):
            if each is None:
                assert level is None
            else:
                assert adjusted is not None
                assert (each <= level) == (adjusted <= 0.05)
                assert 0.05 / len(p) <= level <= 0.05


@pytest.mark.parametrize(
    ("differences", "verdict", "words"),
    [
        ([4, 3, 2, 5, 1], "not_possible", "with so few people, no difference could be shown"),
        ([4, 3, 2, 5, 1, 6], "higher", "higher under a"),
        ([4, 3, 2, 5, 1, -6], "not_shown", "no difference was shown"),
        ([4, 3, 2, 5, 1, 0, 0, 0], "not_possible", "so few people whose scores differ"),
    ],
)
def test_so_few_people_that_p_cannot_be_small_are_told(tmp_path, differences, verdict, words):
    scores = {f"P{i}": {"a": 8 + d, "b": 8} for i, d in enumerate(differences)}
    source = foreign(tmp_path / "questionnaires.csv", scores)
    lines = f'{ONE_SCORE}zeros = "wilcox"\n'
    summary = planned_report(source, out=tmp_path / "o", lines=lines)
    (test,) = results_of(summary)["tests"]
    assert test["verdict"] == verdict
    page = summary.index.read_text("utf-8")
    assert words in page
    assert ("with so few people, at least .062" in page) == (verdict == "not_possible")


def test_so_many_tests_that_no_p_is_small_enough_are_told(tmp_path):
    """Six pairs: p is .031 at least, and .094 after adjustment over the three subscales."""
    answered = [answers(5 + k) for k in range(6)]
    rows = [
        {"participant": f"P{k}", "condition": c, "item": item, "response": value * (c == "a")}
        for k, given in enumerate(answered)
        for c in "ab"
        for item, value in given.items()
    ]
    write_csv(tmp_path / "q.csv", ("participant", "condition", "item", "response"), rows)
    summary = build_report(tmp_path / "q.csv", out=tmp_path / "o")
    total, nausea, *_ = summary.headlines
    assert total.startswith("Total severity: higher under a")
    assert "with so few people for so many tests, no difference could be shown" in nausea


def worst_ranked(tmp_path: Path, stayed: list[int], left: int) -> tuple[str, ...]:
    """Return the answers of a study in which some left under b; the others have 2 under b."""
    study = Study(tmp_path / "s")
    for i, total in enumerate(stayed):
        study.session(f"P{i}", 1, 0, [("a", "x", total), ("b", "x", 2)])
        study.person(f"P{i}", "a")
    for i in range(left):
        study.session(f"Q{i}", 1, 0, [("a", "x", 4), ("b", "x", None)], "withdrawn")
        study.person(f"Q{i}", "a", "withdrawn")
    lines = f'{ONE_SCORE}withdrawals = "worst_rank"\n'
    return planned_report(study.folder, out=tmp_path / "o", lines=lines).headlines


def test_people_who_left_may_show_a_difference_that_nobody_who_stayed_has(tmp_path):
    (line,) = worst_ranked(tmp_path, [2, 2, 2], 7)
    assert "lower under a" in line
    said = "difference of the 3 who stayed (the test ranks those who left as worst) was 0.00"
    assert said in line
    assert "r\u00a0=\u00a0– (nobody’s score differed)" in line


def test_who_left_and_is_ranked_worst_is_not_in_the_interval_of_who_stayed(tmp_path):
    """All six who stayed are higher under a, and the five who left under b rank below."""
    (line,) = worst_ranked(tmp_path, [9, 10, 11, 12, 13, 14], 5)
    assert "no difference was shown" in line
    assert "difference of the 6 who stayed (the test ranks those who left as worst)" in line
    assert "(no 95\u00a0% CI: the test is of ranks)" in line  # theirs would exclude 0


@pytest.mark.parametrize(
    ("found", "written"),
    [
        ({"low": 0.004, "high": 12.0}, "[0.004,\u00a012.00]"),
        ({"low": -3.0, "high": -0.0002}, "[−3.00,\u00a0−0.0002]"),
        ({"low": 0.0, "high": 1e-13}, "[0.00,\u00a00.00]"),
    ],
)
def test_an_end_that_is_not_zero_is_not_printed_as_zero(found, written):
    assert interval(SimpleNamespace(**found)) == written
    assert interval(MeanInterval(0.2, 0.9996), null=1.0) == "[0.20,\u00a00.9996]"


@pytest.mark.parametrize(
    ("p", "written"), [(0.0496, ".0496"), (0.0504, ".0504"), (0.05, ".050"), (0.0512, ".051")]
)
def test_a_p_beside_the_usual_level_is_not_rounded_to_it(p, written):
    assert p_value(p) == written


def test_the_derived_plan_of_several_conditions_has_no_contradiction_either(tmp_path):
    chance = random.Random(7)  # noqa: S311 - no secret
    scores = {f"P{i}": {c: chance.choice((0, 1, 4, 9)) for c in "abc"} for i in range(10)}
    study = read_study(foreign(tmp_path / "q.csv", scores))
    results = analyse(study, plan_of(study))[0]
    words = results.vocabulary
    for _, line in outcome_sentences(results.rows, words):
        assert not contradictions(line.text, line.claim), line.text


def test_ranks_of_those_who_left_have_no_interval_of_those_who_stayed(tmp_path):
    """The test is of everybody, shift and r of those with scores: another theory."""
    source = left_under_one(tmp_path / "s")
    results = results_by(source, f'{HEAD}{ONE_SCORE}withdrawals = "worst_rank"\n')
    (row,) = results.tests
    assert row.ranked_worst
    assert row.reported is not None
    for found in (row.reported.shift, row.reported.effect):
        assert found is not None
        assert (found.low, found.high) == (None, None)
    (line,) = (line for _, line in outcome_sentences(results.rows, results.vocabulary))
    assert "(no 95\u00a0% CI: the test is of ranks)" in line.text
    assert "[" not in line.text
