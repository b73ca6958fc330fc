"""A plan that names another lab's files and their mapping is reported without a study."""

import json
import shutil

import pytest

from tests.support.places import ROOT
from vrcomfort.importing.suggest import suggest_mapping

RAW = ROOT / "tests" / "data" / "import" / "two_displays.csv"
BRIEF = ("--quiet", "--figures", "none")


@pytest.fixture(scope="module")
def mapping():
    return suggest_mapping([RAW]).text.replace('answer = ""', 'answer = "yes"')


@pytest.fixture
def plan(tmp_path, mapping):
    """A plan, its mapping, and the files in a folder beside them."""
    (tmp_path / "raw").mkdir()
    shutil.copy(RAW, tmp_path / "raw" / RAW.name)
    (tmp_path / "map.toml").write_text(mapping, "utf-8")
    file = tmp_path / "plan.toml"
    head = 'name = "p"\ntitle = "P"\noutcomes = ["T"]\n'
    file.write_text(f'{head}[data]\nfiles = ["raw/*.csv"]\nmapping = "map.toml"\n', "utf-8")
    return file


def test_the_files_of_a_plan_are_reported_as_an_import_of_them_is(run, plan, tmp_path):
    code, _, err = run("report", "--plan", plan, "--out", tmp_path / "by_plan", *BRIEF)
    assert code == 0, err
    files = ("--mapping", tmp_path / "map.toml", "--out", tmp_path / "study", "--quiet")
    assert run("import", RAW, *files)[0] == 0
    given = ("--plan", plan, "--out", tmp_path / "by_study", *BRIEF)
    assert run("report", tmp_path / "study", *given)[0] == 0
    one, other = (
        json.loads((tmp_path / name / "results.json").read_text("utf-8"))
        for name in ("by_plan", "by_study")
    )
    assert one["tests"]
    assert one["tests"] == other["tests"]
    kept = tmp_path / "by_plan" / "imported"
    assert json.loads((kept / "import.json").read_text("utf-8"))["sources"][0]["file"] == RAW.name


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("raw/*.csv", "row/*.csv", "line 5, column 10: there is no file `row/*.csv`"),
        ("map.toml", "mop.toml", "line 6, column 1: there is no file `mop.toml`"),
        ("files =", "file =", "did you mean `files`?"),
    ],
)
def test_what_is_not_there_is_told_with_its_place(run, plan, tmp_path, old, new, said):
    plan.write_text(plan.read_text("utf-8").replace(old, new), "utf-8")
    code, _, err = run("report", "--plan", plan, "--out", tmp_path / "r", "--quiet")
    assert code != 0
    assert said in " ".join(err.split())


@pytest.mark.parametrize("given", [(), ("--plan", "carnegie_2015")])
def test_without_a_study_a_plan_must_name_files(run, tmp_path, given):
    code, _, err = run("report", *given, "--out", tmp_path / "r")
    assert code != 0
    assert "[data]" in err
