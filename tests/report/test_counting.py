"""Which exposures count is one rule for all analyses of an outcome, and each says its n."""

import random
from pathlib import Path

import pytest

from tests.report.test_page import rows_of
from tests.support.report import Study, analysed, planned_report, results_of, write_csv

ONE_FACTOR = (
    'mixed_model = ["condition"]\n[[anova]]\nname = "condition"\ncolumn = "condition"\n'
    '[[contrasts]]\na = "off"\nb = "on"\n[[contrasts]]\na = "off"\nb = "on"\ntest = "paired_t"\n'
    '[[equivalence]]\noutcome = "tasks.hits"\na = "off"\nb = "on"\nlow = -1\nhigh = 1\n'
)


def shooting(
    folder: Path, people: int, left: dict[int, tuple[int, str]], seed: int = 1, each: int = 2
) -> Path:
    """A study of two conditions, `each` exposures of both; hits grow with the time that there was.

    `left` says of some people in which exposure they left, and how trials.csv calls that.
    """
    chance = random.Random(seed)  # noqa: S311 - no secret
    study, rows = Study(folder), []
    for i in range(people):
        name = f"P{i:02d}"
        order = [("off", "on"), ("on", "off")][i % 2] * each
        last, status = left.get(i, (2 * each, "completed"))
        exposures = [(condition, "x", chance.randint(0, 12)) for condition in order[:last]]
        if status != "completed":
            exposures[-1] = (exposures[-1][0], "x", None)
        study.session(name, 1, chance.randint(0, 2), exposures, status)
        study.person(name, "ab"[i % 2], "completed" if status == "completed" else "withdrawn")
        whole = [chance.randint(4, 9) for _ in exposures]
        if status != "completed":
            whole[-1] = 1
        rows += [
            {"participant": name, "session": 1, "trial": k, "hits": hits}
            for k, hits in enumerate(whole, start=1)
        ]
    write_csv(folder / "tasks.csv", ("participant", "session", "trial", "hits"), rows)
    return folder


def lines_of(text: str = ONE_FACTOR, outcomes: str = '"tasks.hits"') -> str:
    return f"outcomes = [{outcomes}]\n{text}"


@pytest.mark.parametrize("status", ["withdrawn", "stopped"])
def test_an_exposure_that_was_cut_short_has_no_count_of_hits(tmp_path, status):
    left = {0: (4, status), 3: (3, status), 6: (2, status)}
    results = analysed(shooting(tmp_path / "s", 12, left), lines_of())
    (test,), (anova,), (crossover,) = results["tests"], results["anova"], results["crossover"]
    stayed = [f"P{i:02d}" for i in range(12) if i not in left]
    assert test["participants"] == anova["participants"] == stayed
    assert anova["excluded"] == ["P00", "P03", "P06"]
    assert crossover["not_tested"] or crossover["n_ab"] + crossover["n_ba"] == 9
    assert [row["n"] for row in results["equivalence"]] == [9]
    assert [row["n_a"] for row in results["comparisons"]] == [9]
    (mixed,) = results["mixed_models"]
    assert (mixed["n_participants"], mixed["n_values"]) == (12, 9 * 4 + 3 + 2 + 1)
    reasons = {row["participant"]: row["reason"] for row in results["participants"]["left_out"]}
    assert "the exposure was cut short" in reasons["P00"]


def test_times_of_an_exposure_that_was_cut_short_are_what_they_are(tmp_path):
    study = shooting(tmp_path / "s", 6, {0: (4, "withdrawn")})
    assert analysed(study, lines_of("", '"trials.length_s"'))["tests"][0]["n"] == 6


def test_of_a_plan_with_available_pairs_every_analysis_takes_any_number(tmp_path):
    study = shooting(tmp_path / "s", 10, {2: (4, "withdrawn"), 5: (3, "withdrawn")})
    results = analysed(study, lines_of(f'withdrawals = "available_pairs"\n{ONE_FACTOR}'))
    assert results["tests"][0]["n"] == results["anova"][0]["n"] == 10
    assert [row["n"] for row in results["equivalence"]] == [10]


def test_every_analysis_on_the_page_says_its_own_n(tmp_path):
    """The first outcome lacks those who left; of the second some people lack an answer, too."""
    study = shooting(tmp_path / "s", 10, {2: (4, "withdrawn"), 5: (3, "withdrawn")})
    hits = (study / "tasks.csv").read_text("utf-8").splitlines()
    kept = [line for line in hits if not line.startswith(("P07,1,1,", "P08,1,2,"))]
    (study / "tasks.csv").write_text("\n".join([*kept, ""]), "utf-8")
    lines = lines_of(ONE_FACTOR, '"T", "tasks.hits"')
    summary = planned_report(study, out=tmp_path / "o", lines=lines)
    page = summary.index.read_text("utf-8")
    assert [test["n"] for test in results_of(summary)["tests"]] == [8, 6]
    groups = [row[0] for row in rows_of(page, "Repeated-measures ANOVA") if len(row) == 1]
    assert groups == [
        "Total severity, n = 8; excluded for missing scores: P02, P05",
        "Hits, n = 6; excluded for missing scores: P02, P05, P07, P08",
    ]
    mixed = [row[0] for row in rows_of(page, "All available data") if len(row) == 1]
    assert mixed == [
        "Total severity, 37 exposures of 10 participants", "Hits, 35 exposures of 10 participants",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("seed", "rule"), [(0, "complete_pairs"), (1, "available_pairs"), (2, "worst_rank")]
)
def test_n_is_that_of_the_test_or_the_row_names_who_is_missing(tmp_path, seed, rule):
    """Random studies in which people leave, and answers and tables have holes."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    left = {
        i: (chance.randint(1, 4), chance.choice(["withdrawn", "stopped"]))
        for i in chance.sample(range(14), 4)
    }
    study = shooting(tmp_path / "s", 14, left, seed)
    lines = (study / "tasks.csv").read_text("utf-8").splitlines()
    kept = [line for line in lines if line.startswith("participant") or chance.random() > 0.03]
    (study / "tasks.csv").write_text("\n".join([*kept, ""]), "utf-8")
    lines = lines_of(f'withdrawals = "{rule}"\n{ONE_FACTOR}', '"tasks.hits", "T"')
    results = analysed(study, lines)
    for test, anova, row in zip(
        results["tests"], results["anova"], results["comparisons"], strict=True
    ):
        people = sorted(set(test["participants"]) - set(test["ranked_worst"]))
        assert people == sorted(row["participants"]) == sorted(anova["participants"])
        assert anova["n"] == len(people)
        scored = [r for r in results["descriptives"] if r["outcome"] == test["outcome"]]
        assert scored
        assert not set(anova["excluded"]) & set(people)
    for found in results["crossover"]:
        if not found["not_tested"]:
            test = next(t for t in results["tests"] if t["outcome"] == found["outcome"])
            n = test["n"] - len(test["ranked_worst"])
            assert found["n_ab"] + found["n_ba"] + len(found["left_out"]) >= n
