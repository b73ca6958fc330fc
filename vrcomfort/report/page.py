"""The report as one self-contained HTML page."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

from markupsafe import Markup

from vrcomfort.report import methods, palette, words
from vrcomfort.report.analyses import Sentence, outcome_sentences, page_analyses, sentences
from vrcomfort.report.descriptives import PRIMARY, TIMEPOINT, DescribedRow
from vrcomfort.report.paper import FILE as PAPER_FILE
from vrcomfort.report.paper import paper_text
from vrcomfort.report.references import entries
from vrcomfort.report.results import PLAN_FILE
from vrcomfort.report.sections import section_names, section_sentences
from vrcomfort.report.withdrawals import with_labels
from vrcomfort.report.writing import file_name
from vrcomfort.web_page import inline_svg, page_templates, policy_with

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from jinja2 import Environment

    from vrcomfort.report.analyses import PageAnalysis, ReportContext
    from vrcomfort.report.analyses.contract import AnalysisFigure
    from vrcomfort.report.canvas import Drawing
    from vrcomfort.report.pairs import Tested
    from vrcomfort.report.results import Results
    from vrcomfort.report.sections import Section
    from vrcomfort.report.symptoms import SymptomRow
    from vrcomfort.report.vocabulary import Vocabulary

TEMPLATE, SCRIPT = "report.html.j2", "report/page.js"
MOST_SIDES = 4
"""Of more, the question has their number."""
MOST_ANSWERS = 8
"""Of more, those on other outcomes than the first are in the tables alone."""
_TAG = re.compile(r"<[a-z][^<>]*>")
_COLOUR = re.compile("#[0-9a-f]{6}")
_VARIABLES = {colour.light: f"var({colour.variable})" for colour in palette.ALL}


def render_page(
    results: Results,
    figures: dict[str, Drawing],
    report: ReportContext,
    forms: Sequence[str],
    sections: Sequence[Section],
    tables: Collection[str],
) -> ReportPages:
    """Fill the report template, and write its text for a paper.

    Parameters
    ----------
    figures
        Name → drawing; their SVG is inlined into the page. None at all: nothing was drawn.
    forms
        In which figures stand beside the page.
    sections
        The analyses with a section of their own.
    tables
        File names of the CSV tables.
    """
    paragraphs, vocabulary = methods.methods(results, report, sections), report.words
    analyses = list(page_analyses(results.rows, report))
    answers, of_sections = _answers(results, vocabulary), section_sentences(sections, vocabulary)
    references = entries(key for method in paragraphs for key in method.cited)
    text = paper_text(
        results.flow,
        paragraphs,
        [*(line for group in answers for line in group.lines), *of_sections],
        references,
        f"Analyses were made with {', '.join(map(' '.join, results.software.items()))}.",
    )
    script = _script()
    page = (
        _templates()
        .get_template(TEMPLATE)
        .render(
            policy=policy_with(script),
            script=script,
            paper=text,
            paper_file=PAPER_FILE,
            question=_question(results),
            r=results,
            plan_file=PLAN_FILE,
            labelled=partial(with_labels, labels=vocabulary.labels),
            forms=[form.upper() for form in forms],
            words=vocabulary,
            shown_above=_shown_above(results, analyses, figures),
            analyses=analyses,
            answers=answers,
            of_sections=of_sections,
            figures={
                name: PageFigure(_inlined(drawing.svg, name), _files(name, drawing, forms, tables))
                for name, drawing in figures.items()
            },
            several=report.several,
            symptoms=_by_instrument(results.symptoms),
            methods=paragraphs,
            references=references,
            basis=methods.basis_sentence(results),
            has_baseline=methods.has_baseline(results),
            described=_described(results),
            possible=_possible(results, vocabulary),
            moments=_moments(results),
            sections=[each.analysis for each in sections if each.is_on_page],
            **section_names(),
            colours_light=palette.css_variables(dark=False),
            colours_dark=palette.css_variables(dark=True),
        )
    )
    return ReportPages(page, text)


class ReportPages(NamedTuple):
    """The page, and its text for a paper."""

    page: str
    paper: str


@dataclass(frozen=True)
class LinkedFile:
    """A file beside the page."""

    label: str
    path: str


@dataclass(frozen=True)
class PageFigure:
    """A figure in the page, and its files: the forms of the figure, and its data."""

    svg: Markup
    files: tuple[LinkedFile, ...]


def _files(
    name: str, drawing: Drawing, forms: Sequence[str], tables: Collection[str]
) -> tuple[LinkedFile, ...]:
    """Return the files of a figure as links."""
    stem = quote(file_name(name))
    data = [f"{table}.csv" for table in drawing.tables if f"{table}.csv" in tables]
    return (
        *(LinkedFile(form.upper(), f"figures/{stem}.{form}") for form in forms),
        *(LinkedFile(table, f"tables/{table}") for table in data),
    )


def _question(results: Results) -> str:
    """Return the question of the primary comparisons; blank where there is none."""
    rows: list[Tested] = [*results.tests, *results.comparisons]
    if not results.outcomes or not rows or results.without_primary:
        return ""
    words, primary = results.vocabulary, results.outcomes[0]
    sides = dict.fromkeys(
        words.condition(name)
        for row in rows
        if row.outcome == primary.name
        for name in (row.a, row.b)
    )
    if not sides:
        return ""
    named = [*sides]
    between = f"{', '.join(named[:-1])} and {named[-1]}"
    if len(named) > MOST_SIDES:
        between = f"the {len(named)} conditions"
    short = next((each.short for each in words.instruments if each.name == primary.instrument), "")
    title = words.outcome(primary.name)
    title = title if title[1:2].isupper() else f"{title[:1].lower()}{title[1:]}"
    known = "" if not short or short in title else f" ({short})"
    return f"Does {title}{known} differ between {between}?"


@cache
def _script() -> Markup:
    """Return the script of the page, a file beside the templates."""
    templates = _templates()
    text, _, _ = templates.loader.get_source(templates, SCRIPT)  # type: ignore[union-attr]
    return Markup(text)  # noqa: S704


@cache
def _templates() -> Environment:
    """Return the templates, compiled once: that takes longer than to fill them."""
    environment = page_templates()
    environment.filters |= {
        "number": words.number,
        "fraction": words.fraction,
        "p": words.p_value,
        "interval": words.interval,
        "degrees": words.degrees,
        "bayes": words.bayes_factor,
    }
    return environment


@dataclass(frozen=True)
class OutcomeAnswers:
    """The sentences on an outcome, or, with blank names, on several outcomes."""

    outcome: str
    name: str
    primary: bool
    lines: list[Sentence]


def _answers(results: Results, words: Vocabulary) -> list[OutcomeAnswers]:
    """Return the sentences by outcome, in the plan's order.

    Of many questions those of other outcomes than the first are in the tables alone. None is
    primary where the planned primary outcome is not in the data.
    """
    said, order = outcome_sentences(results.rows, words), list(words.outcomes)
    shown = order if len(said) <= MOST_ANSWERS else order[:1]
    groups = [
        OutcomeAnswers(
            outcome,
            words.outcome(outcome),
            primary=outcome == order[0] and not results.without_primary,
            lines=[sentence for name, sentence in said if name == outcome],
        )
        for outcome in shown
        if any(name == outcome for name, _ in said)
    ]
    others = sentences(results.rows, words)
    alone = OutcomeAnswers("", "", not (groups or results.without_primary), others)
    return [*groups, alone] if others else groups


def _shown_above(
    results: Results, analyses: Sequence[PageAnalysis], figures: Mapping[str, Drawing]
) -> AnalysisFigure | None:
    """Return the figure of the primary comparison, where no signed-rank test has one."""
    primary = next((each.name for each in results.outcomes), "")
    if results.without_primary or f"estimation_{primary}" in figures:
        return None
    named = (each for analysis in analyses for each in analysis.figures)
    return next((f for f in named if f.outcome == primary and f.name in figures), None)


def _inlined(svg: str, name: str) -> Markup:
    """Return a figure in the colours of the page: dark on paper, light on a dark one."""
    themed = _TAG.sub(lambda tag: _COLOUR.sub(_variable, tag[0]), svg)
    return inline_svg(themed, name, 'role="img" aria-hidden="true"')


def _variable(colour: re.Match[str]) -> str:
    return _VARIABLES.get(colour[0], colour[0])


def _described(results: Results) -> list[DescribedRow]:
    """Return the descriptions of tested participants by condition; differences of a single pair."""
    tests, order = results.tests, [each.name for each in results.outcomes]
    rows = [row for row in results.descriptives if row.by == PRIMARY]
    if len({(test.a, test.b) for test in tests}) == 1:
        rows += [
            DescribedRow(test.outcome, PRIMARY, "", None, test.found.difference)
            for test in tests
            if test.found
        ]
    return sorted(rows, key=lambda row: order.index(row.outcome))


def _possible(results: Results, vocabulary: Vocabulary) -> str:
    """Return the range of each score that is described."""
    return ", ".join(
        f"{vocabulary.outcome(each.name)} {words.number(each.low)} to {words.number(each.high)}"
        for each in results.outcomes
        if each.basis != "measured" and each.high is not None
    )


def _moments(results: Results) -> list[DescribedRow]:
    """Return the raw scores by timepoint where timepoints are compared, or nothing is."""
    sides = [side for test in results.tests for side in test.sides]
    if sides and not any(side.timepoint for side in sides):
        return []
    return [row for row in results.descriptives if row.by == TIMEPOINT]


class _InstrumentAnswers(NamedTuple):
    """The answers to an instrument: its conditions, and a line for each item."""

    instrument: str
    conditions: list[str]
    lines: list[tuple[str, list[SymptomRow | None]]]


def _by_instrument(rows: list[SymptomRow]) -> list[_InstrumentAnswers]:
    found = []
    for instrument in dict.fromkeys(row.instrument for row in rows):
        mine = [row for row in rows if row.instrument == instrument]
        conditions = list(dict.fromkeys(row.condition for row in mine))
        cells = {(row.item, row.condition): row for row in mine}
        items = dict.fromkeys(row.item for row in mine)
        lines = [(item, [cells.get((item, name)) for name in conditions]) for item in items]
        found.append(_InstrumentAnswers(instrument, conditions, lines))
    return found
