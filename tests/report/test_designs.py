"""Designs beyond the crossover: groups, other tests, equivalence, correlations, preferences."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support import designs
from tests.support.places import ROOT
from tests.support.report import build_report, write_csv
from vrcomfort.errors import InputError
from vrcomfort.report.exposures import Exposures
from vrcomfort.report.plan_files import load_plan
from vrcomfort.report.results import analyse
from vrcomfort.report.rows import as_json
from vrcomfort.report.study_data import read_study
from vrcomfort.stats.mann_whitney import mann_whitney
from vrcomfort.stats.t_tests import two_sample_t

PLANS = ROOT / "docs" / "plans"
STUDIES = ("between_groups", "before_and_after", "tasks_only", "preferences_only")


def analysed(folder: Path, plan: str | Path) -> tuple[dict[str, Any], Exposures]:
    if isinstance(plan, str):
        file = folder.parent / "plan.toml"
        file.write_text(f'name = "p"\ntitle = "Plan"\n{plan}\n')
        plan = file
    study = read_study(folder)
    results, scored = analyse(study, load_plan(plan, study.instruments.values()))
    return as_json(results), scored


def results_of(folder: Path, plan: str | Path) -> dict[str, Any]:
    return analysed(folder, plan)[0]


@pytest.fixture(scope="module")
def groups_of_three(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return designs.between_groups(tmp_path_factory.mktemp("groups") / "study", people=6)


BETWEEN = '[[contrasts]]\na = "vignette"\nb = "none"\nbetween = "group"\n'


def test_groups_are_compared_on_the_scores_of_their_people(tmp_path: Path) -> None:
    folder = designs.between_groups(tmp_path / "study")
    results, scored = analysed(folder, 'outcomes = ["T"]\n' + BETWEEN)
    (row,) = results["comparisons"]
    table = scored.table
    a, b = (table.loc[table["group"] == each, "T"].to_numpy() for each in designs.GROUPS)
    test = mann_whitney(a, b, scored.units["T"])
    assert (row["test"], row["n_a"], row["n_b"], row["value"]) == ("mann_whitney", 8, 8, test.u)
    assert row["p"] == pytest.approx(test.p, rel=1e-10)
    assert row["difference"]["low"] == pytest.approx(test.shift.low)
    assert results["tests"] == []
    assert len(results["participants"]["analysed"]) == 16


@pytest.mark.parametrize(("name", "variances"), [("welch_t", "welch"), ("student_t", "pooled")])
def test_a_test_of_means_is_named_by_the_contrast(
    tmp_path: Path, name: str, variances: str
) -> None:
    folder = designs.between_groups(tmp_path / "study")
    results, scored = analysed(folder, f'outcomes = ["T"]\n{BETWEEN}test = "{name}"')
    table = scored.table
    a, b = (table.loc[table["group"] == each, "T"].to_numpy() for each in designs.GROUPS)
    expected = two_sample_t(a, b, scored.units["T"], variances=variances)
    (row,) = results["comparisons"]
    assert (row["value"], row["df"]) == pytest.approx((expected.t, expected.df))
    assert row["effect"]["estimate"] == pytest.approx(expected.hedges_g.estimate)


def test_conditions_that_different_people_met_are_groups(tmp_path: Path) -> None:
    rows = [
        {"participant": f"P{i:02d}", "condition": "sharp" if i % 2 else "blur", "hits": i % 5}
        for i in range(10)
    ]
    write_csv(tmp_path / "study" / "tasks.csv", ("participant", "condition", "hits"), rows)
    contrast = '[[contrasts]]\na = "sharp"\nb = "blur"\nbetween = "condition"'
    results = results_of(tmp_path / "study", f'outcomes = ["tasks.hits"]\n{contrast}')
    assert (results["comparisons"][0]["n_a"], results["comparisons"][0]["n_b"]) == (5, 5)


def test_the_same_people_are_no_two_groups(tmp_path: Path) -> None:
    folder = designs.tasks_only(tmp_path / "study")
    contrast = '[[contrasts]]\na = "sharp"\nb = "blur"\nbetween = "condition"'
    results = results_of(folder, f'outcomes = ["tasks.errors"]\n{contrast}')
    assert "leave `between` away" in results["comparisons"][0]["not_tested"]
    assert "not_tested" in {each["kind"] for each in results["deviations"]}


def test_groups_and_pairs_are_adjusted_in_one_family(tmp_path: Path) -> None:
    folder = designs.between_groups(tmp_path / "study")
    family = '[[families]]\nname = "all"\noutcomes = ["N", "O"]\n'
    results = results_of(folder, f'outcomes = ["N", "O"]\n{family}{BETWEEN}')
    first, second = results["comparisons"]
    low, high = sorted((first, second), key=lambda row: row["p"])
    assert low["p_holm"] == pytest.approx(min(1, 2 * low["p"]))
    assert high["p_holm"] == pytest.approx(max(2 * low["p"], high["p"]))


def test_two_tests_of_the_same_pairs_stand_side_by_side(tmp_path: Path) -> None:
    folder = designs.before_and_after(tmp_path / "study")
    results, scored = analysed(folder, PLANS / "before_and_after.toml")
    t, sign = results["comparisons"]
    assert (results["tests"][0]["n"], t["n_a"], sign["n_a"]) == (12, 12, 12)
    moments = scored.moments.pivot_table(index="participant", columns="timepoint", values="T")
    differences = (moments["post"] - moments["baseline"]) * scored.units["T"]
    assert t["difference"]["estimate"] == pytest.approx(differences.mean())
    assert sign["value"] == (differences > 0).sum()


def test_equivalence_needs_the_difference_within_the_bounds(tmp_path: Path) -> None:
    folder = designs.between_groups(tmp_path / "study")
    text = (
        'outcomes = ["participants.age"]\nequivalence = [\n'
        '{ outcome = "participants.age", a = "vignette", b = "none", between = "group", '
        "low = -10, high = 10 },\n"
        '{ outcome = "participants.age", a = "vignette", b = "none", between = "group", '
        "low = -5, high = 5 },\n]\n"
    )
    wide, narrow = results_of(folder, text)["equivalence"]
    assert (wide["equivalent"], narrow["equivalent"]) == (True, False)
    assert wide["p"] < 0.05 < narrow["p"]
    assert wide["confidence"] == pytest.approx(0.9)


def test_correlations_are_of_people_or_within_them(tmp_path: Path) -> None:
    folder = designs.tasks_only(tmp_path / "study")
    methods = ("spearman", "pearson", "kendall", "repeated_measures")
    text = 'outcomes = ["tasks.search_s", "tasks.errors"]\n' + "".join(
        f'[[correlations]]\nx = "tasks.search_s"\ny = "tasks.errors"\nmethod = "{name}"\n'
        for name in methods
    )
    rows = results_of(folder, text)["correlations"]
    assert [(row["method"], row["n"]) for row in rows] == [
        ("spearman", 12), ("pearson", 12), ("kendall", 12), ("repeated_measures", 72),
    ]  # fmt: skip
    assert rows[1]["estimate"] == pytest.approx(np.corrcoef(*rows[1]["values"])[0, 1])
    assert rows[3]["df"] == 72 - 12 - 1


def test_preferences_are_counted_with_those_who_had_none(tmp_path: Path) -> None:
    folder = designs.preferences_only(tmp_path / "study")
    (row,) = results_of(folder, PLANS / "preferences_only.toml")["preferences"]
    assert (row["a"], row["b"], row["none"], row["n"], row["missing"]) == (12, 4, 3, 19, 1)
    assert row["p"] == pytest.approx(0.0768127441)


def test_agreement_aligned_ranks_and_marginal_means_stand_beside_the_tests(tmp_path: Path) -> None:
    folder = designs.tasks_only(tmp_path / "study")
    results = results_of(folder, PLANS / "tasks_only.toml")
    (row,) = results["agreement"]
    assert (row["n"], row["occasions"], len(row["forms"])) == (12, 3, 6)
    effects = [[each["effect"] for each in found["aligned_ranks"]] for found in results["anova"]]
    assert effects == [["condition"], ["condition"]]
    means = results["mixed_models"][0]["means"]["condition"]
    (difference,) = results["mixed_models"][0]["pairwise"]["condition"].values()
    blur, sharp = (means[name]["estimate"] for name in ("blur", "sharp"))
    assert abs(difference["estimate"]) == pytest.approx(abs(blur - sharp))
    assert difference["p_adjusted"] == difference["p"]  # one pair


def test_three_groups_have_a_kruskal_wallis_test(tmp_path: Path) -> None:
    people = [{"participant": f"P{i:02d}", "status": "", "group": "abc"[i % 3]} for i in range(12)]
    tasks = [{"participant": f"P{i:02d}", "condition": "x", "hits": i % 3 + i} for i in range(12)]
    write_csv(tmp_path / "study" / "participants.csv", ("participant", "status", "group"), people)
    write_csv(tmp_path / "study" / "tasks.csv", ("participant", "condition", "hits"), tasks)
    text = 'outcomes = ["tasks.hits"]\n[[anova]]\nname = "group"\ncolumn = "group"'
    (row,) = results_of(tmp_path / "study", text)["kruskal_wallis"]
    assert (row["levels"], row["sizes"], row["df"]) == (["a", "b", "c"], [4, 4, 4], 2)
    assert row["method"] == "exact"
    (row,) = results_of(tmp_path / "study", 'p_value = "asymptotic"\n' + text)["kruskal_wallis"]
    assert row["method"] == "asymptotic"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (BETWEEN.replace("group", "grup"), "did you mean `group`?"),
        (BETWEEN.replace("none", "no"), "`group` is never `no`; the data have none, vignette"),
        (BETWEEN + 'test = "paired_t"', "needs pairs; between groups there are mann_whitney"),
        (BETWEEN + 'a_timepoint = "post"', "leave the timepoints away"),
        ('[[contrasts]]\na_timepoint = "post"\nb_timepoint = "baseline"\ntest = "welch_t"',
         "needs groups; give `between`"),
        ('[[correlations]]\nx = "T"\ny = "age"', "`age` is not among the outcomes"),
        ('[[correlations]]\nx = "T"\ny = "T"', "correlated with itself"),
        ('[[equivalence]]\noutcome = "T"\na = "x"\nb = "y"\nlow = 1\nhigh = -1', "is not below"),
        ('[[preferences]]\nname = "p"\ncolumn = "likd"\na = "x"\nb = "y"', "is not a column"),
        ('[[preferences]]\nname = "p"\ncolumn = "group"\na = "x"\nb = "y"', "is neither"),
    ],
)  # fmt: skip
def test_what_a_plan_cannot_mean_is_told_with_its_place(
    groups_of_three: Path, text: str, said: str
) -> None:
    with pytest.raises(InputError, match=said) as error:
        results_of(groups_of_three, f'outcomes = ["T"]\n{text}')
    assert error.value.line is not None


@pytest.mark.parametrize("people", [3, 4])
def test_few_people_get_no_test_or_one_without_an_interval(tmp_path: Path, people: int) -> None:
    folder = designs.between_groups(tmp_path / "study", people=people)
    (row,) = results_of(folder, 'outcomes = ["T"]\n' + BETWEEN)["comparisons"]
    if people < 4:
        assert row["not_tested"].endswith("too few for a test")
    else:
        assert (row["p"], row["difference"]["low"]) == (pytest.approx(1 / 3), None)


def test_a_study_without_questionnaires_needs_a_plan(tmp_path: Path) -> None:
    folder = designs.tasks_only(tmp_path / "study")
    with pytest.raises(InputError, match="give a plan that names them"):
        build_report(folder, out=tmp_path / "out")


@pytest.mark.slow
@pytest.mark.parametrize("name", STUDIES)
def test_each_design_becomes_a_page(tmp_path: Path, name: str) -> None:
    folder = getattr(designs, name)(tmp_path / "study")
    built = build_report(folder, plan=PLANS / f"{name}.toml", out=tmp_path / "out",
                         forms=("svg",))  # fmt: skip
    page, results = built.index.read_text(), json.loads(built.results.read_text())
    assert built.headlines
    for headline in built.headlines[:1]:
        assert headline.split(";")[0].split("(")[0] in page
    for key in ("comparisons", "correlations", "equivalence", "preferences", "agreement"):
        table = tmp_path / "out" / "tables" / f"{key}.csv"
        assert table.exists() == bool(results[key])
    figures = {file.name for file in built.figures}
    made = [i for i, row in enumerate(results["comparisons"]) if not row["not_tested"]]
    assert {f"comparison_{place}.svg" for place in made} <= figures
