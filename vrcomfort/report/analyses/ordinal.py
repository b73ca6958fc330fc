"""Cumulative logit models of single items."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Annotated, NamedTuple

from markupsafe import Markup
from pydantic import Field

from vrcomfort.errors import InputError
from vrcomfort.report.analyses.contract import (
    ITALIC_P,
    ITALIC_SE,
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    ReportContext,
    Sentence,
    TableColumn,
    estimable,
    html,
    interval_heading,
    p_in_html,
)
from vrcomfort.report.exposures import column_of
from vrcomfort.report.factors import check_column
from vrcomfort.report.plan import Entry
from vrcomfort.report.rows import INLINE
from vrcomfort.report.words import NONE, degrees, interval, number, p_equals, p_value
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.ordinal import OrdinalModel, ordinal_model
from vrcomfort.stats.ranks import level_of

if TYPE_CHECKING:
    import pandas as pd

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.rows import Cells
    from vrcomfort.report.vocabulary import Vocabulary
    from vrcomfort.stats.ordinal import LikelihoodRatio, OddsRatio, Proportionality

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
        shown = odds.p <= level_of(confidence)
        said = ("higher" if odds.estimate > 0 else "lower") if shown else "no difference shown"
        ends = interval(_Ends(odds.odds_low, odds.odds_high), null=1.0)
        yield Sentence(
            f"{title}, {words.term(term)}: {said}; odds ratio of a higher answer\u00a0=\u00a0"
            f"{number(odds.odds_ratio)}, {100 * confidence:g}\u00a0% CI {ends}, {n}.",
            f"{model}: z\u00a0=\u00a0{number(odds.z)}, {p_equals(odds.p)}.",
        )


def _methods(rows: Sequence[OrdinalRow], _: ReportContext) -> Iterator[MethodsParagraph]:
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


def _title(row: OrdinalRow, _: Sequence[OrdinalRow], report: ReportContext) -> str:
    title = row.title(report.words)
    if row.found is None:
        return f"{title}: {row.not_tested}"
    model = row.found.model
    between = ""
    if model.participant_sd is not None:
        between = f"; SD between people {number(model.participant_sd)} (log odds)"
    return f"{title}: {model.n_values} answers of {model.n_participants} people{between}"


@dataclass(frozen=True)
class _Line:
    """A line on a term; or, where `of_factor` stands, on its factor as a whole."""

    term: str
    odds: OddsRatio | None
    ratios: str
    of_factor: Markup | None = None


def _lines(row: OrdinalRow) -> Iterator[_Line]:
    if row.found is None:
        return
    model = row.found.model
    for term, odds in model.terms.items():
        check = model.proportional.get(term.split(": ")[0])
        ratios = zip(model.answers, check.cuts[term], strict=False) if check else ()
        above = ", ".join(f"{degrees(answer)}: {number(ratio)}" for answer, ratio in ratios)
        yield _Line(term, odds, above if check else NONE)
    for factor, test in model.omnibus.items():
        yield _Line("", None, "", _whole(factor, test, model.proportional.get(factor)))


def _whole(factor: str, test: LikelihoodRatio, check: Proportionality | None) -> Markup:
    said = html("{} as a whole: {}.", factor, _ratio_test(test))
    if check is None:
        return said
    if check.test is None:
        return said + html(" One ratio for all answers: not tested ({}).", check.reason)
    together = [f"{' and '.join(map(degrees, part))} taken together" for part in check.together]
    merged = f"; {', '.join(together)}" if together else ""
    return said + html(" One ratio for all answers: {}{}.", _ratio_test(check.test), merged)


def _ratio_test(test: LikelihoodRatio) -> Markup:
    chi_squared = number(test.chi_squared)
    return html("χ²({}) = {}, {}", str(test.df), chi_squared, p_in_html(test.p))


def _of(write: Callable[[OddsRatio], str]) -> Callable[[_Line, object], str]:
    return lambda line, _: write(line.odds) if line.odds else ""


def _ends(odds: OddsRatio) -> str:
    return f"[{number(odds.odds_low)}, {number(odds.odds_high)}]"


_Column = TableColumn[_Line]
_TABLE: AnalysisTable[OrdinalRow, _Line] = AnalysisTable(
    "ordinal",
    "Single items: odds ratios of a higher answer, by cumulative logit models",
    (
        _Column("Term", lambda line, words: words.term(line.term), of_words=True),
        _Column("odds ratio", _of(lambda odds: number(odds.odds_ratio))),
        _Column(interval_heading, _of(_ends)),
        _Column("log odds", _of(lambda odds: number(odds.estimate))),
        _Column(ITALIC_SE, _of(lambda odds: number(odds.standard_error))),
        _Column(Markup("<i>z</i>"), _of(lambda odds: number(odds.z))),
        _Column(ITALIC_P, _of(lambda odds: p_value(odds.p))),
        _Column("ratios above each answer", lambda line, _: line.ratios, of_words=True),
    ),
    lines=_lines,
    spanning=lambda line: line.of_factor,
    labels=0,
    group=_title,
    note=lambda _rows, _report: html(
        "A ratio above 1: higher answers are more likely under the first level. Small p of “one "
        "ratio for all answers”: the ratio differs between answers, see those above each "
        "(<code>tables/ordinal_by_cut.csv</code>; – where one side has no answer there)."
    ),
    csv=_csv,
)

ORDINAL = Analysis(
    "ordinal",
    AnalysisSet.ALL_AVAILABLE,
    _compute,
    asked=Ordinal,
    about="Cumulative logit models of items.",
    tables=(_TABLE, AnalysisTable("ordinal_by_cut", csv=_csv_by_cut)),
    place=50,
    order=70,
    sentences=_sentences,
    methods=_methods,
)
