"""Cumulative logit models of single items."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import Field

from vrcomfort.errors import InputError
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    Sentence,
    estimable,
)
from vrcomfort.report.exposures import column_of
from vrcomfort.report.factors import check_column
from vrcomfort.report.plan import Entry
from vrcomfort.report.rows import INLINE
from vrcomfort.report.words import interval, number, p_equals
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.ordinal import OrdinalModel, ordinal_model

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary

MOST_ANSWERS = 21
"""More different ones are no ordered answers any more, and take a threshold each."""


class Ordinal(Entry):
    """A single item, or another ordinal outcome."""

    outcome: str
    """An item of a questionnaire, or an outcome of the plan."""
    factors: Annotated[tuple[str, ...], Field(min_length=1)] = ("condition",)
    """Columns as in the mixed model."""


@dataclass(frozen=True)
class OrdinalFound:
    """A fitted model."""

    model: OrdinalModel = field(metadata=INLINE)
    confidence: float
    participants: tuple[str, ...]


@dataclass(frozen=True)
class OrdinalRow:
    """A model of one item; instrument and item are blank where it is of an outcome."""

    instrument: str
    item: str
    factors: tuple[str, ...]
    outcome: str
    not_tested: str | None
    found: OrdinalFound | None = field(metadata=INLINE)

    def title(self, words: Vocabulary) -> str:
        """Return the question's wording, or the outcome's title."""
        if self.item:
            return words.item(self.instrument, self.item)
        return words.outcome(self.outcome)


def _compute(data: AnalysisData, asked: Sequence[Ordinal]) -> list[OrdinalRow]:
    """Fit a model for each entry.

    Raises
    ------
    InputError
        If the plan names neither an outcome nor an item of one, or a column that is not there,
        with its place.
    """
    for place, each in enumerate(asked):
        for number_of_factor, name in enumerate(each.factors):
            check_column(
                data.plan, data.scored, name, "ordinal", place, "factors", number_of_factor
            )
    return [_row(data, each, place) for place, each in enumerate(asked)]


def _row(data: AnalysisData, asked: Ordinal, place: int) -> OrdinalRow:
    scored = data.scored
    known = [*scored.items, *(each.name for each in scored.outcomes)]
    if asked.outcome not in (*known, *scored.absent):
        message = (
            f"`{asked.outcome}` is neither an outcome of the plan nor an item of their "
            f"questionnaires; {did_you_mean(asked.outcome, known)}"
        )
        raise data.plan.fault(message, "ordinal", place, "outcome")
    instrument, item = scored.items.get(asked.outcome, ("", ""))
    why_not, found = estimable(lambda: _fitted(data, asked))
    return OrdinalRow(instrument, item, asked.factors, asked.outcome, why_not, found)


def _fitted(data: AnalysisData, asked: Ordinal) -> OrdinalFound:
    scored, confidence = data.scored, data.plan.confidence
    if asked.outcome in scored.absent:
        raise InputError("the data do not have it")
    unit = 1.0 if asked.outcome in scored.items else scored.units[asked.outcome]
    rows = scored.table.dropna(subset=[asked.outcome])
    rows = rows.assign(answer=rows[asked.outcome].astype(float) * unit)
    if rows["answer"].nunique() > MOST_ANSWERS:
        raise InputError(
            f"it takes {rows['answer'].nunique()} different values; ordinal models are of at most "
            f"{MOST_ANSWERS}"
        )
    rows = rows.assign(**{name: _levels(scored, rows, name) for name in asked.factors})
    model = ordinal_model(
        rows,
        value="answer",
        participant="participant",
        factors=asked.factors,
        references={"condition": data.reference},
        confidence=confidence,
    )
    people = sorted(rows.dropna(subset=list(asked.factors))["participant"].unique())
    return OrdinalFound(model, confidence, tuple(people))


def _levels(scored: Exposures, rows: pd.DataFrame, name: str) -> pd.Series:
    return column_of(scored, rows, name).map(str, na_action="ignore")


class _Ends(NamedTuple):
    low: float
    high: float


def _sentences(row: OrdinalRow, words: Vocabulary) -> Iterator[Sentence]:
    """Yield a sentence for each odds ratio."""
    title = row.title(words)
    if row.found is None:
        yield Sentence(f"{title}: no ordinal model ({row.not_tested}).")
        return
    fit, confidence = row.found.model, row.found.confidence
    n = f"{fit.n_values} answers of {fit.n_participants} people"
    model = "Cumulative logit model"
    model += " with a random intercept" if fit.participant_sd is not None else ""
    for term, odds in fit.terms.items():
        shown = odds.p <= 1 - confidence
        said = ("higher" if odds.estimate > 0 else "lower") if shown else "no difference shown"
        ends = interval(_Ends(odds.odds_low, odds.odds_high), null=1.0)
        yield Sentence(
            f"{title}, {words.term(term)}: {said}; odds ratio of a higher answer\u00a0=\u00a0"
            f"{number(odds.odds_ratio)}, {100 * confidence:g}\u00a0% CI {ends}, {n}.",
            f"{model}: z\u00a0=\u00a0{number(odds.z)}, {p_equals(odds.p)}.",
        )


def _methods(rows: Sequence[OrdinalRow]) -> Iterator[MethodsParagraph]:
    made = [row.found.model for row in rows if row.found]
    if not made:
        return
    random = any(model.participant_sd is not None for model in made)
    repeats = (
        " As people answered more than once, they have a random intercept (Hedeker & Gibbons, "
        "1994), integrated by adaptive Gauss–Hermite quadrature with 25 nodes."
    )
    yield MethodsParagraph(
        "Single items",
        "Single items were analysed by cumulative logit models (McCullagh, 1980), which take the "
        "order of answers alone: an odds ratio above 1 makes every higher answer more likely. p "
        "and interval are Wald’s, factors as a whole have likelihood-ratio tests; nothing is "
        f"adjusted.{repeats * random} That one ratio stands for all cuts between answers was "
        "tested against a model with a ratio for each; where answers were not given under every "
        "level, neighbours were taken together for it.",
        ("mccullagh_1980", *(("hedeker_1994",) if random else ())),
    )


def _csv(row: OrdinalRow) -> Iterator[Cells]:
    """Yield the odds ratios of a model, one line each."""
    keys = {
        "outcome": row.outcome, "instrument": row.instrument, "item": row.item,
        "not_tested": row.not_tested,
    }  # fmt: skip
    if row.found is None:
        yield keys
        return
    fit = row.found.model
    sizes = {"n_values": fit.n_values, "n_participants": fit.n_participants}
    for term, odds in fit.terms.items():
        yield {**keys, **sizes, "term": term, **asdict(odds), "participant_sd": fit.participant_sd}


def _csv_by_cut(row: OrdinalRow) -> Iterator[Cells]:
    """Yield the odds ratio of answers above each cut, of each term."""
    if row.found is None:
        return
    answers = row.found.model.answers
    for check in row.found.model.proportional.values():
        for term, ratios in check.cuts.items():
            for answer, ratio in zip(answers[:-1], ratios, strict=True):
                yield {"outcome": row.outcome, "term": term, "above": answer, "odds_ratio": ratio}


ORDINAL: Analysis[OrdinalRow] = Analysis(
    "ordinal",
    AnalysisSet.ALL_AVAILABLE,
    _compute,
    asked=Ordinal,
    about="Cumulative logit models of items.",
    tables=(
        AnalysisTable("ordinal", template="report/ordinal.html.j2", csv=_csv),
        AnalysisTable("ordinal_by_cut", csv=_csv_by_cut),
    ),
    place=50,
    sentences=_sentences,
    methods=_methods,
)
