"""What the page of a report says, and that it is what its captions and the tables say."""

import csv
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.support.report import (
    ONE_SCORE,
    WITHOUT_MODELS,
    Study,
    build_report,
    carnegie_like,
    foreign,
    planned_report,
    results_of,
)
from vrcomfort.report.descriptives import DescriptionWithInterval
from vrcomfort.report.words import interval

UNEQUAL = {
    "P1": {"a": 3, "b": 2, "c": 1},
    "P2": {"a": 6, "b": 1, "c": 8},
    "P3": {"b": 9, "c": 5},
    "P4": {"c": 7},
}
"""P3 is only in the test of b and c, P4 in none."""


def rows_of(page: str, caption: str) -> list[list[str]]:
    """Return the cells of the table whose caption begins with these words."""
    found = [t for t in re.findall(r"<table>.*?</table>", page, re.DOTALL) if f"</b>{caption}" in t]
    (table,) = found
    body = table[table.index("<tbody>") :]
    lines = re.findall(r"<tr.*?>(.*?)</tr>", body, re.DOTALL)
    cells = [re.findall(r"<td.*?>(.*?)</td>", line) for line in lines]
    return [[re.sub("<[^>]*>", "", cell) for cell in line] for line in cells]


def described(folder: Path, **chosen: str) -> list[dict[str, str]]:
    with (folder / "tables" / "descriptives.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    return [row for row in rows if all(row[key] == value for key, value in chosen.items())]


@pytest.fixture(scope="module")
def unequal(tmp_path_factory) -> tuple[dict, str, Path]:
    """A report in which every pair of conditions has its own participants."""
    folder = tmp_path_factory.mktemp("unequal")
    source = foreign(folder / "questionnaires.csv", UNEQUAL)
    summary = planned_report(source, out=folder / "o")
    return results_of(summary), summary.index.read_text("utf-8"), folder / "o"


def test_scores_are_of_everybody_in_a_test_of_the_condition(unequal):
    _, page, out = unequal
    rows = rows_of(page, "SSQ scores of the analysed participants: under each")
    assert [(row[1], row[2]) for row in rows[:3]] == [("a", "2"), ("b", "3"), ("c", "3")]
    expected = described(out, by="primary", outcome="T")
    for row, line in zip(rows[:3], expected, strict=True):
        assert [row[1], row[2]] == [line["condition"], line["n"]]
        assert [float(row[3]), float(row[5])] == pytest.approx(
            [float(line["mean"]), float(line["sd"])], abs=0.005
        )
    assert [line["n"] for line in described(out, by="all", outcome="T")] == ["2", "3", "4"]


def test_who_is_in_some_tests_only_is_told(unequal):
    results, page, _ = unequal
    assert results["participants"]["analysed"] == ["P1", "P2", "P3"]
    assert [row[0] for row in rows_of(page, "Not analysed")] == ["P4"]
    some = rows_of(page, "Analysed in some tests")
    assert some == [["P3", "not every exposure has a questionnaire"]]


def test_mean_answers_are_of_everybody_in_a_test_of_the_condition(unequal):
    results, _, _ = unequal
    first = results["symptoms"][0]["item"]  # 3 points of every total that has them are in it
    means = {r["condition"]: r["mean"] for r in results["symptoms"] if r["item"] == first}
    assert means == pytest.approx({"a": 3.0, "b": 2.0, "c": 7 / 3})


def test_of_one_pair_the_scores_are_those_of_its_test(tmp_path):
    study = carnegie_like(tmp_path / "study")
    lines = f'outcomes = ["T", "N"]\n{WITHOUT_MODELS}'
    summary = planned_report(study.folder, out=tmp_path / "o", lines=lines)
    results = results_of(summary)
    for test in results["tests"]:
        for condition in ("dof_off", "dof_on"):
            (row,) = (
                row for row in results["descriptives"]
                if (row["by"], row["condition"], row["outcome"])
                == ("primary", condition, test["outcome"])
            )  # fmt: skip
            expected = test["descriptives"][condition]
            assert {name: row[name] for name in expected} == pytest.approx(expected)
    page = summary.index.read_text("utf-8")
    assert "Possible scores, without subtracting the baseline: " in page
    rows = rows_of(page, "SSQ scores of the analysed participants, mean per")
    assert [(row[1], row[2]) for row in rows[:3]] == [
        ("No blur", "6"), ("Blur", "6"), ("difference", "6"),
    ]  # fmt: skip
    assert "not in every test" not in page


def test_one_score_has_no_standard_deviation(tmp_path):
    study = Study(tmp_path / "s")
    study.session("P1", 1, 0, [("a", "x", 4), ("b", "x", 2)])
    study.session("P2", 1, 0, [("b", "x", 5), ("a", "x", 3)])
    page = planned_report(study.folder, out=tmp_path / "o").index.read_text("utf-8")
    first = described(tmp_path / "o", by="position", level="1", condition="a", outcome="T")
    assert [(row["n"], row["sd"]) for row in first] == [("1", "")]
    rows = rows_of(page, "Total severity of all scored exposures")
    assert [(row[2], row[4]) for row in rows] == [("1", "–")] * 4


def test_estimates_without_an_interval_say_why(tmp_path):
    scores = {f"P{i}": {"a": 9 - 2 * i, "b": 2 + 2 * i} for i in range(4)}
    summary = build_report(foreign(tmp_path / "questionnaires.csv", scores), out=tmp_path / "o")
    assert len(summary.headlines) == 4
    for line in summary.headlines[:3]:  # nobody answered what is of D alone
        assert re.search(
            r"points \(no (Holm-adjusted )?95\u00a0% CI: too few differences\), "
            r"(Holm-adjusted )?p\u00a0=\u00a0\S+, n\u00a0=\u00a04\.",
            line,
        )
        assert re.search(r"r\u00a0=\u00a0\S+ \[\S+,\u00a0\S+\]\.", line)
        assert "–" not in line
    page = summary.index.read_text("utf-8")
    assert "An interval of the shift needs 6 differences" in page
    assert "There is none below 6 differences" in page
    (line,) = (row for row in rows_of(page, "Signed-rank tests") if row[0] == "Total severity")
    assert line[10] == "–"
    assert line[12].startswith("[")


def first_headline(folder: Path, scores: dict[str, dict[str, int]]) -> str:
    source = foreign(folder / "questionnaires.csv", scores)
    lines = f'{ONE_SCORE}rank_biserial_interval = "effectsize"\n'
    return planned_report(source, out=folder / "o", lines=lines).headlines[0]


def test_zeros_may_leave_an_interval_to_the_shift_alone(tmp_path):
    scores = {f"P{i}": {"a": 5, "b": 5 - 2 * (i < 3)} for i in range(8)}
    line = first_headline(tmp_path, scores)
    assert re.search(r"points, 95\u00a0% CI \[\S+,\u00a0\S+\], p\u00a0=", line)
    assert "r\u00a0=\u00a01.00 (no 95\u00a0% CI: too few differences other than 0)" in line


def test_scores_of_zero_in_one_condition_are_a_difference(tmp_path):
    scores = {f"P{i}": {"a": 0, "b": 2 + i} for i in range(7)}
    line = first_headline(tmp_path, scores)
    assert "r\u00a0=\u00a0−1.00 (no 95\u00a0% CI: a has no score but 0)" in line


@pytest.mark.parametrize(
    ("found", "written"),
    [
        ({"low": 0.0, "high": 7.48, "low_closed": False}, "(0.00,\u00a07.48]"),
        ({"low": None, "high": 7.48}, "(−∞,\u00a07.48]"),
        ({"low": 1.0, "high": None, "high_closed": False}, "[1.00,\u00a0∞)"),
        ({"low": -1.0, "high": 2.0, "holds_rejected_zero": True}, "[−1.00,\u00a02.00] without 0"),
        ({"low": None, "high": None}, "–"),
    ],
)
def test_ends_that_are_not_in_an_interval_are_written_so(found, written):
    assert interval(SimpleNamespace(**found)) == written


def test_where_r_and_p_disagree_about_zero_is_counted(tmp_path):
    """Pratt's p ranks the zeros, which r does not have."""
    scores = {f"P{i}": {"a": 5, "b": 5 - 2 * (i < 6)} for i in range(8)}
    source = foreign(tmp_path / "questionnaires.csv", scores)
    summary = planned_report(source, out=tmp_path / "o", lines=WITHOUT_MODELS)
    tests = results_of(summary)["tests"]
    effects = [(t["verdict"], (t["simultaneous"] or t)["effect"]) for t in tests if t["effect"]]
    wrong = sum(
        (verdict in {"higher", "lower"}) == (found["low"] <= 0 <= found["high"])
        for verdict, found in effects
    )
    said = f"disagree about 0 in {wrong} of these tests" in summary.index.read_text("utf-8")
    assert said == (wrong > 0)


def test_the_page_of_more_conditions_than_are_compared_in_pairs(tmp_path):
    scores = {f"P{i}": {f"c{k:02d}": (i * k) % 7 for k in range(13)} for i in range(4)}
    lines = (
        'outcomes = ["T"]\nmixed_model = ["condition"]\nanova = []\n'
        'contrasts = [{ a = "c00", b = "c12" }]\n'
    )
    source = foreign(tmp_path / "q.csv", scores)
    summary = planned_report(source, out=tmp_path / "o", lines=lines)
    assert "Pairs are compared of up to 12 conditions." in summary.index.read_text("utf-8")


@pytest.mark.parametrize(
    ("low", "high", "beyond"),
    [(1, 4, False), (-1, 4, True), (1, 9, True), (None, 4, True), (None, 9, True),
     (-1, None, True), (None, None, False)],
)  # fmt: skip
def test_an_interval_beyond_the_scores_is_known_with_one_end_or_none(low, high, beyond):
    found = DescriptionWithInterval(5, 2.0, 1.0, 2.0, 1.0, 3.0, 0.0, 5.0, low, high)
    assert found.is_beyond_scores is beyond


def test_an_interval_of_a_mean_that_is_beyond_the_scores_is_explained(tmp_path):
    scores = {f"P{i}": {"a": 20 * (i == 0) + i % 2, "b": 2} for i in range(6)}
    summary = planned_report(foreign(tmp_path / "q.csv", scores), out=tmp_path / "o")
    assert "few, skewed scores leave the mean uncertain" in summary.index.read_text("utf-8")
