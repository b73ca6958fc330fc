"""Reports written into a folder that holds an earlier one, or somebody's own files."""

import json

import pytest

from tests.support.report import build_report, carnegie_like, contents, foreign
from vrcomfort.errors import InputError
from vrcomfort.report.writing import write_report

SCORES = {f"P{i}": {"x": 3 + i, "y": 2 + i // 2} for i in range(4)}


def results_json(*names: str) -> str:
    return json.dumps({"software": {}, "files": ["results.json", *names]})


@pytest.mark.slow
def test_no_file_of_an_earlier_report_stays(tmp_path):
    carnegie_like(tmp_path / "study")
    other = foreign(tmp_path / "questionnaires.csv", SCORES)
    first = build_report(tmp_path / "study", out=tmp_path / "again")
    again = build_report(other, out=tmp_path / "again")
    build_report(other, out=tmp_path / "alone")
    assert contents(tmp_path / "again") == contents(tmp_path / "alone")
    assert {path.name for path in {*first.tables} - {*again.tables}} >= {"withdrawals.csv"}
    assert sorted(p.name for p in (tmp_path / "again").iterdir()) == [
        "index.html", "paper.txt", "plan.toml", "reproduce.R", "results.json", "tables",
    ]  # fmt: skip


@pytest.mark.slow
def test_ones_own_files_stay(tmp_path):
    carnegie_like(tmp_path / "study")
    out = tmp_path / "out"
    own = {"tables/mine.csv": "1", "figures/mine.svg": "2", "notes.txt": "3", "tables/anova.R": "4"}
    for name, text in own.items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text(text)
    build_report(tmp_path / "study", out=out)
    build_report(foreign(tmp_path / "questionnaires.csv", SCORES), out=out)
    assert own.items() <= {k: v.decode() for k, v in contents(out).items()}.items()


@pytest.mark.parametrize("listed", ["../a.csv", "tables/../../a.csv", "notes.csv", "figures/", 3])
def test_what_no_report_writes_is_not_removed_whatever_results_say(tmp_path, listed):
    out = tmp_path / "out"
    out.mkdir()
    for place in (tmp_path / "a.csv", out / "notes.csv"):
        place.write_text("mine")
    (out / "results.json").write_text(json.dumps({"software": {}, "files": [listed]}))
    write_report(out, {"results.json": results_json()})
    assert (tmp_path / "a.csv").read_text() == (out / "notes.csv").read_text() == "mine"


@pytest.mark.parametrize(
    "text", ["{}", "[]", "no JSON", "[" * 100_000, '{"files": ["tables/anova.csv"]}']
)
def test_results_of_other_programs_remove_nothing(tmp_path, text):
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "anova.csv").write_text("mine")
    (tmp_path / "results.json").write_text(text)
    write_report(tmp_path, {"results.json": results_json()})
    assert (tmp_path / "tables" / "anova.csv").read_text() == "mine"


def test_a_report_that_cannot_be_written_leaves_the_one_before(tmp_path):
    first = {"results.json": results_json("tables/old.csv"), "tables/old.csv": "old"}
    write_report(tmp_path, first)
    before = contents(tmp_path)
    too_long = f"tables/{'x' * 300}.csv"
    with pytest.raises(InputError, match="cannot write the report: File name too long"):
        write_report(tmp_path, {"results.json": results_json(), "index.html": "", too_long: ""})
    assert contents(tmp_path) == before


def test_what_a_killed_report_left_is_removed_by_the_next(tmp_path):
    names = ("index.html", "tables/one.csv", "figures/two.svg")
    (tmp_path / "index.html").mkdir()  # no file can be put here: the report ends half-way
    with pytest.raises(InputError, match="Is a directory"):
        write_report(
            tmp_path,
            {
                **dict.fromkeys(names[1:], "new"),
                "index.html": "",
                "results.json": results_json(*names),
            },
        )
    assert (tmp_path / "tables" / "one.csv").exists()
    (tmp_path / "index.html").rmdir()
    write_report(tmp_path, {"results.json": results_json("index.html"), "index.html": ""})
    assert set(contents(tmp_path)) == {"results.json", "index.html"}


@pytest.mark.slow
def test_conditions_may_be_called_anything(tmp_path):
    scores = {f"P{i}": {"a/../../../x": 3 + i, "50 %": 2 + i // 2} for i in range(4)}
    summary = build_report(
        foreign(tmp_path / "s" / "questionnaires.csv", scores), out=tmp_path / "o", forms=("svg",)
    )
    assert "estimation_T.svg" in {path.name for path in summary.figures}
    assert {path.parent for path in summary.figures} == {tmp_path / "o" / "figures"}
    assert all(path.is_file() for path in summary.figures)
    assert {path.name for path in tmp_path.iterdir()} == {"s", "o"}
