"""The R script beside a report finds the report's numbers in R; skipped where there is no R."""

import random
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import pytest

from tests.support import designs
from tests.support.places import ROOT
from tests.support.report import build_report, carnegie_like, foreign, planned_report
from tests.support.waiting import SESSION_S

RSCRIPT = shutil.which("Rscript")


def run(folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the script from another folder, as a reviewer may."""
    assert RSCRIPT is not None
    script = folder / "reproduce.R"
    return subprocess.run(
        [RSCRIPT, "--vanilla", script],
        capture_output=True,
        text=True,
        check=False,
        timeout=SESSION_S,
    )


def random_study(folder: Path, seed: int, names: Sequence[str] = "abc", person: str = "P") -> Path:
    chance = random.Random(seed)  # noqa: S311 - no secret
    scores = {
        f"{person}{i}": {c: chance.choice((0, 0, 2, 5, 9)) + 2 * k for k, c in enumerate(names)}
        for i in range(14)
    }
    del scores[f"{person}3"][names[2]]
    return foreign(folder / "questionnaires.csv", scores)


needs_r = pytest.mark.skipif(RSCRIPT is None, reason="there is no Rscript here")


PLANS = [
    pytest.param("", marks=pytest.mark.smoke),
    *(
        pytest.param(plan, marks=pytest.mark.slow)
        for plan in (
            'alternative = "greater"\n',
            'zeros = "wilcox"\nalternative = "less"\n',
            'shift_interval = "order_statistics"\np_value = "asymptotic"\n',
            'withdrawals = "available_pairs"\n',
        )
    ),
]


@needs_r
@pytest.mark.parametrize("plan", PLANS)
def test_r_finds_the_same_numbers(tmp_path, plan):
    file = tmp_path / "plan.toml"
    file.write_text(f'name = "p"\ntitle = "P"\n{plan}', "utf-8")
    study = random_study(tmp_path, 5, ("=a", "+b", "@c"), "=P")
    build_report(study, plan=file, out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    assert "0 differ by more than" in found.stdout


NAMES = (
    "=1+1",
    "+a",
    "@b",
    "-c",
    "'=1+1",
    "'d",
    "e, f",
    'g "h"',
    "i × j",
    "k − l",
    "m&n",
    "NA",
    "T",
)
"""What a condition, a person or a factor may be called: beginning as formulas do, with signs that
lists, quotations and effects are made of, or like values of R."""


@pytest.mark.slow
@needs_r
def test_r_reads_names_as_they_are(tmp_path):
    """A study in which everything has such a name; the plan asks for every kind of analysis."""
    study = random_study(tmp_path, 3, NAMES, "=P, ")
    people = [f'"=P, {i}",{"=+@"[i % 3]}g,{20 + i * i % 17}' for i in range(14)]
    table = "\n".join(["participant,=of,+age", *people, ""])
    (tmp_path / "participants.csv").write_text(table, "utf-8")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'name = "p"\ntitle = "P"\noutcomes = ["T", "N"]\nmixed_model = ["condition", "=of"]\n'
        'covariates = ["+age"]\n'
        '[[contrasts]]\na = "=1+1"\nb = "\'=1+1"\n[[contrasts]]\na = "+a"\nb = "@b"\n'
        '[[contrasts]]\na = "=g"\nb = "+g"\nbetween = "=of"\n'
        '[[contrasts]]\na = "i × j"\nb = "m&n"\ntest = "paired_t"\n'
        '[[equivalence]]\noutcome = "T"\na = "e, f"\nb = "NA"\nlow = -20\nhigh = 20\n'
        '[[correlations]]\nx = "T"\ny = "N"\nmethod = "pearson"\n'
        '[[anova]]\nname = "=con × dition"\ncolumn = "condition"\n'
        '[[anova]]\nname = "@group"\ncolumn = "=of"\n',
        "utf-8",
    )
    build_report(study.parent, plan=plan, out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    for said in ("=1+1 minus '=1+1", "pearson", "Kruskal-Wallis, @group", "equivalence of e, f"):
        assert said in found.stdout
    assert ("ANOVA, @group" in found.stdout) == has_package("car")
    assert ("mixed model, condition: " in found.stdout) == has_package("lmerTest")


@pytest.mark.slow
@needs_r
def test_r_adds_several_exposures_of_a_condition_and_adjusts_by_family(tmp_path):
    carnegie_like(tmp_path / "s")
    build_report(tmp_path / "s", out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    assert "p, Holm" in found.stdout
    assert "interval, low" in found.stdout


FAMILY = """
name = "p"
title = "P"
outcomes = ["T", "N", "O"]
scores = "raw"
mixed_model = []
anova = ANOVA
[[contrasts]]
a = "a"
b = "b"
[[contrasts]]
a = "a"
b = "b"
test = "paired_t"
[[contrasts]]
a = "b"
b = "c"
test = "sign"
[[families]]
name = "scores"
outcomes = ["T", "N"]
analyses = ANALYSES
"""


def of_a_family(folder: Path, *analyses: str, anova: str = "[]") -> Path:
    """Report tests, t tests and sign tests of one family; return the folder of the report."""
    study = random_study(folder, 11)
    plan, out = folder / "plan.toml", folder / "o"
    text = FAMILY.replace("ANALYSES", str([*analyses]).replace("'", '"'))
    plan.write_text(text.replace("ANOVA", anova), "utf-8")
    build_report(study, plan=plan, out=out)
    return out


@pytest.fixture(scope="module")
def family_of_tests(tmp_path_factory) -> Path:
    return of_a_family(tmp_path_factory.mktemp("family"), "tests")


@needs_r
def test_r_adjusts_tests_and_comparisons_of_a_family_together(family_of_tests):
    found = run(family_of_tests)
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout.count("p, Holm") == 6  # two outcomes, each by three tests
    assert "the adjusted p values" not in found.stdout


@needs_r
def test_r_does_not_adjust_a_family_of_which_it_lacks_a_p(tmp_path, family_of_tests):
    out = shutil.copytree(family_of_tests, tmp_path / "o")
    tests = out / "tables" / "tests.csv"
    header, *lines = tests.read_text("utf-8").splitlines()
    place = header.split(",").index("ranked_worst")
    cells = lines[0].split(",")
    assert cells[place] == "0"
    cells[place] = "1"  # its assumed ranks are not among the scores
    tests.write_text("\n".join([header, ",".join(cells), *lines[1:], ""]), "utf-8")
    found = run(out)
    assert found.returncode == 0, found.stdout + found.stderr
    assert "Not made here: the adjusted p values of scores" in found.stdout
    assert "p, Holm" not in found.stdout


@needs_r
def test_effects_of_an_anova_are_adjusted_with_the_tests_of_their_family(tmp_path):
    factors = '[{name = "condition", column = "condition"}]'
    found = run(of_a_family(tmp_path, "tests", "anova", anova=factors))
    assert found.returncode == 0, found.stdout + found.stderr
    assert found.stdout.count("p, Holm") == (8 if has_package("car") else 0)
    assert ("the adjusted p values of scores" in found.stdout) != has_package("car")


@cache
def has_package(name: str) -> bool:
    asks = f'quit(status = !requireNamespace("{name}", quietly = TRUE))'
    return RSCRIPT is not None and not subprocess.run([RSCRIPT, "-e", asks], check=False).returncode


@needs_r
@pytest.mark.slow
def test_r_finds_the_models_of_a_crossover(tmp_path):
    carnegie_like(tmp_path / "s")
    build_report(tmp_path / "s", out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    assert "crossover, condition" in found.stdout
    assert ("ANOVA, depth of field" in found.stdout) == has_package("car")
    assert ("mixed model, condition" in found.stdout) == has_package("lmerTest")


@needs_r
@pytest.mark.slow
@pytest.mark.parametrize("squares", ["II", "III"])
def test_r_finds_models_of_groups_of_unequal_size_and_of_a_covariate(tmp_path, squares):
    study = random_study(tmp_path, 8)
    people = [f"P{i},{'xyx'[i % 3]},{20 + i * i % 17}" for i in range(14)]
    table = "\n".join(["participant,group,age", *people])
    (tmp_path / "participants.csv").write_text(table + "\n", "utf-8")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        f'name = "p"\ntitle = "P"\nsums_of_squares = "{squares}"\n'
        'mixed_model = ["condition", "group"]\ncovariates = ["age"]\n'
        '[[anova]]\nname = "condition"\ncolumn = "condition"\n'
        '[[anova]]\nname = "group"\ncolumn = "group"\nlevels = { x = "first", y = "other" }\n',
        "utf-8",
    )
    build_report(study.parent, plan=plan, out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    if has_package("car"):
        assert (
            "ANOVA, condition × group" in found.stdout or "ANOVA, group × condition" in found.stdout
        )
        assert "epsilon, GG" in found.stdout
    assert ("mixed model, age" in found.stdout) == has_package("lmerTest")


@pytest.mark.slow
@needs_r
def test_what_the_table_of_scores_does_not_have_is_named_and_left_out(tmp_path):
    carnegie_like(tmp_path / "s")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'name = "p"\ntitle = "P"\noutcomes = ["T"]\ncontrasts = [{ a = "dof_off", b = "dof_on" },\n'
        '{ a_timepoint = "post", b_timepoint = "baseline" }]\n'
    )
    build_report(tmp_path / "s", plan=plan, out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    assert "Not made here: T post minus baseline" in found.stdout
    assert "of 1 tests" in found.stdout


@pytest.mark.slow
@needs_r
def test_a_number_that_r_does_not_find_is_told(tmp_path):
    build_report(random_study(tmp_path, 6), out=tmp_path / "o")
    table = tmp_path / "o" / "tables" / "tests.csv"
    header, first, *rest = table.read_text("utf-8").splitlines()
    cells = first.split(",")
    place = header.split(",").index("p")
    cells[place] = str(float(cells[place]) * 1.01)
    table.write_text("\n".join([header, ",".join(cells), *rest]) + "\n", "utf-8")
    found = run(tmp_path / "o")
    assert found.returncode == 1
    assert "differ by more than" in found.stdout


def test_the_script_stands_beside_every_report(tmp_path):
    planned_report(random_study(tmp_path, 7), out=tmp_path / "o")
    text = (tmp_path / "o" / "reproduce.R").read_text("utf-8")
    assert text.startswith("# Makes the primary tests of this report again")
    assert text.isascii()


PLANS_OF_DESIGNS = ROOT / "docs" / "plans"


@needs_r
@pytest.mark.slow
@pytest.mark.parametrize(
    ("design", "numbers"),
    [
        ("between_groups", ("U", "p, exact", "shift", "Hedges' g", "t, low", "spearman")),
        ("tasks_only", ("interval, high", "ICC(2,1)", "ICC(3,1)", "repeated_measures")),
    ],
)
def test_r_finds_other_tests_and_correlations(tmp_path, design, numbers):
    folder = getattr(designs, design)(tmp_path / "study")
    build_report(folder, plan=PLANS_OF_DESIGNS / f"{design}.toml", out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    assert all(f" {number} " in found.stdout for number in numbers)


@needs_r
@pytest.mark.slow
def test_r_finds_sign_tests_and_three_groups(tmp_path):
    study = random_study(tmp_path, 9)
    people = "\n".join(["participant,group", *(f"P{i},{'xyz'[i % 3]}" for i in range(14))])
    (tmp_path / "participants.csv").write_text(people + "\n", "utf-8")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'name = "p"\ntitle = "P"\nmixed_model = []\n'
        '[[contrasts]]\na = "a"\nb = "b"\ntest = "sign"\nalternative = "less"\n'
        '[[contrasts]]\na = "x"\nb = "y"\nbetween = "group"\ntest = "student_t"\n'
        '[[correlations]]\nx = "T"\ny = "N"\nmethod = "pearson"\n'
        '[[anova]]\nname = "group"\ncolumn = "group"\n',
        "utf-8",
    )
    build_report(study.parent, plan=plan, out=tmp_path / "o")
    found = run(tmp_path / "o")
    assert found.returncode == 0, found.stdout + found.stderr
    for said in ("share above", "Hedges' g", "pearson", "Kruskal-Wallis, group"):
        assert said in found.stdout
