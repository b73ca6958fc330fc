"""The mapping: the meaning of each column of a lab's files, in TOML, checked here."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Discriminator, Field, PrivateAttr, Tag

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.importing.source import Reading
from vrcomfort.questionnaire import (
    Instrument,
    InstrumentTable,
    Scale,
    find_instrument,
    instrument_in,
    shipped_instruments,
)
from vrcomfort.settings import (
    KeyPath,
    Problem,
    Settings,
    did_you_mean,
    first_problem,
    parse_settings,
    union_tag,
)

FACTS = ("participant", "session", "period", "block", "trial", "condition", "scene", "timepoint")
"""What is known of a questionnaire beside its answers."""

ScoreKind = Literal["score", "raw_sum", "other"]
TIMES = frozenset(["time_s", "time_min"])
"""When a rating during exposure was given, in headings."""
Summary = Literal["peak", "mean", "last"]
Texts = str | tuple[str, ...]
Bounded = Annotated[float, Field(ge=-1e6, le=1e6)]
"""An answer, in the range of instruments."""


class Fact(Settings):
    """Where a fact comes from."""

    column: str | None = None
    columns: tuple[str, ...] = ()
    """Several columns that together say it; their texts are joined by ``_``."""
    constant: str | None = None
    """The same for all rows."""
    values: dict[str, str] = Field(default_factory=dict)
    """The file's word → ours. Where there are any, all words of the file must be here; but
    participants who are not here keep their names."""
    order: str | None = None
    """Of the condition: the column that gives those of a row in their order, such as ``BAC``."""
    by: Literal["trial", "session", "period"] = "trial"
    """With `order`: the fact that numbers the questionnaires of a row."""
    apart: bool = False
    """Of participants: those of each file, or sheet, are other people; it stands before their
    names."""
    count: bool = False
    """Number what is met, from 1 for each participant, in the order of the rows: the different
    texts of the column, or (without one) each exposure. For participants: number the texts, which
    may be names of people, or (without a column) the rows."""


class TextRead(Settings):
    """How a text file is read; omitted keys are detected, and noted."""

    encoding: str | None = None
    separator: str | None = None
    decimal: Literal[".", ","] | None = None


class Read(TextRead):
    """How the files are read; omitted keys are detected, and noted."""

    heading_rows: tuple[Annotated[int, Field(ge=0)], ...] | None = None
    skip_rows: tuple[Annotated[int, Field(ge=0)], ...] = ()
    transpose: bool = False
    """Participants stand side by side, items one below the other."""
    stack: bool = False
    """The headings repeat in the row: each run of them is a table, one below the other."""
    sections: bool = False
    """Several tables stand one below the other: each is a sheet, called ``sheet: title``."""
    marked: bool = False
    """Of several columns a row marks one (``x``): they are one column, of the headings marked."""
    spread: tuple[str, ...] = ()
    """Columns with a list of numbers in each cell: ``SSQ`` is read as ``SSQ_1``, ``SSQ_2`` …"""

    @property
    def reading(self) -> Reading:
        """Return the same for the readers."""
        return Reading(**dict(self))


class AnswerCoding(Settings):
    """How answers stand in the file."""

    answers: dict[str, Bounded] = Field(default_factory=dict)
    """The file's word → the number of the instrument."""
    coded_from: Annotated[int, Field(ge=-1000000, le=1000000)] | None = None
    """The number that stands for the lowest answer, where that is not the instrument's own."""
    times: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """What the file's numbers are multiplied by: 5 for marks of 0 to 20 in place of 0 to 100."""
    reverse_coded: bool = False
    """Whether the file's highest number is the instrument's lowest answer."""
    missing: tuple[str, ...] = ()
    """Texts that mean that there is no answer, beside the blank."""


class _Columns(Settings):
    """Keys of questionnaires and scores alike: their headings, and the facts of these."""

    instrument: str
    heading: str = "{item}"
    """How headings are made: ``{condition}_{item}``; ``{*}`` is anything. Instruments of one item
    need no ``{item}``. ``{time_s}`` and ``{time_min}`` say when a rating was given."""
    pattern: str = ""
    """A regular expression instead, with named groups: ``(?P<condition>A|B)_(?P<item>.+)``."""
    participant: Texts | None = None
    session: Texts | None = None
    period: Texts | None = None
    block: Texts | None = None
    trial: Texts | None = None
    condition: Texts | None = None
    scene: Texts | None = None
    timepoint: Texts | None = None
    """Each fact is one text, or one for each of several `first_columns`."""
    where: dict[str, Texts] = Field(default_factory=dict)
    """Column → text (or texts) that a row has to have there."""
    beside: dict[str, Texts] = Field(default_factory=dict)
    """Fact → the column that says it of this questionnaire alone, beside its answers; with several
    `first_columns`, one for each."""

    def constants(self, place: int = 0) -> dict[str, str]:
        """Return the facts that are said here of one of several questionnaires."""
        said = {f: texts_of(text) for f in FACTS if (text := getattr(self, f)) is not None}
        return {fact: texts[place if texts[1:] else 0] for fact, texts in said.items()}


class Questionnaire(_Columns, AnswerCoding):
    """One questionnaire, or several with headings of one template."""

    items: dict[str, Texts] = Field(default_factory=dict)
    """Item → what stands for ``{item}`` in its heading (in long files: in `item_column`). Without
    any: items by their own names."""
    first_columns: tuple[str, ...] = ()
    """The columns with the first answer of each administration; the others follow it. No other
    questionnaire has these columns, and `ignore` does not count for them."""
    item_order: tuple[str, ...] = ()
    """Items in the order of the columns from each of `first_columns` on (without it, the published
    order); ``""`` is a column that is no item. Items that are not here were not asked."""
    item_column: str | None = None
    """Long files: the column that says which item a row answers."""
    response_column: str | None = None
    """Long files: the column of the answers."""
    not_asked: tuple[str, ...] = ()
    """Items that the lab left out by design."""
    item_coding: dict[str, AnswerCoding] = Field(default_factory=dict)
    """Item → how its answers stand in the file, where they differ from the others'."""
    time: str | None = None
    """For ratings during exposure: the column of the times since its start."""
    time_unit: Literal["s", "min"] = "s"
    summaries: tuple[Summary, ...] = ()
    """What the report is to have of each course of ratings: its highest, mean and last one."""


class Scores(_Columns):
    """Scores, or raw sums, without the answers that they were made of."""

    scales: Annotated[dict[str, str], Field(min_length=1)]
    """Scale → what stands for ``{item}`` in its heading."""
    kind: ScoreKind = "score"
    """`other`: of another formula; taken as they are, on no known range."""


class Leaving(Settings):
    """How long exposures lasted; participants left those that are shorter than planned."""

    heading: str
    """The column of the times, or how their headings are made: ``{condition}_left_at_s``."""
    unit: Literal["s", "min"] = "s"
    planned_s: Annotated[float, Field(gt=0)] | None = None
    """The length of an exposure that nobody leaves: that of blank cells, and of times as long.
    Without it, blank cells have no length, and every time is one at which somebody left."""
    missing: tuple[str, ...] = ()
    """Texts that mean that the participant stayed, beside the blank."""


class TableMapping(Settings):
    """Files (or sheets) with columns of the same meaning."""

    files: Annotated[tuple[str, ...], Field(min_length=1)]
    """Names of files; ``*`` and ``?`` as in a terminal."""
    sheets: tuple[str, ...] = ("*",)
    file_name: str = ""
    """How the file's name (without its ending) is made: ``{participant}_{condition}``; with ``/``
    it begins with the names of folders."""
    file_pattern: str = ""
    """A regular expression instead, with named groups; one that is not there says ``""``."""
    sheet_name: str = ""
    """How the sheet's name is made."""
    read: Read = Field(default_factory=Read)
    participant: Fact = Field(default_factory=Fact)
    session: Fact = Field(default_factory=Fact)
    period: Fact = Field(default_factory=Fact)
    block: Fact = Field(default_factory=Fact)
    trial: Fact = Field(default_factory=Fact)
    condition: Fact = Field(default_factory=Fact)
    scene: Fact = Field(default_factory=Fact)
    timepoint: Fact = Field(default_factory=Fact)
    questionnaires: tuple[Questionnaire, ...] = ()
    scores: tuple[Scores, ...] = ()
    left_at: Leaving | None = None
    """When participants left exposures; for the time to withdrawal in reports."""
    participants: dict[str, str] = Field(default_factory=dict)
    """Name in participants.csv → column: age, sex, group, sequence …"""
    missing: tuple[str, ...] = ()
    """Texts that mean missing in every column."""
    fill_down: tuple[str, ...] = ()
    """Columns in which a blank cell means what the cell above it says."""
    leave_out: dict[str, Texts] = Field(default_factory=dict)
    """Column → texts: rows that have one of them there are no participant's (means, totals)."""
    ignore: tuple[str, ...] = ()
    """Columns that are not taken; every other one has to be said something of. ``a … b`` are all
    from one to the other, ``time_*`` all that are so called, and ``*`` all that nothing takes."""

    def fact(self, name: str) -> Fact:
        """Return where a fact comes from."""
        found: Fact = getattr(self, name)
        return found


class Guess(Settings):
    """A question of less weight, which `--suggest` has answered by a guess."""

    question: str
    assumed: str = ""
    """What the mapping now says."""
    otherwise: str = ""
    """The consequence if that is wrong."""
    instead: str = ""
    """What to write in that case."""


class Doubt(Guess):
    """A question that the files do not answer."""

    answer: str = ""
    """Written by a person; the mapping is refused until there is one."""


_OwnInstrument = Annotated[
    Annotated[str, Tag(union_tag("file"))] | Annotated[InstrumentTable, Tag(union_tag("table"))],
    Discriminator(lambda given: union_tag("file" if isinstance(given, str) else "table")),
]


class LabMapping(Settings):
    """The mapping of all files of a study."""

    format_version: Literal[1]
    name: str = ""
    """The study's title."""
    condition_labels: dict[str, str] = Field(default_factory=dict)
    """Condition → label in the report, in the order in which they are to stand there."""
    condition_levels: dict[str, dict[str, str]] = Field(default_factory=dict)
    """Condition → factor → level, where the conditions are those of crossed factors."""
    instruments: tuple[_OwnInstrument, ...] = ()
    """A lab's own instruments: their TOML files, beside the mapping, or what such files say."""
    ignore_sheets: tuple[str, ...] = ()
    ignore_files: tuple[str, ...] = ()
    """Names of files that hold no answers; ``*`` and ``?`` as in a terminal."""
    tables: Annotated[tuple[TableMapping, ...], Field(min_length=1)]
    doubts: tuple[Doubt, ...] = ()
    guesses: tuple[Guess, ...] = ()

    _text: str = PrivateAttr(default="")
    _file: Path | None = PrivateAttr(default=None)

    @property
    def declared(self) -> tuple[Instrument, ...]:
        """Return the instruments that the mapping itself declares.

        Raises
        ------
        InputError
            If one is wrong, with line and column.
        """
        return tuple(
            self._instrument(each, number)
            for number, each in enumerate(self.instruments)
            if isinstance(each, InstrumentTable)
        )

    def _instrument(self, table: InstrumentTable, number: int) -> Instrument:
        def refuse(found: Iterable[Problem]) -> InputError:
            placed = [replace(each, path=("instruments", number, *each.path)) for each in found]
            return first_problem(placed, self._text, self._file)

        if table.name in shipped_instruments():
            message = f"`{table.name}` is a shipped instrument; give this one another `name`"
            raise refuse([Problem(("name",), message)])
        return instrument_in(table, refuse)

    def require_none(self, found: Iterable[Problem]) -> None:
        """Raise `InputError` with line and column if there is a problem."""
        if problems := list(found):
            raise first_problem(problems, self._text, self._file)


@dataclass(frozen=True)
class MappingFile:
    """A mapping, the text that it was read from, and the instruments that it brings."""

    mapping: LabMapping
    file: Path
    text: str
    instruments: tuple[Instrument, ...] = ()

    @property
    def sha256(self) -> str:
        """Return the hash of the text."""
        return hashlib.sha256(self.text.encode()).hexdigest()


def load_mapping(file: Path) -> MappingFile:
    """Read a mapping, and require an answer to each doubt.

    Raises
    ------
    InputError
        If it is missing or wrong, or a doubt is open; with line and column.
    """
    found = read_mapping(file)
    require_answers(found.mapping.doubts, file)
    return found


def read_mapping(file: Path) -> MappingFile:
    """Read a mapping; its doubts may be open.

    Raises
    ------
    InputError
        If it is missing or wrong, with line and column.
    """
    text = read_text(file, "mapping")
    mapping = parse_mapping(text, file)
    names = (each for each in mapping.instruments if isinstance(each, str))
    own = tuple(find_instrument(name, beside=file.parent) for name in names)
    mapping.require_none(_unknown(mapping, {each.name: each for each in own}))
    return MappingFile(mapping, file, text, own)


def require_answers(doubts: tuple[Doubt, ...], file: Path) -> None:
    """Raise `InputError` if a doubt of a mapping has no answer."""
    still_open = [doubt for doubt in doubts if not doubt.answer.strip()]
    if still_open:
        shown = "; ".join(f"({n}) {d.question}" for n, d in enumerate(still_open, start=1))
        count = "a doubt is" if len(still_open) == 1 else f"{len(still_open)} doubts are"
        message = f"{count} open in this mapping: {shown} - mend what is wrong, and then write"
        raise InputError(f'{message} an answer = "…" in each [[doubts]]', file=file)


def parse_mapping(text: str, file: Path | None) -> LabMapping:
    """Read the text of a mapping; its doubts may be open.

    Raises
    ------
    InputError
        If it is wrong, with line and column.
    """
    mapping = parse_settings(LabMapping, text, file)
    mapping._text, mapping._file = text, file
    mapping.require_none(_problems(mapping))
    known = {**shipped_instruments(), **{each.name: each for each in mapping.declared}}
    mapping.require_none(_unknown(mapping, known))
    return mapping


def _unknown(mapping: LabMapping, known: dict[str, Instrument]) -> Iterator[Problem]:
    """Yield items and scales that the instruments among `known` do not have."""
    for place, table in enumerate(mapping.tables):
        for index, each in enumerate(table.questionnaires):
            if each.instrument in known:
                path: KeyPath = ("tables", place, "questionnaires", index)
                yield from _unknown_items(each, known[each.instrument], path)
        for index, scores in enumerate(table.scores):
            if scores.instrument in known:
                path = ("tables", place, "scores", index, "scales")
                yield from _unknown_scales(scores, known[scores.instrument], path)


def _unknown_scales(scores: Scores, instrument: Instrument, path: KeyPath) -> Iterator[Problem]:
    for name in scores.scales:
        if scale_named(instrument, name) is None:
            hint = did_you_mean(name, [each.name for each in instrument.scales])
            yield Problem((*path, name), f"`{name}` is not a scale of {instrument.name}; {hint}")


def _unknown_items(each: Questionnaire, instrument: Instrument, path: KeyPath) -> Iterator[Problem]:
    names = {item.name for item in instrument.items}
    for key in ("items", "item_coding", "not_asked", "item_order"):
        for index, item in enumerate(getattr(each, key)):
            if item not in names and item:
                near = instrument.nearest(item)
                hint = f"did you mean `{near}`?" if near else did_you_mean(item, names)
                message = f"`{item}` is not an item of {instrument.name}; {hint}"
                yield Problem(
                    (*path, key, index if key in {"not_asked", "item_order"} else item), message
                )


def _problems(mapping: LabMapping) -> Iterator[Problem]:
    """Yield problems between keys, which types cannot express."""
    for place, table in enumerate(mapping.tables):
        here: tuple[str | int, ...] = ("tables", place)
        yield from _fact_problems(table, here)
        if table.file_name and table.file_pattern:
            message = "`file_name` and `file_pattern` say the same; keep one"
            yield Problem((*here, "file_pattern"), message)
        if table.file_pattern:
            yield from _expression(table.file_pattern, (*here, "file_pattern"), {*FACTS})
        if "participant" in table.participants:
            message = "`participant` is a fact; write it beside [tables.participants]"
            yield Problem((*here, "participants", "participant"), message)
        left_at = placeholders(table.left_at.heading) if table.left_at else []
        for unknown in sorted({*left_at} - {*FACTS, "*"}):
            message = f"`{unknown}` is not a fact; there are {', '.join(FACTS)}"
            yield Problem((*here, "left_at", "heading"), message)
        if not (table.questionnaires or table.scores or table.participants or table.left_at):
            message = "this table gives nothing: no questionnaires, scores or participants"
            yield Problem(here, message)
        for index, each in enumerate(table.questionnaires):
            yield from _problems_of(each, (*here, "questionnaires", index))
        for index, scores in enumerate(table.scores):
            yield from _pattern_problems(scores, (*here, "scores", index))


def _fact_problems(table: TableMapping, here: tuple[str | int, ...]) -> Iterator[Problem]:
    """Yield problems of where facts come from."""
    for name in FACTS:
        fact = table.fact(name)
        ways = [fact.column is not None, bool(fact.columns), fact.constant is not None]
        if sum(ways) > 1:
            message = f"`{name}` has more than one of column, columns and constant; keep one"
            yield Problem((*here, name), message)
        if fact.order is not None and (name != "condition" or any(ways)):
            message = "`order` is of conditions, and of those that no column says"
            yield Problem((*here, name, "order"), message)
        if fact.order is not None and not _is_said(table, fact.by):
            message = (
                f"`order` needs the number of each questionnaire, and nothing says `{fact.by}`"
            )
            hint = f"write {fact.by} = {{ count = true }}, or its column"
            yield Problem((*here, name, "order"), f"{message}; {hint}")
        if fact.count and name not in {"participant", "session", "period", "block", "trial"}:
            message = f"`{name}` cannot be counted; trial and session can"
            yield Problem((*here, name, "count"), message)


def _is_said(table: TableMapping, name: str) -> bool:
    """Return whether a column, a count, a heading or a name says a fact."""
    fact = table.fact(name)
    if fact.column or fact.columns or fact.constant or fact.count:
        return True
    sources = (*table.questionnaires, *table.scores)
    texts = [table.file_name, table.sheet_name, *(each.heading for each in sources)]
    patterns = [table.file_pattern, *(each.pattern for each in sources)]
    return (
        any(name in placeholders(text) for text in texts)
        or any(f"(?P<{name}>" in pattern for pattern in patterns)
        or any(name in each.beside or getattr(each, name) is not None for each in sources)
    )


def _problems_of(each: Questionnaire, here: tuple[str | int, ...]) -> Iterator[Problem]:
    if (each.item_column is None) != (each.response_column is None):
        message = "item_column and response_column go together; write both"
        yield Problem(here, message)
    by_name = each.pattern or each.heading != "{item}"
    if each.item_column is not None and by_name:
        yield Problem(here, "a long questionnaire has item_column, and no heading or pattern")
    if each.first_columns and (by_name or each.items or each.item_column is not None):
        message = "with first_columns, items stand in item_order; leave out heading and items"
        yield Problem((*here, "first_columns"), message)
    if each.item_order and not each.first_columns:
        yield Problem((*here, "item_order"), "`item_order` needs first_columns; write them")
    in_heading = TIMES & {*placeholders(each.heading), *re.findall(r"\?P<(\w+)>", each.pattern)}
    if each.summaries and each.time is None and not in_heading:
        yield Problem((*here, "summaries"), "`summaries` are of ratings during exposure; give time")
    yield from _pattern_problems(each, here)


def _pattern_problems(each: _Columns, here: tuple[str | int, ...]) -> Iterator[Problem]:
    blocks = len(each.first_columns) if isinstance(each, Questionnaire) else 0
    for fact in FACTS:
        said = getattr(each, fact)
        if said is not None and (count := len(texts_of(said))) not in {1, blocks or 1}:
            message = f"`{fact}` has {count} texts for {blocks} first_columns"
            yield Problem((*here, fact), f"{message}; give one for each")
    for fact, columns in each.beside.items():
        if len(texts_of(columns)) not in {1, blocks}:
            message = f"`{fact}` has {len(texts_of(columns))} columns for {blocks} questionnaires"
            yield Problem((*here, "beside", fact), f"{message}; name one for each")
        if fact not in FACTS or fact == "participant":
            known = ", ".join(name for name in FACTS if name != "participant")
            yield Problem((*here, "beside", fact), f"`{fact}` is not a fact; there are {known}")
    if each.pattern:
        try:
            names = set(re.compile(each.pattern).groupindex)
        except re.error as error:
            message = f"`pattern` is not a regular expression: {error}"
            yield Problem((*here, "pattern"), message)
            return
    else:
        names = set(placeholders(each.heading))
    if "item" not in names and not names & TIMES:
        key = "pattern" if each.pattern else "heading"
        wanted = "(?P<item>...)" if each.pattern else "{item}"
        yield Problem((*here, key), f"`{key}` needs {wanted}")
    for unknown in sorted(names - {*FACTS, *TIMES, "item", "*"}):
        known = ", ".join(FACTS)
        yield Problem(here, f"`{unknown}` is not a fact; there are item, {known}")


def _expression(text: str, path: tuple[str | int, ...], known: Set[str]) -> Iterator[Problem]:
    """Yield the problem of a text that is not a regular expression with these groups."""
    try:
        names = {*re.compile(text).groupindex}
    except re.error as error:
        yield Problem(path, f"`{path[-1]}` is not a regular expression: {error}")
        return
    for unknown in sorted(names - known):
        yield Problem(path, f"`{unknown}` is not a fact; there are {', '.join(sorted(known))}")


def scale_named(instrument: Instrument, name: str) -> Scale | None:
    """Return a scale by its name, column or title."""
    return next((s for s in instrument.scales if name in {s.name, s.column, s.title}), None)


def texts_of(texts: Texts) -> tuple[str, ...]:
    """Return one text, or several, as several."""
    return (texts,) if isinstance(texts, str) else texts


def matches(name: str, patterns: Iterable[str]) -> bool:
    """Return whether the name of a file or sheet is of one of some patterns."""
    return any(fnmatchcase(name, pattern) for pattern in patterns)


_PLACEHOLDER = re.compile(r"\{(\*|[a-z_]+)\}")


def placeholders(template: str) -> list[str]:
    """Return the names in the braces of a template."""
    return _PLACEHOLDER.findall(template)


def template_pattern(template: str) -> re.Pattern[str]:
    """Return the regular expression that a template means; whole texts are matched with it."""
    parts = _PLACEHOLDER.split(template)
    seen: set[str] = set()
    out = []
    for place, part in enumerate(parts):
        if place % 2 == 0:
            out.append(re.escape(part))
        elif part == "*":
            out.append(".*?")
        elif part in seen:
            out.append(f"(?P={part})")
        else:
            seen.add(part)
            out.append(f"(?P<{part}>.+?)")
    return re.compile("".join(out), re.DOTALL)
