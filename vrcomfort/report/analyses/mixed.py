"""Linear mixed models of every scored exposure, with marginal means."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

import pandas as pd

from vrcomfort.errors import InputError
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    estimable,
)
from vrcomfort.report.exposures import column_of
from vrcomfort.report.factors import points
from vrcomfort.report.rows import INLINE
from vrcomfort.stats.mixed import MixedModel, mixed_model

if TYPE_CHECKING:
    from vrcomfort.report.rows import Cells


@dataclass(frozen=True)
class MixedFit:
    """The fitted model, and the effects that could not be told apart from its own."""

    model: MixedModel = field(metadata=INLINE)
    left_out: tuple[str, ...]


@dataclass(frozen=True)
class MixedRow:
    """The mixed model of one outcome."""

    outcome: str
    not_tested: str | None
    fit: MixedFit | None = field(metadata=INLINE)


def _compute(data: AnalysisData, _: Sequence[object]) -> list[MixedRow]:
    wanted = data.plan.mixed_model or data.plan.covariates
    return [_row(data, each.name) for each in (data.scored.outcomes if wanted else ())]


def _row(data: AnalysisData, outcome: str) -> MixedRow:
    return MixedRow(outcome, *estimable(lambda: _fit(data, outcome)))


def _fit(data: AnalysisData, outcome: str) -> MixedFit:
    """Fit the wanted effects; while they cannot be told apart, without the least wanted one."""
    scored, plan = data.scored, data.plan
    rows = points(scored.table, scored, outcome)
    rows = rows.assign(**{n: column_of(scored, rows, n) for n in plan.mixed_model})
    rows = rows.assign(
        **{n: pd.to_numeric(column_of(scored, rows, n), errors="coerce") for n in plan.covariates}
    )
    factors = [name for name in plan.mixed_model if len(rows[name].dropna().unique()) > 1]
    covariates = [name for name in plan.covariates if len(rows[name].dropna().unique()) > 1]
    left_out: list[str] = []
    while factors or covariates:
        try:
            model = mixed_model(
                rows,
                value="score",
                participant="participant",
                factors=factors,
                references={"condition": data.reference},
                covariates=covariates,
                confidence=plan.confidence,
            )
        except InputError:
            if len(factors) + len(covariates) == 1:
                raise
            left_out.insert(0, (covariates if len(factors) < 2 else factors).pop())
            continue
        return MixedFit(model, tuple(left_out))
    raise InputError("no effect has two levels in the data")


def _methods(rows: Sequence[MixedRow]) -> Iterator[MethodsParagraph]:
    models = [row.fit.model for row in rows if row.fit]
    if models:
        yield MethodsParagraph(
            "Mixed model",
            "The mixed model has a random intercept per participant (Laird & Ware, 1982) and is "
            "fitted by restricted maximum likelihood to every scored exposure; its standard errors "
            "are those of generalised least squares at the fitted variances, its degrees of "
            "freedom Satterthwaite’s (1946; Kuznetsova et al., 2017).",
            ("laird_1982", "satterthwaite_1946", "kuznetsova_2017"),
        )
    if any("condition" in model.means for model in models):
        yield MethodsParagraph(
            "Marginal means",
            "Estimated marginal means (Searle et al., 1980) of the mixed model are those of a "
            "level with all levels of the other factors weighing alike; their differences, p and "
            "intervals are adjusted by Bonferroni for the number of pairs.",
            ("searle_1980",),
        )


def _csv(row: MixedRow) -> Iterator[Cells]:
    """Yield the terms, then each effect as a whole, one line each."""
    if row.fit is None:
        yield {"outcome": row.outcome, "not_tested": row.not_tested}
        return
    model = row.fit.model
    keys = {
        "outcome": row.outcome, "n_participants": model.n_participants,
        "n_values": model.n_values, "left_out": " × ".join(row.fit.left_out),
    }  # fmt: skip
    for name, term in model.terms.items():
        yield {**keys, "term": name, **asdict(term)}
    for name, test in model.omnibus.items():
        yield {**keys, "term": name, **asdict(test)}


def _csv_of_means(row: MixedRow) -> Iterator[Cells]:
    """Yield marginal means, then their differences, one line each."""
    if row.fit is None:
        return
    for of_factors in (row.fit.model.means, row.fit.model.pairwise):
        for factor, levels in of_factors.items():
            for level, estimate in levels.items():
                keys = {"outcome": row.outcome, "factor": factor, "level": level}
                yield {**keys, **asdict(estimate)}


MIXED_MODELS: Analysis[MixedRow] = Analysis(
    "mixed_models",
    AnalysisSet.ALL_AVAILABLE,
    _compute,
    section="models",
    tables=(
        AnalysisTable("mixed_models", template="report/mixed.html.j2", csv=_csv),
        AnalysisTable("marginal_means", csv=_csv_of_means),
    ),
    methods=_methods,
)
