"""The registry of analyses: each is found once, and no part of one gets lost."""

from __future__ import annotations

import re
from pathlib import Path
from typing import get_args

import pytest

import vrcomfort.report.analyses
from tests.support import designs
from tests.support.places import ROOT
from tests.support.report import HEAD, ONE_SCORE, build_report
from vrcomfort.report.analyses import ANALYSES, ReportContext
from vrcomfort.report.analyses.contract import (
    AnalysisTable,
    Section,
    TableColumn,
    by_reason,
    html,
)
from vrcomfort.report.plan import Plan
from vrcomfort.report.references import is_known
from vrcomfort.report.reproduce import r_script
from vrcomfort.report.vocabulary import Vocabulary

PACKAGE = Path(vrcomfort.report.analyses.__file__).parent
TEMPLATES = ROOT / "analysis" / "report"


def test_each_module_declares_one_analysis() -> None:
    modules = {path.stem for path in PACKAGE.glob("[a-z]*.py")} - {"contract"}
    modules |= {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert len(ANALYSES) == len(modules)
    assert len({each.key for each in ANALYSES}) == len(ANALYSES)


def test_no_two_analyses_or_tables_share_a_place() -> None:
    assert len({each.order for each in ANALYSES}) == len(ANALYSES)
    assert len({each.place for each in ANALYSES}) == len(ANALYSES)
    names = [table.name for each in ANALYSES for table in each.tables if table.name]
    assert len(set(names)) == len(names)


def test_every_section_of_the_page_has_the_analyses_that_stand_in_it() -> None:
    sources = "".join(path.read_text("utf-8") for path in TEMPLATES.glob("*.j2"))
    on_page = re.findall(r'set section = "(\w+)" %}\n{% include "report/analyses', sources)
    assert sorted(on_page) == sorted(get_args(Section))


def test_the_script_has_the_lines_of_every_analysis_once() -> None:
    script = r_script()
    for each in ANALYSES:
        for part in (each.r_lines, each.r_functions):
            assert not part or script.count(part.lstrip("\n")) == 1
    assert "# ANALYSES" not in script
    assert "# FUNCTIONS" not in script


def test_literature_that_an_analysis_brings_along_is_known() -> None:
    assert all(is_known(key) for each in ANALYSES for key in each.references)


def test_what_is_inserted_into_html_is_escaped() -> None:
    assert html("<i>{}</i> {}", "<b>&\u202e", html("<u>{}</u>", "x")) == (
        r"<i>&lt;b&gt;&amp;\u202e</i> <u>x</u>"
    )


def test_reasons_are_told_by_alphabet_with_their_rows_in_order() -> None:
    rows = [("x", "none"), ("y", None), ("z", "Few"), ("w", "none")]
    assert by_reason(rows, lambda row: row[1]) == {"Few": [rows[2]], "none": [rows[0], rows[3]]}


def test_a_group_has_one_title_and_a_table_without_lines_is_left_away(
    report: ReportContext,
) -> None:
    table: AnalysisTable[tuple[str, int], tuple[str, int]] = AnalysisTable(
        "t",
        "Numbers",
        (
            TableColumn("name", lambda line, _: line[0]),
            TableColumn("number", lambda line, _: str(line[1])),
        ),
        lines=lambda row: [row] if row[1] else [],
        spanning=lambda line: "a dozen" if line[1] == 12 else None,
        group=lambda row, _rows, _report: f"letter {row[0]}",
        group_key=lambda row: row[0],
    )
    found = table.on_page([("a", 1), ("a", 12), ("b", 3)], report)
    assert found is not None
    texts = [(line.of_group, *(cell.content for cell in line.cells)) for line in found.lines]
    assert texts == [
        (True, "letter a"), (False, "a", "1"), (False, "a", "a dozen"),
        (True, "letter b"), (False, "b", "3"),
    ]  # fmt: skip
    assert [cell.columns for cell in found.lines[0].cells] == [2]
    ungrouped = AnalysisTable("t", "", table.columns, lines=table.lines)
    assert ungrouped.on_page([("a", 0)], report) is None


def test_comparisons_have_a_figure_each_where_the_plan_wants_pairs(tmp_path: Path) -> None:
    study = designs.between_groups(tmp_path / "study")
    text = HEAD + ONE_SCORE + '{}[[contrasts]]\na = "vignette"\nb = "none"\nbetween = "group"\n'
    for kinds, expected in (("", 1), ('figures = ["paired"]\n', 1), ('figures = ["flow"]\n', 0)):
        plan = tmp_path / "plan.toml"
        plan.write_text(text.format(kinds))
        found = build_report(study, plan=plan, out=tmp_path / "o", forms=("svg",))
        drawn = [path for path in found.figures if path.name.startswith("comparison_")]
        assert len(drawn) == expected
        page = found.index.read_text("utf-8")
        assert page.count("Right: the difference that was tested") == expected


@pytest.fixture
def words() -> Vocabulary:
    return Vocabulary.of((), labels={}, outcomes=(), instruments=(), protocol=None)


@pytest.fixture
def report(words: Vocabulary) -> ReportContext:
    return ReportContext(words, Plan(name="p", title="P"), several=False, drawn=False)
