"""The analyses of a report: one module and one line for each.

To add an analysis:

1. Write a module here with one `Analysis` (see `contract`): the key in the plan with the pydantic
   model of its entries, the analysis set, the computation (which calls `vrcomfort.stats`), the
   frozen dataclass of its rows, and its renderings: tables (page and CSV), sentences, the methods
   paragraph with references, a figure, the lines of ``reproduce.R``. What it does not render it
   leaves away.
2. Name it in `ANALYSES`, in the order that results.json is to have.

Plans then accept its key, and the page, results.json, the terminal, the CSV tables, the methods
section and ``reproduce.R`` have it: all of them go through this list.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from vrcomfort.report.analyses.agreement import AGREEMENT
from vrcomfort.report.analyses.anova import ANOVA
from vrcomfort.report.analyses.comparisons import COMPARISONS
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisFigure,
    MethodsParagraph,
    PageTable,
    Section,
    Sentence,
)
from vrcomfort.report.analyses.correlation import CORRELATIONS
from vrcomfort.report.analyses.crossover import CROSSOVER
from vrcomfort.report.analyses.equivalence import EQUIVALENCE
from vrcomfort.report.analyses.friedman import FRIEDMAN
from vrcomfort.report.analyses.kruskal_wallis import KRUSKAL_WALLIS
from vrcomfort.report.analyses.mixed import MIXED_MODELS
from vrcomfort.report.analyses.ordinal import ORDINAL
from vrcomfort.report.analyses.preference import PREFERENCES
from vrcomfort.report.analyses.signed_rank import TESTS
from vrcomfort.report.analyses.z_scores import Z_SCORES

if TYPE_CHECKING:
    from vrcomfort.report.canvas import Drawing
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary

__all__ = [
    "ANALYSES",
    "AnalysisData",
    "MethodsParagraph",
    "Sentence",
    "analysed_people",
    "analysis_figures",
    "csv_tables",
    "methods_paragraphs",
    "outcome_sentences",
    "page_analyses",
    "r_sections",
    "references",
    "run_analyses",
    "sentences",
]

ANALYSES: tuple[Analysis[Any], ...] = (
    TESTS,
    COMPARISONS,
    CORRELATIONS,
    EQUIVALENCE,
    PREFERENCES,
    AGREEMENT,
    KRUSKAL_WALLIS,
    ORDINAL,
    Z_SCORES,
    ANOVA,
    FRIEDMAN,
    CROSSOVER,
    MIXED_MODELS,
)
"""All of them, in the order of results.json."""
SECTIONS: tuple[Section, ...] = ("tests", "models", "order")
Rows = Mapping[str, Sequence[Any]]
"""An analysis' key → its rows."""


def on_page(*sections: Section) -> list[Analysis[Any]]:
    """Return the analyses in the order of the page, which sentences and methods have as well."""
    found = (each for each in ANALYSES if each.section in sections)
    return sorted(found, key=lambda each: each.place)


def run_analyses(data: AnalysisData) -> dict[str, Sequence[Any]]:
    """Make the analyses of a plan, each of its own analysis set."""
    return {
        each.key: each.compute(
            replace(data, complete=each.people.needs_every_score(data.plan)),
            data.plan.entries(each.key),
        )
        for each in ANALYSES
    }


def analysed_people(rows: Rows) -> list[Sequence[str]]:
    """Return the participants of each test; without any, of the rows that answer by themselves."""
    of_outcomes, others = (
        [
            each.analysed(row)
            for each in ANALYSES
            if each.analysed and each.by_outcome == by_outcome
            for row in rows[each.key]
        ]
        for by_outcome in (True, False)
    )
    return of_outcomes or others


def sentences(rows: Rows, words: Vocabulary) -> list[Sentence]:
    """Return the answers of all rows."""
    return [
        sentence
        for each in on_page(*SECTIONS)
        if not each.by_outcome
        for row in rows[each.key]
        for sentence in each.sentences(row, words)
    ]


def outcome_sentences(rows: Rows, words: Vocabulary) -> list[tuple[str, Sentence]]:
    """Return outcome and answer of the tests and comparisons, in the order of rows."""
    return [
        (row.outcome, sentence)
        for each in on_page(*SECTIONS)
        if each.by_outcome
        for row in rows[each.key]
        for sentence in each.sentences(row, words)
    ]


def methods_paragraphs(rows: Rows, *sections: Section) -> list[MethodsParagraph]:
    """Return the paragraphs on the analyses that this report holds."""
    return [paragraph for each in on_page(*sections) for paragraph in each.methods(rows[each.key])]


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
    """An analysis as the page has it."""

    section: Section
    tables: tuple[PageTable, ...]
    figure: AnalysisFigure[Any] | None


def page_analyses(rows: Rows, words: Vocabulary, confidence: float) -> Iterator[PageAnalysis]:
    """Yield the analyses that have rows, in the order of the page."""
    for each in on_page(*SECTIONS):
        found = rows[each.key]
        if found:
            tables = (t for t in each.tables if t.columns or t.template)
            drawn = tuple(table.on_page(found, words, confidence) for table in tables)
            yield PageAnalysis(each.section, drawn, each.figure)


def analysis_figures(rows: Rows, words: Vocabulary) -> dict[str, Drawing | None]:
    """Return name → drawing of the analyses' figures; None where there is nothing to draw."""
    return {
        each.figure.name: each.figure.draw(rows[each.key], words)
        for each in ANALYSES
        if each.figure
    }


def r_sections() -> Iterable[str]:
    """Return the sections of reproduce.R that make the analyses again."""
    return [each.r_lines for each in ANALYSES if each.r_lines]
