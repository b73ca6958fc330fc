"""Preferences: of two things, one, the other or neither, said in words or chosen when asked."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vrcomfort.errors import InputError
from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    ReportContext,
    Sentence,
    TableColumn,
    interval_heading,
    percent,
)
from vrcomfort.report.families import disagreement, is_shown, verdict_alone
from vrcomfort.report.plan import Entry
from vrcomfort.report.rows import INLINE, cells
from vrcomfort.report.words import NONE, fraction, interval, p_equals
from vrcomfort.settings import Name, Problem, did_you_mean, repeated
from vrcomfort.stats.proportions import Preference, preference

if TYPE_CHECKING:
    from vrcomfort.questionnaire import Sheet
    from vrcomfort.report.families import Verdict
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.effects import EffectSize


class Preferred(Entry):
    """Preferences: for one thing, the other, or neither."""

    name: Name
    column: str = ""
    """Of participants.csv; or `item`."""
    item: str = ""
    """``instrument.item`` of a questionnaire that compares conditions: 1, 2, … are answered for the
    first, the second, … that somebody met, and 0 for none. Who was asked several times counts for
    what they chose more often."""
    label: str = ""
    a: str
    b: str
    """Values of the column, or conditions."""
    none: tuple[str, ...] = ("none",)
    """Values that say that there is no preference; blank cells are missing."""

    @property
    def of_choices(self) -> str:
        """Return the questionnaire of choices, which has no scores."""
        return self.item.partition(".")[0]


@dataclass(frozen=True)
class PreferenceRow:
    """The preferences of one question."""

    name: str
    label: str
    of_a: str
    of_b: str
    n: int
    missing: int
    participants: tuple[str, ...]
    confidence: float
    not_tested: str | None
    found: Preference = field(metadata=INLINE)
    verdict: Verdict | None


def _problems(_: Plan, asked: Sequence[Preferred]) -> Iterator[Problem]:
    yield from repeated(("preferences",), [each.name for each in asked])
    for place, each in enumerate(asked):
        if each.a == each.b or {each.a, each.b} & set(each.none):
            yield Problem(("preferences", place), "a, b and none name one value twice")
        if bool(each.column) == bool(each.item):
            message = "say where it stands: `column` of participants.csv, or `item`, and not both"
            yield Problem(("preferences", place), message)


def _compute(data: AnalysisData, asked: Sequence[Preferred]) -> list[PreferenceRow]:
    return [_row(data, each, place) for place, each in enumerate(asked)]


def _row(data: AnalysisData, asked: Preferred, place: int) -> PreferenceRow:
    said = (_chosen if asked.item else _in_column)(data, asked, place)
    counts = Counter(value for _, value in said if value)
    known = {asked.a, asked.b, *asked.none}
    if unknown := sorted(counts.keys() - known):
        where = f"answers to {asked.item}" if asked.item else _column_in_words(asked)
        message = f"`{unknown[0]}` in {where} is neither a, b nor none; name it, or correct it"
        raise data.plan.fault(message, "preferences", place)
    confidence = data.plan.confidence
    none = sum(counts[value] for value in asked.none)
    found = preference(counts[asked.a], counts[asked.b], none, confidence=confidence)
    preferring = counts[asked.a] + counts[asked.b]
    smallest = preference(preferring, 0, none).p  # were all who prefer anything of one mind
    return PreferenceRow(
        asked.name, asked.label or asked.name, asked.a, asked.b,
        sum(counts.values()), sum(not value for _, value in said),
        tuple(sorted((who for who, value in said if value), key=natural)),
        confidence, None if preferring else "nobody has a preference", found,
        verdict_alone(found.p, smallest, confidence, higher=found.a > found.b),
    )  # fmt: skip


def _column_in_words(asked: Preferred) -> str:
    return f"column `{asked.column}` of participants.csv"


def _in_column(data: AnalysisData, asked: Preferred, place: int) -> list[tuple[str, str]]:
    """Return participant and value of a column, blank where it is missing."""
    people = data.study.participants
    columns = {name for person in people for name in person}
    if asked.column not in columns:
        hint = did_you_mean(asked.column, columns)
        message = f"`{asked.column}` is not a column of participants.csv; {hint}"
        raise data.plan.fault(message, "preferences", place, "column")
    return [
        (person["participant"], person.get(asked.column, "").strip())
        for person in people
        if person["status"] != "excluded"
    ]


def _chosen(data: AnalysisData, asked: Preferred, place: int) -> list[tuple[str, str]]:
    """Return participant and the condition chosen most often, or none."""
    try:
        found = choices_of(data.study, asked.item)
    except InputError as error:
        raise data.plan.fault(str(error), "preferences", place, "item") from error
    excluded = {p["participant"] for p in data.study.participants if p["status"] == "excluded"}
    none = asked.none[0] if asked.none else "none"
    return [
        (who, _most_often(chosen, none)) for who, chosen in found.items() if who not in excluded
    ]


def _most_often(chosen: Sequence[str | None], none: str) -> str:
    """Return the most frequent choice; blank where nothing was said."""
    counts = Counter(none if each is None else each for each in chosen)
    ranked = counts.most_common(2)
    if not ranked:
        return ""
    tied = len(ranked) == 2 and ranked[0][1] == ranked[1][1]
    return none if tied else ranked[0][0]


_Administered = dict[tuple[str, str], list[dict[str, str]]]


def choices_of(study: StudyData, item: str) -> dict[str, list[str | None]]:
    """Return participant → the conditions that they chose, None for no preference.

    Answers 1, 2, … are the first, the second, … way of rendering, as the participant met them: of
    the last exposures where the question is of a trial, else of the session, or (where that has
    not as many) of all sessions until then.

    Parameters
    ----------
    item
        ``instrument.item``.

    Raises
    ------
    InputError
        If there is no such question, or an answer means none of the conditions that were met.
    """
    instrument, _, name = item.partition(".")
    sheets = [s for s in study.sheets if _instrument(s) == instrument and name in s.answers]
    if not sheets:
        asked = {f"{_instrument(s)}.{each}" for s in study.sheets for each in s.answers}
        raise InputError(f"no question `{item}` was answered; {did_you_mean(item, asked)}")
    met: _Administered = defaultdict(list)
    for trial in sorted(study.trials, key=lambda row: natural(row["trial"])):
        met[trial["participant"], trial["session"]].append(trial)
    high = int(study.instruments[instrument].item(name).answers.high)  # type: ignore[union-attr]
    found: dict[str, list[str | None]] = {sheet.participant: [] for sheet in sheets}
    for sheet in sheets:
        answer = sheet.answers[name]
        if answer is None:
            continue
        if answer == 0:
            found[sheet.participant].append(None)
            continue
        conditions = _compared(sheet, met, high)
        if not 1 <= answer <= len(conditions):
            message = f"{sheet.place}: {sheet.participant} chose {answer} of {len(conditions)}"
            raise InputError(f"{message} conditions met until then; trials.csv lacks exposures")
        found[sheet.participant].append(conditions[int(answer) - 1])
    return found


def _instrument(sheet: Sheet) -> str:
    return sheet.keys.get("instrument", "")


def _compared(sheet: Sheet, met: _Administered, high: int) -> list[str]:
    """Return the conditions that answers 1, 2, … mean."""
    trials = met.get((sheet.participant, sheet.session), [])
    if sheet.trial:
        until = [t for t in trials if natural(t["trial"]) <= natural(sheet.trial)]
        return [t["condition"] for t in until[-high:]]
    conditions = list(dict.fromkeys(t["condition"] for t in trials))
    if len(conditions) == high:
        return conditions
    sessions = sorted({s for who, s in met if who == sheet.participant}, key=natural)
    before = [s for s in sessions if natural(s) <= natural(sheet.session)]
    every = [t["condition"] for s in before for t in met[sheet.participant, s]]
    return list(dict.fromkeys(every))


def _sentences(row: PreferenceRow, _: Vocabulary) -> Iterator[Sentence]:
    a, b, found = row.of_a, row.of_b, row.found
    counts = f"{a} {found.a}, {b} {found.b}, no preference {found.none} of {row.n}"
    share = found.share_of_a
    if row.not_tested or share is None:
        yield Sentence(f"{row.label}: nobody preferred either ({counts}).")
        return
    if row.verdict == "not_possible":
        said = f"with so few who preferred either, no preference for {a} or {b} could be shown"
    elif not is_shown(row.verdict):
        said = f"no preference for {a} or {b} was shown"
    else:
        said = f"more preferred {a if row.verdict == 'higher' else b}"
    yield Sentence(
        f"{row.label}: {said} ({counts}).",
        f"Sign test without those who had none: {p_equals(found.p)}; share of {a}\u00a0=\u00a0"
        f"{fraction(share.estimate)}, {100 * row.confidence:g}\u00a0% CI "
        f"{interval(share, bounded=True, null=0.5)}{disagreement(row.verdict, share, 0.5)}.",
    )


def _methods(rows: Sequence[PreferenceRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    if rows:
        yield MethodsParagraph(
            "Preferences",
            "Preferences were counted in three classes; shares have Wilson’s (1927) intervals. The "
            "sign test and the share among those with a preference (Clopper & Pearson, 1934) leave "
            "out who had none.",
            ("wilson_1927", "clopper_1934"),
        )


def _csv(row: PreferenceRow) -> Iterator[Cells]:
    share = row.found.share_of_a
    yield cells(row, ("participants", "shares")) | {
        "share_of_a": share and share.estimate,
        "share_of_a_low": share and share.low,
        "share_of_a_high": share and share.high,
    }


@dataclass(frozen=True)
class _Share:
    question: str
    answer: str
    people: int
    of_all: EffectSize | None


def _shares(row: PreferenceRow) -> list[_Share]:
    """Return the lines of a question: those for a, for b, and without a preference."""
    found = row.found
    return [
        _Share(row.label, row.of_a, found.a, found.shares[0]),
        _Share("", row.of_b, found.b, found.shares[1]),
        _Share("", "no preference", found.none, found.shares[2]),
    ]


_Column = TableColumn[_Share]
_TABLE: AnalysisTable[PreferenceRow, _Share] = AnalysisTable(
    "preferences",
    lambda _, report: (
        "Preferences: people, and their share of all with its "
        f"{percent(report.plan.confidence)} interval (Wilson)"
    ),
    (
        _Column("Question", lambda share, _: share.question),
        _Column("Answer", lambda share, _: share.answer, of_words=True),
        _Column("people", lambda share, _: str(share.people)),
        _Column("share", lambda s, _: fraction(s.of_all.estimate) if s.of_all else NONE),
        _Column(interval_heading, lambda share, _: interval(share.of_all, bounded=True)),
    ),
    lines=_shares,
    csv=_csv,
)

PREFERENCES = Analysis(
    "preferences",
    AnalysisSet.ALL_AVAILABLE,
    _compute,
    asked=Preferred,
    problems=_problems,
    tables=(_TABLE,),
    place=30,
    order=40,
    sentences=_sentences,
    methods=_methods,
    analysed=lambda rows: [row.participants for row in rows],
)
