"""The analyses of a report: one module for each, found by itself.

To add an analysis, write a module here that declares one `Analysis` (see `contract`): the key in
the plan with the pydantic model of its entries, the analysis set, the computation (which calls
`vrcomfort.stats`), the frozen dataclass of its rows, and its renderings: tables (page and CSV),
sentences, the methods paragraph with references, figures, the lines of ``reproduce.R``. What it
does not render it leaves away; without `place` and `order` it stands last.

Plans then accept its key, and the page, results.json, the terminal, the CSV tables, the methods
section and ``reproduce.R`` have it: all of them go through `ANALYSES`.
"""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from vrcomfort.declarations import declared_in
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisFigure,
    MethodsParagraph,
    PageTable,
    ReportContext,
    Section,
    Sentence,
)
from vrcomfort.stats.ranks import level_of

if TYPE_CHECKING:
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary

__all__ = [
    "ANALYSES",
    "AnalysisData",
    "MethodsParagraph",
    "ReportContext",
    "Sentence",
    "analysed_people",
    "analysis_figures",
    "csv_tables",
    "methods_paragraphs",
    "outcome_sentences",
    "page_analyses",
    "r_functions",
    "r_sections",
    "references",
    "run_analyses",
    "sentences",
]


ANALYSES: tuple[Analysis[Any], ...] = tuple(
    sorted(declared_in(sys.modules[__name__], Analysis), key=lambda each: (each.order, each.key))
)
"""All of them, in the order of results.json."""
Rows = Mapping[str, Sequence[Any]]
"""An analysis' key → its rows."""


def on_page() -> list[Analysis[Any]]:
    """Return the analyses in the order of a section, which sentences and methods have as well."""
    return sorted(ANALYSES, key=lambda each: each.place)


def run_analyses(data: AnalysisData) -> dict[str, Sequence[Any]]:
    """Make the analyses of a plan, each of its own analysis set."""
    return {
        each.key: each.compute(_data_of(each, data), data.plan.entries(each.key))
        for each in ANALYSES
    }


def _data_of(analysis: Analysis[Any], data: AnalysisData) -> AnalysisData:
    return replace(data, complete=analysis.people.needs_every_score(data.plan))


def with_intervals(data: AnalysisData, analysis: Analysis[Any], row: Any) -> Any:
    """Return a row with the intervals of the level at which it decides, where that is stricter."""
    level = row.decision.level
    if level is None or level >= level_of(data.plan.confidence):
        return row
    found = analysis.intervals(_data_of(analysis, data), row, level)
    return replace(row, decision=replace(row.decision, simultaneous=found)) if found else row


def analysed_people(rows: Rows) -> list[Collection[str]]:
    """Return the participants of each test; without any, of the rows that answer by themselves."""
    of_outcomes, others = (
        [
            people
            for each in ANALYSES
            if each.analysed and each.by_outcome == by_outcome
            for people in each.analysed(rows[each.key])
        ]
        for by_outcome in (True, False)
    )
    return of_outcomes or others


def sentences(rows: Rows, words: Vocabulary) -> list[Sentence]:
    """Return the answers of all rows."""
    return [
        sentence
        for each in on_page()
        if not each.by_outcome
        for row in rows[each.key]
        for sentence in each.sentences(row, words)
    ]


def outcome_sentences(rows: Rows, words: Vocabulary) -> list[tuple[str, Sentence]]:
    """Return outcome and answer of the tests and comparisons, in the order of rows."""
    return [
        (row.outcome, sentence)
        for each in on_page()
        if each.by_outcome
        for row in rows[each.key]
        for sentence in each.sentences(row, words)
    ]


def methods_paragraphs(
    rows: Rows, report: ReportContext, *sections: Section
) -> list[MethodsParagraph]:
    """Return the paragraphs on the analyses that this report holds."""
    return [
        paragraph
        for each in on_page()
        for paragraph in each.methods(rows[each.key], report)
        if (paragraph.section or each.section) in sections
    ]


def references() -> dict[str, str]:
    """Return the literature that analyses bring along: key → entry."""
    return {key: entry for each in ANALYSES for key, entry in each.references.items()}


def csv_tables(rows: Rows) -> dict[str, list[Cells]]:
    """Return the name of each table and its lines."""
    return {
        table.name: [line for row in rows[each.key] for line in table.csv(row)]
        for each in ANALYSES
        for table in each.tables
    }


@dataclass(frozen=True)
class PageAnalysis:
    """The part of an analysis in one section of the page."""

    key: str
    section: Section
    heading: str
    remarks: tuple[str, ...]
    tables: tuple[PageTable, ...]
    figures: tuple[AnalysisFigure, ...]
    side_by_side: bool


def page_analyses(rows: Rows, report: ReportContext) -> Iterator[PageAnalysis]:
    """Yield the analyses that have rows, in the order of the page."""
    for each in on_page():
        if found := rows[each.key]:
            yield from _parts(each, found, report)


def _parts(
    analysis: Analysis[Any], rows: Sequence[Any], report: ReportContext
) -> Iterator[PageAnalysis]:
    """Yield the part in the analysis' section, and those that stand elsewhere."""
    remarks = [(each.section, each.text) for each in analysis.remarks(rows, report)]
    tables = [(each.section, each.on_page(rows, report)) for each in analysis.tables]
    for section in dict.fromkeys([None, *(place for place, _ in (*remarks, *tables))]):
        yield PageAnalysis(
            analysis.key,
            section or analysis.section,
            "" if section else analysis.heading(rows),
            tuple(text for place, text in remarks if place == section),
            tuple(table for place, table in tables if table and place == section),
            () if section else tuple(analysis.figures(rows, report)),
            analysis.side_by_side and not section,
        )


def analysis_figures(rows: Rows, report: ReportContext) -> Iterator[tuple[bool, AnalysisFigure]]:
    """Yield the analyses' figures, and whether each stands with an answer on its outcome."""
    for each in ANALYSES:
        for figure in each.figures(rows[each.key], report):
            yield each.by_outcome, figure


def r_functions() -> Iterable[str]:
    """Return the functions of reproduce.R that analyses bring along."""
    return [each.r_functions for each in ANALYSES if each.r_functions]


def r_sections(*sections: Section) -> Iterable[str]:
    """Return the parts of reproduce.R that make the analyses of some sections again."""
    return [
        each.r_lines
        for section in sections
        for each in ANALYSES
        if each.section == section and each.r_lines
    ]
