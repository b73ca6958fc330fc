"""The analyses with a section of their own on the page: ratings during exposure, gaze and head.

Another one is a `SectionAnalysis`, which declares its table of settings in plans as well, its
template in ``analysis/report``, and a line in `SECTIONS`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vrcomfort.report.analyses import MethodsParagraph, Sentence
from vrcomfort.report.analyses.contract import SectionAnalysis, SectionData
from vrcomfort.report.gaze_and_head import GAZE_AND_HEAD
from vrcomfort.report.ratings import RATINGS
from vrcomfort.report.rows import rounded

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from vrcomfort.report.canvas import Drawing
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary

SECTIONS: tuple[SectionAnalysis[Any], ...] = (RATINGS, GAZE_AND_HEAD)
"""All of them, in the order of the page and of results.json."""


@dataclass(frozen=True)
class Section:
    """An analysis that was made, with its part of results.json."""

    analysis: SectionAnalysis[Any]
    found: Any
    results: Mapping[str, DataclassInstance | None]

    @property
    def is_on_page(self) -> bool:
        """Return whether the page has this section."""
        return bool(self.results[self.analysis.key])

    @property
    def conditions(self) -> Iterable[str]:
        """Return the conditions in its data."""
        return self.analysis.conditions(self.found)

    @property
    def notes(self) -> Iterable[str]:
        """Return the recordings that could not be read."""
        return self.analysis.notes(self.found)


def run_sections(data: SectionData) -> list[Section]:
    """Make all analyses that the plan asks for and the data allow."""
    made = ((each, each.compute(data, _settings(data.plan, each))) for each in SECTIONS)
    return [Section(each, found, rounded(each.results(found))) for each, found in made]


def _settings(plan: Plan, analysis: SectionAnalysis[Any]) -> Any:
    """Return the settings of an analysis in a plan."""
    return getattr(plan, analysis.key, analysis.default)


def section_tables(sections: Iterable[Section]) -> dict[str, Sequence[Cells]]:
    """Return the name of each CSV table and its lines."""
    return {
        name: lines for each in sections for name, lines in each.analysis.tables(each.found).items()
    }


def section_figures(sections: Iterable[Section], words: Vocabulary) -> dict[str, Drawing | None]:
    """Return name → drawing; None where there is nothing to draw."""
    return {
        name: drawing
        for each in sections
        for name, drawing in each.analysis.figures(each.found, words).items()
    }


def section_sentences(sections: Iterable[Section], words: Vocabulary) -> list[Sentence]:
    """Return the answers of the analyses with a section of their own."""
    return [said for each in sections for said in each.analysis.sentences(each.found, words)]


def section_paragraphs(sections: Iterable[Section]) -> list[MethodsParagraph]:
    """Return the paragraphs of the methods section."""
    return [method for each in sections for method in each.analysis.methods(each.found)]


def section_names() -> dict[str, Mapping[str, str]]:
    """Return the names that the templates of all sections use, by variable."""
    return {name: names for each in SECTIONS for name, names in each.names.items()}
