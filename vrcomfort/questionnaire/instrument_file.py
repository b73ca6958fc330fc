"""Reads an instrument from TOML; every fault is one sentence with file, line and column."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from vrcomfort.errors import InputError
from vrcomfort.files import read_text
from vrcomfort.questionnaire.answers import Answer, Answers, exact
from vrcomfort.questionnaire.instruments import Instrument, Item, Translation, Wording, plain
from vrcomfort.questionnaire.scale_file import (
    Compiled,
    ScaleTable,
    compile_scale,
    of_one_item,
    scale_problems,
)
from vrcomfort.questionnaire.scales import Scale
from vrcomfort.settings import (
    KeyPath,
    Problem,
    Settings,
    Word,
    did_you_mean,
    first_problem,
    parse_settings,
    repeated,
    reserved,
    to_toml,
)

Language = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]
_MOST = 1e12
Bound = Annotated[float, Field(ge=-_MOST, le=_MOST)]
Step = Annotated[float, Field(gt=0, le=_MOST)]

Refusal = Callable[[Iterable[Problem]], InputError]
"""Makes the error of problems, with the place where they stand."""

TAKEN = frozenset(
    ["participant", "session", "period", "trial", "position", "sequence", "timepoint", "condition",
     "scene", "early", "item", "response", "instrument", "score"]
)  # fmt: skip
"""Columns of our tables, which no item and no scale may be called."""


class AnswersTable(Settings):
    """The possible answers."""

    low: Bound
    high: Bound
    step: Step = 1.0
    asked_step: Step | None = None
    """What two neighbours on the form are apart; `step` without it. Files may be finer."""
    labels: tuple[str, ...] = ()
    """Names of all answers, or of the two ends."""


class ItemTable(Settings):
    """An `[[items]]` table."""

    name: Word
    text: str = ""
    """As it is asked; the lab's to give where the name stands alone."""
    aliases: tuple[str, ...] = ()
    reversed: bool = False
    asked: bool = True
    answers: AnswersTable | None = None
    """Where they are other ones than the instrument's."""


class WordingTable(Settings):
    """An item in another language."""

    text: str
    """As it is asked."""
    aliases: tuple[str, ...] = ()
    """Other headings of its column in files."""


def _worded(given: Any) -> Any:
    """Return a text alone as the table that it stands for."""
    return {"text": given} if isinstance(given, str) else given


class TranslationTable(Settings):
    """The instrument in another language: `[translations.de]`."""

    instruction: str | None = None
    """As it is asked; without it, the words below only find columns and answers in files."""
    labels: tuple[str, ...] = ()
    """Names of the answers, as many as in the file's own language."""
    source: str = ""
    """Whose wording it is; recorded."""
    items: dict[
        str,
        Annotated[
            WordingTable, BeforeValidator(_worded, json_schema_input_type=WordingTable | str)
        ],
    ] = Field(default_factory=dict)
    """Item → its text, or its text and aliases."""


class InstrumentTable(Settings):
    """A whole file; see ``docs/instruments.md``."""

    name: Word
    short: str = ""
    title: str
    instruction: str = ""
    language: Language = "en"
    citation: str = ""
    sources: tuple[str, ...] = ()
    rule: str = ""
    asks: Literal["symptoms", "questions"] = "questions"
    licence: str = ""
    variant_of: str = ""
    prefixed: bool = True
    primary: str | None = None
    answers: AnswersTable
    items: Annotated[tuple[ItemTable, ...], Field(min_length=1)]
    scales: tuple[ScaleTable, ...] = ()
    translations: dict[str, TranslationTable] = Field(default_factory=dict)


def read_instrument(file: Path) -> Instrument:
    """Read an instrument's file.

    Raises
    ------
    InputError
        If it is no TOML, or a key or value is wrong, with line and column.
    """
    return parse_instrument(read_text(file, "instrument"), file)


def parse_instrument(text: str, file: Path | None = None) -> Instrument:
    """Return the instrument that is written in `text`; see `read_instrument`."""
    table = parse_settings(InstrumentTable, text, file)
    return instrument_of(table, text, lambda found: first_problem(found, text, file))


def instrument_in(table: InstrumentTable, refuse: Refusal) -> Instrument:
    """Return the instrument that a table of another file declares; see `instrument_of`."""
    text = to_toml(table.model_dump(mode="json", exclude_unset=True))
    return instrument_of(table, text, refuse)


def instrument_of(table: InstrumentTable, text: str, refuse: Refusal) -> Instrument:
    """Return the instrument of a table and the text of its file; `refuse` makes the error."""
    if found := list(_problems(table)):
        raise refuse(found)
    items = {each.name: _item(each, table) for each in table.items}
    if found := list(_between(table, items)):
        raise refuse(found)
    scales = _scales(table, items)
    return Instrument(
        name=table.name,
        short=table.short or table.name.replace("_", " ").upper(),
        title=table.title,
        instruction=table.instruction or table.title,
        items=tuple(items.values()),
        answers=_answers(table.answers, table),
        scales=scales,
        primary=table.primary or scales[0].name,
        citation=table.citation,
        sources=table.sources,
        rule=table.rule,
        asks=table.asks,
        licence=table.licence,
        language=table.language,
        variant_of=table.variant_of,
        prefixed=table.prefixed,
        translations={
            language: Translation(each.instruction, each.labels, each.source)
            for language, each in table.translations.items()
        },
        text=text,
    )


def short_form(instrument: Instrument, not_asked: Collection[str]) -> Instrument:
    """Return the instrument of a study that left out items by design.

    A scale that allows for missing items (`min_valid`) is scored as ever where enough were asked.
    One that needs all its items is made of those that were asked, and called so: it is another
    scale. One of which nothing was asked, or whose items weigh differently for each person, has no
    score, and neither has a scale made of it.
    """
    lost = tuple(item.name for item in instrument.items if item.name in not_asked)
    if not lost:
        return instrument
    table = parse_settings(InstrumentTable, instrument.text, None)
    items = {
        each.name: replace(each, asked=each.asked and each.name not in lost)
        for each in instrument.items
    }
    made: dict[str, Compiled] = {}
    unscored: dict[str, str] = {}
    short: set[str] = set()
    for each in table.scales:
        kept = {name: weight for name, weight in each.items.items() if name not in lost}
        if reason := _unscored(each, kept, frozenset(lost), unscored):
            unscored[each.name] = reason
            made[each.name] = compile_scale(each, items, made)
            continue
        whole = each.min_valid is not None and each.min_valid < len(each.items)
        if (len(kept) < len(each.items) and not whole) or short & _parts(each):
            short.add(each.name)
        now = each if whole else each.model_copy(update={"items": kept, "min_valid": None})
        made[each.name] = compile_scale(now, items, made)
    alone = [of_one_item(items[name]) for name in _alone(table)]
    unscored |= {each.name: "it was not asked" for each in alone if each.name in lost}
    scales = [
        replace(each.scale, title=f"{each.scale.title} (short form)") if name in short
        else each.scale
        for name, each in made.items()
    ]  # fmt: skip
    return replace(
        instrument,
        title=f"{instrument.title} (short form)",
        items=tuple(items.values()),
        scales=(*scales, *alone),
        rule=_rule_of_short_form(instrument, lost, short),
        not_asked=lost,
        shortened=tuple(name for name in made if name in short),
        unscored=unscored,
    )


def _parts(scale: ScaleTable) -> set[str]:
    return {*scale.raw_sums_of, *scale.scores_of}


def _unscored(
    scale: ScaleTable, kept: Mapping[str, float], lost: frozenset[str], before: Mapping[str, str]
) -> str:
    """Say why a scale has no score with the items that were asked; nothing where it has one."""
    if missing := sorted(_parts(scale) & before.keys()):
        return f"it is made of {missing[0]}, which has none"
    asked, count = len(kept), len(scale.items)
    if asked == count and not lost.intersection(scale.weighted_by.values()):
        return ""
    if not asked:
        return "none of its items was asked"
    if scale.weighted_by:
        return "it needs every item and the weight of each"
    needed = scale.min_valid or 0
    return f"{asked} of its {count} items were asked, and {needed} needed" if asked < needed else ""


def _rule_of_short_form(instrument: Instrument, lost: tuple[str, ...], short: set[str]) -> str:
    said = f"without {', '.join(lost)}, which {'were' if len(lost) > 1 else 'was'} not asked"
    if not short:
        return f"{instrument.rule}, {said}" if instrument.rule else said
    other = "sums of a short form are on another scale than those of the whole questionnaire"
    return f"{instrument.rule or 'from the items that were asked'}, {said}; {other}"


def _answers(given: AnswersTable, table: InstrumentTable) -> Answers:
    shared = given is table.answers
    return Answers(
        low=_whole(given.low),
        high=_whole(given.high),
        step=_whole(given.step),
        asked_step=_whole(given.step if given.asked_step is None else given.asked_step),
        labels=given.labels,
        more_labels=tuple(
            each.labels for each in table.translations.values() if shared and each.labels
        ),
    )


def _whole(number: float) -> Answer:
    return int(number) if float(number).is_integer() else number


def _item(each: ItemTable, table: InstrumentTable) -> Item:
    wordings = []
    for language, translation in table.translations.items():
        words = translation.items.get(each.name)
        if words is not None:
            wordings.append(Wording(language, words.text, words.aliases))
    return Item(
        name=each.name,
        text=each.text or each.name.replace("_", " "),
        answers=_answers(each.answers or table.answers, table),
        aliases=each.aliases,
        reversed=each.reversed,
        asked=each.asked,
        wordings=tuple(wordings),
        worded=bool(each.text),
    )


def _scales(table: InstrumentTable, items: Mapping[str, Item]) -> tuple[Scale, ...]:
    """Return the scales of the file, and one for each item that none of them counts."""
    made: dict[str, Compiled] = {}
    for each in table.scales:
        made[each.name] = compile_scale(each, items, made)
    alone = [of_one_item(items[name]) for name in _alone(table)]
    return (*(compiled.scale for compiled in made.values()), *alone)


def _alone(table: InstrumentTable) -> list[str]:
    counted = {name for scale in table.scales for name in scale.items}
    counted |= {name for scale in table.scales for name in scale.weighted_by.values()}
    return [item.name for item in table.items if item.name not in counted]


def _problems(table: InstrumentTable) -> Iterator[Problem]:
    """Yield problems between keys, which types cannot express."""
    yield from reserved(("name",), table.name)
    yield from repeated(("items",), [item.name for item in table.items])
    yield from repeated(("scales",), [scale.name for scale in table.scales])
    yield from _range_problems(("answers",), table.answers)
    for index, item in enumerate(table.items):
        place: KeyPath = ("items", index)
        if item.name in TAKEN:
            yield Problem((*place, "name"), _taken("an item", item.name))
        if item.answers is not None:
            yield from _range_problems((*place, "answers"), item.answers)
    names = [item.name for item in table.items]
    for language, each in table.translations.items():
        path: KeyPath = ("translations", language)
        for name in each.items:
            if name not in names:
                hint = did_you_mean(name, names)
                yield Problem((*path, "items", name), f"there is no item `{name}`; {hint}")
        if each.labels and len(each.labels) != len(table.answers.labels):
            message = f"{len(each.labels)} labels, but {len(table.answers.labels)} in"
            yield Problem((*path, "labels"), f"{message} `{table.language}`; give as many")


def _taken(what: str, name: str) -> str:
    return f"{what} cannot be called `{name}`: a column of tables is; choose another name"


def _range_problems(path: KeyPath, answers: AnswersTable) -> Iterator[Problem]:
    low, high, step = exact(answers.low), exact(answers.high), exact(answers.step)
    if low >= high:
        message = f"the lowest answer, {float(low):g}, is not below the highest, {float(high):g}"
        yield Problem((*path, "high"), f"{message}; exchange or correct them")
        return
    asked = step if answers.asked_step is None else exact(answers.asked_step)
    for name, size in (("step", step), ("asked_step", asked)):
        if ((high - low) / size).denominator != 1:
            message = f"steps of {float(size):g} do not lead from {float(low):g} to {float(high):g}"
            yield Problem((*path, name), f"{message}; give a step that does")
            return
    if (asked / step).denominator != 1:
        message = "the form's answers are not all possible answers; give a multiple of `step`"
        yield Problem((*path, "asked_step"), message)
    count = int((high - low) / asked) + 1
    if len(answers.labels) not in {0, 2, count}:
        message = f"{len(answers.labels)} labels for {count} answers"
        yield Problem((*path, "labels"), f"{message}; name all of them, or the two ends")


def _between(table: InstrumentTable, items: Mapping[str, Item]) -> Iterator[Problem]:
    """Yield problems between items and scales."""
    yield from _same_headings(items)
    before: list[str] = []
    columns: list[str] = []
    for index, scale in enumerate(table.scales):
        path: KeyPath = ("scales", index)
        if scale.name in TAKEN:
            yield Problem((*path, "name"), _taken("a scale", scale.name))
        if scale.name in items:
            message = f"a scale has the name of the item `{scale.name}`; call it otherwise"
            yield Problem((*path, "name"), message)
        yield from scale_problems(path, scale, items, before)
        before.append(scale.name)
        columns.append(scale.column or scale.name.lower())
    yield from repeated(("scales",), columns)
    known = [*before, *_alone(table)]
    if table.primary is not None and table.primary not in known:
        hint = did_you_mean(table.primary, known)
        yield Problem(("primary",), f"there is no scale `{table.primary}`; {hint}")


def _same_headings(items: Mapping[str, Item]) -> Iterator[Problem]:
    """Yield items that share a spelling: a column of that name would mean both."""
    owners: dict[str, str] = {}
    for index, item in enumerate(items.values()):
        for word in item.spellings():
            if not plain(word):
                message = f"`{word}` has no letter or digit; a heading needs one"
                yield Problem(("items", index), message)
                continue
            other = owners.setdefault(plain(word), item.name)
            if other != item.name:
                message = f"`{word}` means item {other} and item {item.name}"
                yield Problem(("items", index), f"{message}; leave it to one")
                return
