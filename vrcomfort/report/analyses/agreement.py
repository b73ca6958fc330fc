"""Agreement of repeated exposures of the same people: intraclass correlations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Literal

from markupsafe import Markup

from vrcomfort.errors import InputError
from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    ReportContext,
    TableColumn,
    estimable,
    interval_heading,
    percent,
    unknown_outcome,
)
from vrcomfort.report.factors import points
from vrcomfort.report.pairs import with_every_score
from vrcomfort.report.plan import Entry
from vrcomfort.report.rows import INLINE
from vrcomfort.report.words import fraction, interval
from vrcomfort.settings import Problem
from vrcomfort.stats.correlation import Intraclass, intraclass

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary


class Agreed(Entry):
    """How far repeated exposures of the same people agree."""

    outcome: str
    over: Literal["session", "position", "scene", "part", "condition"] = "session"
    condition: str = ""
    """Of which exposures; blank: of all."""


@dataclass(frozen=True)
class AgreementFound:
    """The six forms of the intraclass correlation."""

    n: int
    participants: tuple[str, ...]
    occasions: int
    forms: tuple[Intraclass, ...]


@dataclass(frozen=True)
class AgreementRow:
    """The agreement of one outcome over occasions."""

    over: str
    condition: str
    outcome: str
    not_tested: str | None
    found: AgreementFound | None = field(metadata=INLINE)


def _problems(plan: Plan, asked: Sequence[Agreed]) -> Iterator[Problem]:
    for place, each in enumerate(asked):
        yield from unknown_outcome(plan, each.outcome, "agreement", place, "outcome")


def _compute(data: AnalysisData, asked: Sequence[Agreed]) -> list[AgreementRow]:
    return [_row(data, each) for each in asked if data.has(each.outcome)]


def _row(data: AnalysisData, asked: Agreed) -> AgreementRow:
    why_not, found = estimable(lambda: _found(data, asked))
    return AgreementRow(asked.over, asked.condition, asked.outcome, why_not, found)


def _found(data: AnalysisData, asked: Agreed) -> AgreementFound:
    rows = points(data.scored.table, data.scored, asked.outcome)
    rows = rows[rows["condition"] == asked.condition] if asked.condition else rows
    if data.complete:
        rows = with_every_score(rows, [asked.over])
    wide = rows.pivot_table(index="participant", columns=asked.over, values="score").dropna()
    people, occasions = wide.shape
    if people < 2 or occasions < 2:
        raise InputError(f"{people} people with a score in each of {occasions} occasions: too few")
    forms = intraclass(wide.to_numpy(dtype=float), confidence=data.plan.confidence)
    return AgreementFound(people, tuple(sorted(wide.index, key=natural)), occasions, forms)


def _methods(rows: Sequence[AgreementRow], _: ReportContext) -> Iterator[MethodsParagraph]:
    if any(row.found for row in rows):
        yield MethodsParagraph(
            "Agreement",
            "Intraclass correlations are those of Shrout & Fleiss (1979), of people with a score "
            "on every occasion: (2,1) counts differences between occasions as error, (3,1) does "
            "not.",
            ("shrout_1979",),
        )


def _csv(row: AgreementRow) -> Iterator[Cells]:
    keys = {
        "outcome": row.outcome, "over": row.over, "condition": row.condition,
        "not_tested": row.not_tested,
    }  # fmt: skip
    if row.found is None:
        yield keys
        return
    sizes = {"n": row.found.n, "people_in_it": list(row.found.participants)}
    for form in row.found.forms:
        yield {**keys, **sizes, **asdict(form)}


def _over(row: AgreementRow, words: Vocabulary) -> str:
    return f"{row.over}, {words.condition(row.condition)}" if row.condition else row.over


def _form(place: int, write: Callable[[Intraclass], str]) -> Callable[[AgreementRow, object], str]:
    """Return the writer of a cell on one of the six forms, in the order of `intraclass`."""
    return lambda row, _: write(row.found.forms[place]) if row.found else ""


def _estimate(form: Intraclass) -> str:
    return fraction(form.estimate)


def _interval(form: Intraclass) -> str:
    return interval(form, bounded=True)


def _size(row: AgreementRow, _: Vocabulary) -> str:
    return f"{row.found.n} × {row.found.occasions}" if row.found else ""


_Column = TableColumn[AgreementRow]
_TABLE: AnalysisTable[AgreementRow, AgreementRow] = AnalysisTable(
    "agreement",
    lambda _, report: (
        "Agreement of repeated exposures: intraclass correlations with their "
        f"{percent(report.plan.confidence)} intervals"
    ),
    (
        _Column("Outcome", lambda row, words: words.outcome(row.outcome)),
        _Column("Over", _over, of_words=True),
        _Column(Markup("<i>n</i> × occasions"), _size),
        _Column("agreement (2,1)", _form(1, _estimate)),
        _Column(interval_heading, _form(1, _interval)),
        _Column("consistency (3,1)", _form(2, _estimate)),
        _Column(interval_heading, _form(2, _interval)),
        _Column("of the mean (2,k)", _form(4, _estimate)),
    ),
    spanning=lambda row: row.not_tested,
    labels=2,
    csv=_csv,
)

_R_LINES = r"""
# Intraclass correlations of people with a score on every occasion, from the mean squares.
found <- read_if_there("agreement")
for (one in if (is.null(found)) list() else split(found, paste(found$outcome, found$over))) {
  if (!one$over[1] %in% names(scores)) next
  mine <- is.na(one$condition[1]) | scores$condition %in% one$condition[1]
  mine <- mine & !is.na(scores[[one$outcome[1]]])
  wide <- tapply(as.numeric(scores[[one$outcome[1]]][mine]),
                 list(scores$participant[mine], scores[[one$over[1]]][mine]), mean)
  wide <- wide[rownames(wide) %in% names_in(one$people_in_it[1]), , drop = FALSE]
  n <- nrow(wide); k <- ncol(wide)
  people <- k * var(rowMeans(wide)); occasions <- n * var(colMeans(wide))
  rest <- wide - outer(rowMeans(wide), colMeans(wide), "+") + mean(wide)
  error <- sum(rest^2) / ((n - 1) * (k - 1))
  agreement <- (people - error) / (people + (k - 1) * error + k * (occasions - error) / n)
  consistency <- (people - error) / (people + (k - 1) * error)
  about <- paste("agreement over", one$over[1])
  compare(one[2, ], "ICC(2,1)", one$estimate[2], agreement, about, size = 1e-6)
  compare(one[3, ], "ICC(3,1)", one$estimate[3], consistency, about, size = 1e-6)
  others <- others + 1
}
"""

AGREEMENT = Analysis(
    "agreement",
    AnalysisSet.COMPLETE_CASES,
    _compute,
    asked=Agreed,
    about="Intraclass correlations.",
    problems=_problems,
    tables=(_TABLE,),
    place=70,
    order=50,
    methods=_methods,
    r_lines=_R_LINES,
)
