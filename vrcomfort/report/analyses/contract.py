"""An analysis: one declaration of its plan key, its people, its computation and its renderings."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import groupby
from typing import TYPE_CHECKING, Any, Generic, Literal, Protocol, TypeVar

from markupsafe import Markup

from vrcomfort.errors import InputError
from vrcomfort.report.rows import Cells, cells
from vrcomfort.report.words import degrees, interval, number, p_value
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
    from vrcomfort.stats.mixed import Estimate

Row = TypeVar("Row")
Line = TypeVar("Line")
Found = TypeVar("Found")
Section = Literal["primary", "tests", "order", "models", "assumptions", "sensitivity"]
"""A part of the page; `primary` are the signed-rank tests, at the head of the tests."""
ITALIC_N = Markup("<i>n</i>")
ITALIC_P = Markup("<i>p</i>")
ITALIC_SE = Markup("<i>SE</i>")
ITALIC_T = Markup("<i>t</i>")
P_HOLM = Markup("<i>p</i> Holm")
WITHOUT_ZERO = " “Without 0”: the test rejects 0 between shifts that it does not reject."
"""Note below a table with such an interval; see `is_holed`."""
MOST_NAMED = 30
"""Participants whom a line names; of more it tells the number."""


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
class ReportContext:
    """The report that rows are rendered for.

    Parameters
    ----------
    several
        Whether a condition has several exposures, of which tests take the mean.
    drawn
        Whether the report has figures.
    """

    words: Vocabulary
    plan: Plan
    several: bool
    drawn: bool


Text = str | Callable[[Sequence[Any], ReportContext], str]
"""A heading or a caption; one that depends on rows or plan is made of them."""


@dataclass(frozen=True)
class MethodsParagraph:
    """One paragraph of the methods section, with the keys of its references.

    It stands among those of `section`; without one, of its analysis' section.
    """

    title: str
    text: str
    cited: tuple[str, ...] = ()
    section: Section | None = None


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
class Remark:
    """A paragraph on the page, before the tables of `section` (without one, the analysis' own)."""

    text: str
    section: Section | None = None


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
class PageLine:
    """A line of a table; a group's one stands above the lines of the group."""

    cells: tuple[PageCell, ...]
    of_group: bool = False


@dataclass(frozen=True)
class PageTable:
    """A table as the page has it."""

    caption: str
    headings: tuple[PageCell, ...]
    lines: tuple[PageLine, ...]
    note: str


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
        Of the CSV file; blank: there is none.
    csv
        A row's lines of the CSV file; without it, one line with the row's fields.
    caption, columns, note
        Of the page. A table without columns is a CSV file alone, one without lines is left away.
    lines
        A row's lines on the page; without it, one line.
    spanning
        Text in place of all columns after the first `labels`: why a line has no numbers, say.
    group, group_key
        The line above the lines of a row, or of neighbouring rows with the same key; blank: none.
    section
        Where on the page, if not with its analysis.
    """

    name: str
    caption: Text = ""
    columns: tuple[TableColumn[Line], ...] = ()
    lines: Callable[[Row], Iterable[Line]] = _itself  # type: ignore[assignment]
    spanning: Callable[[Line], str | None] = lambda _: None
    labels: int = 1
    group: Callable[[Row, Sequence[Row], ReportContext], str] | None = None
    group_key: Callable[[Row], object] = id
    note: Callable[[Sequence[Row], ReportContext], str] = lambda _rows, _report: ""
    csv: Callable[[Row], Iterable[Cells]] = _csv_of_fields
    section: Section | None = None

    def on_page(self, rows: Sequence[Row], report: ReportContext) -> PageTable | None:
        """Return the table as the page has it; None where that has none."""
        lines = tuple(self._lines(rows, report)) if self.columns else ()
        if not lines:
            return None

        def written(text: Text) -> str:
            return text if isinstance(text, str) else text(rows, report)

        return PageTable(
            written(self.caption),
            tuple(PageCell(written(each.heading), each.of_words) for each in self.columns),
            lines,
            self.note(rows, report),
        )

    def _lines(self, rows: Sequence[Row], report: ReportContext) -> Iterator[PageLine]:
        # Neighbours only: rows stay in the order of the plan, which may come back to a pair.
        for _, members in groupby(rows, self.group_key):
            group = list(members)
            lines = [self._line(line, report.words) for row in group for line in self.lines(row)]
            if title := self.group and self.group(group[0], rows, report):
                yield PageLine((PageCell(title, columns=len(self.columns)),), of_group=True)
            yield from lines

    def _line(self, line: Line, words: Vocabulary) -> PageLine:
        text = self.spanning(line)
        shown = self.columns if text is None else self.columns[: self.labels]
        found = [PageCell(each.cell(line, words), each.of_words) for each in shown]
        if text is not None:
            found.append(PageCell(text, of_words=True, columns=len(self.columns) - self.labels))
        return PageLine(tuple(found))


@dataclass(frozen=True)
class AnalysisFigure:
    """A figure of an analysis, below its tables.

    Parameters
    ----------
    name
        Of the file.
    kind
        Name by which a plan can want figures; see `Analysis.figure_kinds`.
    outcome
        The outcome that it shows, where it can stand beside the answer on it.
    """

    name: str
    kind: str
    caption: str
    draw: Callable[[Exposures], Drawing | None]
    outcome: str = ""


@dataclass(frozen=True)
class Analysis(Generic[Row]):
    """One analysis: the module that declares it is found by `vrcomfort.report.analyses`.

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
    tables
        On the page in this order; CSV files.
    heading, remarks
        On the page before the tables.
    figures, figure_kinds, side_by_side
        Figures of its rows, the names by which a plan can want them, and whether they stand side
        by side.
    section, place
        Place on the page: of a section's analyses the smallest first. Places and orders are in
        steps of ten, so that others fit between.
    order
        Place in results.json, among the CSV tables and in a section of reproduce.R: the smallest
        first.
    by_outcome
        Whether its answers stand with their outcome, those of the primary one first. Its rows have
        a `Decision`, made in families (those of the ANOVA one for each effect).
    intervals
        Estimates of a row with the intervals of a level: those at which the row decides in its
        family (data, row, level; None where there are none).
    sentences
        The answers of a row.
    methods
        The paragraphs on rows that could be estimated; what they cite stands in references.toml,
        or in `references` (key → entry).
    analysed
        The participants of each test, of an analysis that answers a question by itself: they are
        the analysed ones of a report that compares nothing.
    r_lines, r_functions
        A part of reproduce.R that makes the numbers again, and functions that others can use too.
    """

    key: str
    people: AnalysisSet
    compute: Callable[[AnalysisData, Sequence[Any]], Sequence[Row]]
    asked: Any = None
    about: str = ""
    problems: Callable[[Plan, Sequence[Any]], Iterable[Problem]] = lambda _plan, _asked: ()
    tables: tuple[AnalysisTable[Row, Any], ...] = ()
    heading: Callable[[Sequence[Row]], str] = lambda _: ""
    remarks: Callable[[Sequence[Row], ReportContext], Iterable[Remark]] = lambda _rows, _report: ()
    figures: Callable[[Sequence[Row], ReportContext], Iterable[AnalysisFigure]] = (
        lambda _rows, _report: ()
    )
    figure_kinds: tuple[str, ...] = ()
    side_by_side: bool = False
    section: Section = "tests"
    place: int = 1000
    order: int = 1000
    by_outcome: bool = False
    intervals: Callable[[AnalysisData, Row, float], Any] = lambda _data, _row, _level: None
    sentences: Callable[[Row, Vocabulary], Iterable[Sentence]] = lambda _row, _words: ()
    methods: Callable[[Sequence[Row], ReportContext], Iterable[MethodsParagraph]] = (
        lambda _rows, _report: ()
    )
    references: Mapping[str, str] = field(default_factory=dict)
    analysed: Callable[[Sequence[Row]], Iterable[Collection[str]]] | None = None
    r_lines: str = ""
    r_functions: str = ""

    def of(self, rows: Mapping[str, Sequence[Any]]) -> Sequence[Row]:
        """Return its rows among those of all analyses, by key."""
        return rows[self.key]


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
        Makes the analysis, of the data and of the settings in the plan (see `asked`).
    asked, default, about
        Type of its settings, the settings of a plan that does not have the key (None: the analysis
        is not made), and the description of the key.
    results
        What its keys of results.json hold; None where there is nothing.
    tables
        Name → lines of its CSV tables.
    figures, figure_kinds
        Name → drawing, None where there is nothing to draw; and the names by which a plan can want
        them.
    methods
        The paragraphs on what was made; what they cite stands in references.toml.
    sentences
        Its answers, on the first screen of the page below those on outcomes, and on the terminal.
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
    asked: Any
    compute: Callable[[SectionData, Any], Found]
    results: Callable[[Found], Mapping[str, DataclassInstance | None]]
    tables: Callable[[Found], Mapping[str, Sequence[Cells]]]
    figures: Callable[[Found, Vocabulary], Mapping[str, Drawing | None]]
    methods: Callable[[Found], Iterable[MethodsParagraph]]
    default: Any = None
    about: str = ""
    figure_kinds: tuple[str, ...] = ()
    sentences: Callable[[Found, Vocabulary], Iterable[Sentence]] = lambda _found, _words: ()
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


def interval_heading(_: Sequence[object], report: ReportContext) -> str:
    """Return the heading of a column of intervals at the plan's confidence."""
    return f"{percent(report.plan.confidence)} CI"


def decided_interval(rows: Sequence[Any], report: ReportContext) -> str:
    """Return the heading of intervals of the level at which each row decides in its family."""
    adjusted = any(row.decision.simultaneous for row in rows)
    return interval_heading(rows, report) + " (Holm)" * adjusted


def is_holed(found: object) -> bool:
    """Return whether an interval of a shift holds 0 though its test rejects 0."""
    return bool(getattr(found, "holds_rejected_zero", False))


def starred_p(p: float | None, method: str | None) -> str:
    """Return p, with an asterisk where it is asymptotic."""
    return p_value(p) + "*" * (method == "asymptotic")


def with_dot(name: str, words: Vocabulary) -> str:
    """Return a condition's label behind a dot of its colour."""
    # The style sheet has six colours; the shapes of figures tell further conditions apart.
    place = str(words.place(name) % 6)
    return html('<span class="dot c{}"></span>{}', place, words.condition(name))


def html(text: str, *inserted: str) -> Markup:
    """Return HTML with texts inserted at its ``{}``, escaped unless they are HTML already."""
    safe = (t if isinstance(t, Markup) else escape_hidden(t) for t in inserted)
    return Markup(text).format(*safe)  # noqa: S704 - a constant of the program


def p_in_html(p: float) -> Markup:
    """Return p in a line of the page."""
    return html("<i>p</i> {}{}", "" if p < 0.001 else "= ", p_value(p))


def by_reason(rows: Iterable[Row], reason: Callable[[Row], str | None]) -> dict[str, list[Row]]:
    """Return the rows that have a reason for having no numbers: reason → rows, by alphabet."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        if why := reason(row):
            found.setdefault(why, []).append(row)
    return {why: found[why] for why in sorted(found, key=str.lower)}


class _OfOutcome(Protocol):
    """A row on one outcome, which may have no numbers."""

    @property
    def outcome(self) -> str: ...

    @property
    def not_tested(self) -> str | None: ...


def missing_outcomes(
    rows: Iterable[_OfOutcome], report: ReportContext, what: str
) -> Iterator[Remark]:
    """Yield which outcomes an analysis could not be made of, a paragraph for each reason."""
    for reason, missing in by_reason(rows, lambda row: row.not_tested).items():
        named = ", ".join(report.words.outcome(row.outcome) for row in missing)
        yield Remark(f"{named}: no {what} ({reason}).")


def estimate_columns(
    found: Callable[[Line], Estimate], ends: Text
) -> tuple[TableColumn[Line], ...]:
    """Return the columns on an estimate of a model and its t test; `ends` heads the intervals."""
    return (
        TableColumn("estimate", lambda line, _: number(found(line).estimate)),
        TableColumn(ITALIC_SE, lambda line, _: number(found(line).standard_error)),
        TableColumn("df", lambda line, _: degrees(found(line).df)),
        TableColumn(ITALIC_T, lambda line, _: number(found(line).t)),
        TableColumn(ITALIC_P, lambda line, _: p_value(found(line).p)),
        TableColumn(ends, lambda line, _: interval(found(line))),
    )
