"""An analysis: one declaration of its plan key, its people, its computation and its renderings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

from markupsafe import Markup

from vrcomfort.errors import InputError
from vrcomfort.report.rows import Cells, cells
from vrcomfort.report.words import degrees, p_value
from vrcomfort.settings import Problem, did_you_mean
from vrcomfort.web_page import escape_hidden

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from vrcomfort.records.recording import Memory
    from vrcomfort.report.canvas import Drawing
    from vrcomfort.report.contrasts import Compared
    from vrcomfort.report.exclusions import ExcludedByRule
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.report.withdrawals import Withdrawal

Row = TypeVar("Row")
Line = TypeVar("Line")
Found = TypeVar("Found")
Section = Literal["tests", "models", "order"]
ITALIC_N = Markup("<i>n</i>")
ITALIC_P = Markup("<i>p</i>")
Text = str | Callable[[float], str]
"""A heading or a caption; one that names an interval is made of the plan's confidence."""


class AnalysisSet(Enum):
    """Participants and exposures that an analysis counts; the rule is the same for all outcomes."""

    ALL_AVAILABLE = "all available"
    """Every scored exposure of everybody, as in mixed models."""
    COMPLETE_CASES = "complete cases"
    """Participants with every planned score of the outcome."""
    COMPLETE_PAIRS = "complete pairs"
    """Participants with every planned score of both sides of a contrast."""
    COMPLETE_BLOCKS = "complete blocks"
    """Participants with every planned score of every condition or cell."""

    def needs_every_score(self, plan: Plan) -> bool:
        """Return whether people without a planned score are left out, as the plan has it."""
        return self is not AnalysisSet.ALL_AVAILABLE and plan.needs_every_score


@dataclass(frozen=True)
class AnalysisData:
    """The data of one analysis.

    Parameters
    ----------
    conditions
        Those in the data, in the protocol's order.
    reference
        The condition that models compare with.
    contrasts
        The comparisons of the plan.
    withdrawals
        The participants who left, and under which condition.
    complete
        Whether participants without a planned score are left out; see `AnalysisSet`.
    """

    study: StudyData
    scored: Exposures
    plan: Plan
    conditions: Sequence[str]
    reference: str
    contrasts: Sequence[Compared]
    withdrawals: Sequence[Withdrawal]
    complete: bool

    def has(self, *outcomes: str) -> bool:
        """Return whether the data have all of these outcomes of the plan."""
        return set(outcomes) <= {each.name for each in self.scored.outcomes}


def estimable(compute: Callable[[], Found]) -> tuple[str | None, Found | None]:
    """Return why there is no estimate (an InputError says it), and the estimate."""
    try:
        return None, compute()
    except InputError as error:
        return error.message, None


@dataclass(frozen=True)
class MethodsParagraph:
    """One paragraph of the methods section, with the keys of its references."""

    title: str
    text: str
    cited: tuple[str, ...] = ()


@dataclass(frozen=True)
class Sentence:
    """An answer in words: a plain claim, and the numbers behind it."""

    claim: str
    evidence: str = ""

    @property
    def text(self) -> str:
        """Return both parts as one text."""
        return f"{self.claim} {self.evidence}" if self.evidence else self.claim


@dataclass(frozen=True)
class TableColumn(Generic[Line]):
    """A column on the page.

    Parameters
    ----------
    cell
        Writes the cell of a line; `Markup` where it is more than text.
    of_words
        Whether cells are words, which are set to the left, or numbers.
    """

    heading: Text
    cell: Callable[[Line, Vocabulary], str]
    of_words: bool = False


@dataclass(frozen=True)
class PageCell:
    """A cell as the page has it."""

    content: str
    of_words: bool = False
    columns: int = 1


@dataclass(frozen=True)
class PageTable:
    """A table as the page has it; `template`, if any, writes it instead."""

    caption: str
    headings: tuple[PageCell, ...]
    lines: tuple[tuple[PageCell, ...], ...]
    note: str
    template: str


def _itself(row: Row) -> Iterator[Row]:
    yield row


def _csv_of_fields(row: object) -> Iterator[Cells]:
    yield cells(row)


@dataclass(frozen=True)
class AnalysisTable(Generic[Row, Line]):
    """A table of an analysis, on the page and as a CSV file.

    Parameters
    ----------
    name
        Of the CSV file.
    csv
        A row's lines of the CSV file; without it, one line with the row's fields.
    caption, columns, note
        Of the page. A table without columns is a CSV file alone.
    lines
        A row's lines on the page; without it, one line.
    not_estimable
        Why a line has no numbers: this stands in place of all columns after the first `labels`.
    template
        Template that writes the table on the page, where columns do not suffice.
    """

    name: str
    caption: Text = ""
    columns: tuple[TableColumn[Line], ...] = ()
    lines: Callable[[Row], Iterable[Line]] = _itself  # type: ignore[assignment]
    not_estimable: Callable[[Line], str | None] = lambda _: None
    labels: int = 1
    note: Callable[[Sequence[Row]], str] = lambda _: ""
    csv: Callable[[Row], Iterable[Cells]] = _csv_of_fields
    template: str = ""

    def on_page(self, rows: Sequence[Row], words: Vocabulary, confidence: float) -> PageTable:
        """Return the table as the page has it."""

        def written(text: Text) -> str:
            return text if isinstance(text, str) else text(confidence)

        return PageTable(
            written(self.caption),
            tuple(PageCell(written(each.heading), each.of_words) for each in self.columns),
            tuple(self._line(line, words) for row in rows for line in self.lines(row)),
            self.note(rows),
            self.template,
        )

    def _line(self, line: Line, words: Vocabulary) -> tuple[PageCell, ...]:
        reason = self.not_estimable(line)
        shown = self.columns if reason is None else self.columns[: self.labels]
        found = [PageCell(each.cell(line, words), each.of_words) for each in shown]
        if reason is not None:
            found.append(PageCell(reason, of_words=True, columns=len(self.columns) - self.labels))
        return tuple(found)


@dataclass(frozen=True)
class AnalysisFigure(Generic[Row]):
    """A figure of an analysis, below its tables."""

    name: str
    caption: str
    draw: Callable[[Sequence[Row], Vocabulary], Drawing | None]


@dataclass(frozen=True)
class Analysis(Generic[Row]):
    """One analysis.

    Parameters
    ----------
    key
        In results.json, and in the plan.
    people
        Its analysis set.
    compute
        Makes its rows, of the data and of the plan's entries (see `asked`).
    asked
        Type of an entry of the plan's key, which is a list of them; None: it has no key of its own.
    about
        Description of the plan's key.
    problems
        Yields what the types of entries cannot say is wrong: plan, entries → problems.
    tables, figure
        On the page in this order; CSV files.
    section, place
        Place on the page: of a section's analyses the smallest first.
    by_outcome
        Whether its answers stand with their outcome, those of the primary one first.
    sentences
        The answers of a row.
    methods
        The paragraphs on rows that could be estimated; what they cite stands in references.toml,
        or in `references` (key → entry).
    analysed
        The participants of a row, of an analysis that answers a question by itself: they are the
        analysed ones of a report that compares nothing.
    r_lines
        A section of reproduce.R that makes the numbers again.
    """

    key: str
    people: AnalysisSet
    compute: Callable[[AnalysisData, Sequence[Any]], Sequence[Row]]
    asked: Any = None
    about: str = ""
    problems: Callable[[Plan, Sequence[Any]], Iterable[Problem]] = lambda _plan, _asked: ()
    tables: tuple[AnalysisTable[Row, Any], ...] = ()
    figure: AnalysisFigure[Row] | None = None
    section: Section = "tests"
    place: int = 99
    by_outcome: bool = False
    sentences: Callable[[Row, Vocabulary], Iterable[Sentence]] = lambda _row, _words: ()
    methods: Callable[[Sequence[Row]], Iterable[MethodsParagraph]] = lambda _: ()
    references: Mapping[str, str] = field(default_factory=dict)
    analysed: Callable[[Row], Sequence[str]] | None = None
    r_lines: str = ""


@dataclass(frozen=True)
class SectionData:
    """The data of an analysis with a section of its own.

    Parameters
    ----------
    conditions
        Those of the report.
    labels
        Label of each condition and other side of a contrast, in the order of the report.
    pairs
        The pairs of conditions that are compared.
    exclusions
        The participants and exposures that rules of the plan leave out.
    memory
        The most that reading frames may take.
    """

    study: StudyData
    plan: Plan
    conditions: Sequence[str]
    labels: Mapping[str, str]
    pairs: Sequence[tuple[str, str]]
    exclusions: Sequence[ExcludedByRule]
    memory: Memory | None = None


@dataclass(frozen=True)
class SectionAnalysis(Generic[Found]):
    """An analysis of ratings or recordings, with a section of its own on the page.

    Its rows are not a list of like ones, as those of an `Analysis` are: its template writes them.

    Parameters
    ----------
    key
        In the plan, as a table of settings, and in results.json; without results under it, the
        page has no section.
    anchor, heading, template
        Of the section on the page.
    compute
        Makes the analysis, of the data and of the plan.
    results
        What its keys of results.json hold; None where there is nothing.
    tables
        Name → lines of its CSV tables.
    figures
        Name → drawing; None where there is nothing to draw.
    methods
        The paragraphs on what was made; what they cite stands in references.toml.
    conditions
        Those in its data, which may be none of the scores' conditions.
    notes
        Recordings that could not be read.
    names
        Names that the template uses beside the words of the report, by variable.
    """

    key: str
    anchor: str
    heading: str
    template: str
    compute: Callable[[SectionData], Found]
    results: Callable[[Found], Mapping[str, DataclassInstance | None]]
    tables: Callable[[Found], Mapping[str, Sequence[Cells]]]
    figures: Callable[[Found, Vocabulary], Mapping[str, Drawing | None]]
    methods: Callable[[Found], Iterable[MethodsParagraph]]
    conditions: Callable[[Found], Iterable[str]] = lambda _: ()
    notes: Callable[[Found], Iterable[str]] = lambda _: ()
    names: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


def unknown_outcome(plan: Plan, name: str, *path: str | int) -> Iterator[Problem]:
    """Yield that an entry names an outcome that the plan does not have."""
    if plan.outcomes and name not in plan.outcomes:
        hint = did_you_mean(name, plan.outcomes)
        yield Problem(path, f"`{name}` is not among the outcomes; {hint}")


def percent(confidence: float) -> str:
    """Return a confidence as tables have it."""
    return f"{degrees(100 * confidence)} %"


def interval_heading(confidence: float) -> str:
    """Return the heading of a column of intervals."""
    return f"{percent(confidence)} CI"


def starred_p(p: float | None, method: str | None) -> str:
    """Return p, with an asterisk where it is asymptotic."""
    return p_value(p) + "*" * (method == "asymptotic")


def with_dot(name: str, words: Vocabulary) -> str:
    """Return a condition's label behind a dot of its colour."""
    dot = Markup('<span class="dot c{}"></span>{}')
    return dot.format(words.place(name) % 6, escape_hidden(words.condition(name)))
