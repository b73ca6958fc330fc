"""Analyses of variance of a plan's factors, on scores and on aligned ranks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import shapiro

from vrcomfort.errors import InputError
from vrcomfort.records.names import natural
from vrcomfort.report.analyses.contract import (
    Analysis,
    AnalysisData,
    AnalysisSet,
    AnalysisTable,
    MethodsParagraph,
    estimable,
)
from vrcomfort.report.factors import is_between, level_of, points
from vrcomfort.report.pairs import with_every_score
from vrcomfort.report.rows import INLINE
from vrcomfort.stats.anova import AnovaEffect, anova
from vrcomfort.stats.rank_anova import aligned_ranks

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Factor
    from vrcomfort.report.rows import Cells

MOST_FOR_SHAPIRO = 5000
"""Residuals up to which the p of Shapiro and Wilk's test is accurate."""


@dataclass(frozen=True)
class AnovaEffectRow:
    """An effect, with its p adjusted in the plan's family."""

    test: AnovaEffect = field(metadata=INLINE)
    family: str | None = None
    p_holm: float | None = None


@dataclass(frozen=True)
class ResidualCheck:
    """Shapiro and Wilk's test of the residuals."""

    shapiro_w: float
    p: float
    n: int


@dataclass(frozen=True)
class AnovaFit:
    """The effects, and the people they are of."""

    factors: dict[str, list[str]]
    between: tuple[str, ...]
    sums_of_squares: str
    n: int
    participants: tuple[str, ...]
    excluded: tuple[str, ...]
    effects: tuple[AnovaEffectRow, ...]
    aligned_ranks: tuple[AnovaEffect, ...]
    residuals: ResidualCheck | None


@dataclass(frozen=True)
class AnovaRow:
    """The analysis of variance of one outcome."""

    outcome: str
    not_tested: str | None
    fit: AnovaFit | None = field(metadata=INLINE)


def _compute(data: AnalysisData, _: Sequence[object]) -> list[AnovaRow]:
    outcomes = data.scored.outcomes if data.plan.anova else ()
    return [_row(data, each.name) for each in outcomes]


def _row(data: AnalysisData, outcome: str) -> AnovaRow:
    return AnovaRow(outcome, *estimable(lambda: _fit(data, outcome)))


def _fit(data: AnalysisData, outcome: str) -> AnovaFit:
    scored, plan = data.scored, data.plan
    over_time = any(factor.column == "timepoint" for factor in plan.anova)
    table = points(scored.moments if over_time else scored.table, scored, outcome)
    made = [(f, level_of(scored, table, f)) for f in plan.anova]
    made = [(f, levels) for f, levels in made if len(levels.dropna().unique()) > 1]
    if not made:
        raise InputError("no factor has two levels in the data")
    long = table.assign(**{f.name: levels for f, levels in made})
    between = [f.name for f, _ in made if is_between(f)]
    within = [f.name for f, _ in made if not is_between(f)]
    names = [f.name for f, _ in made]
    whole = long.dropna(subset=names)
    if data.complete:
        whole = _with_every_score(scored, outcome, whole, [factor for factor, _ in made])
    cells = whole.groupby(["participant", *names])["score"].mean().reset_index()
    ranked: tuple[AnovaEffect, ...] = ()
    if plan.aligned_ranks:
        result, ranked = aligned_ranks(
            cells, value="score", participant="participant", within=within, between=between,
            sums_of_squares=plan.sums_of_squares,
        )  # fmt: skip
    else:
        result = anova(
            cells, value="score", participant="participant", within=within, between=between,
            sums_of_squares=plan.sums_of_squares,
        )  # fmt: skip
    people = set(cells["participant"]) - set(result.excluded)
    return AnovaFit(
        factors={n: sorted(map(str, cells[n].unique())) for n in names},
        between=tuple(between),
        sums_of_squares=plan.sums_of_squares,
        n=result.n,
        participants=tuple(sorted(people, key=natural)),
        excluded=tuple(sorted(set(long["participant"]) - people, key=natural)),
        effects=tuple(map(AnovaEffectRow, result.effects)),
        aligned_ranks=tuple(ranked),
        residuals=_residual_check(result.residuals),
    )


def _with_every_score(
    scored: Exposures, outcome: str, rows: pd.DataFrame, factors: list[Factor]
) -> pd.DataFrame:
    """Return the rows of participants with every planned score in each cell of an ANOVA.

    How many are planned is known of conditions; where scenes, say, divide them, and where nothing
    tells conditions apart, it is the most frequent number.
    """
    of_conditions = [factor.name for factor in factors if factor.column == "condition"]
    divided = [f for f in factors if f.column != "condition" and not is_between(f)]
    if divided or not of_conditions:
        return with_every_score(rows, [factor.name for factor in factors])
    planned = scored.planned_of[outcome]
    levels = rows.groupby(of_conditions)["condition"].unique()
    wanted = {level: sum(planned.get(name, 1) for name in found) for level, found in levels.items()}
    return with_every_score(rows, of_conditions, wanted)


def _residual_check(residuals: NDArray[np.float64]) -> ResidualCheck | None:
    flat = residuals.ravel()
    if not 4 <= flat.size <= MOST_FOR_SHAPIRO or np.ptp(flat) <= 1e-9:
        return None
    found = shapiro(flat)
    return ResidualCheck(float(found.statistic), float(found.pvalue), int(flat.size))


def _methods(rows: Sequence[AnovaRow]) -> Iterator[MethodsParagraph]:
    if any(row.fit and row.fit.aligned_ranks for row in rows):
        yield MethodsParagraph(
            "Aligned ranks",
            "For each effect of the ANOVA scores were stripped of all other effects, ranked, and "
            "analysed in the same way (Wobbrock et al., 2011).",
            ("wobbrock_2011",),
        )


def _csv(row: AnovaRow) -> Iterator[Cells]:
    """Yield the effects, one line each."""
    fit = row.fit
    if fit is None:
        yield {"outcome": row.outcome, "not_tested": row.not_tested}
        return
    keys = {
        "outcome": row.outcome, "n": fit.n, "people_in_it": list(fit.participants),
        "between": list(fit.between), "type": fit.sums_of_squares,
    }  # fmt: skip
    for effect in fit.effects:
        numbers = asdict(effect.test)
        shape = numbers.pop("sphericity") or {}
        eta = numbers.pop("partial_eta_squared") or {}
        yield {
            **keys, **numbers, "family": effect.family, "p_holm": effect.p_holm,
            "partial_eta_squared": eta.get("estimate"),
            "partial_eta_squared_low": eta.get("low"),
            "partial_eta_squared_high": eta.get("high"),
            **{name: shape.get(name) for name in _SHAPE},
        }  # fmt: skip


_SHAPE = ("mauchly_w", "mauchly_p", "greenhouse_geisser", "huynh_feldt")
_OF_RANKS = ("effect", "f", "df_effect", "df_error", "p", "p_greenhouse_geisser", "p_huynh_feldt")


def _csv_of_ranks(row: AnovaRow) -> Iterator[Cells]:
    for effect in row.fit.aligned_ranks if row.fit else ():
        yield {"outcome": row.outcome, **{name: getattr(effect, name) for name in _OF_RANKS}}


ANOVA: Analysis[AnovaRow] = Analysis(
    "anova",
    AnalysisSet.COMPLETE_BLOCKS,
    _compute,
    section="models",
    tables=(
        AnalysisTable("anova", template="report/anova.html.j2", csv=_csv),
        AnalysisTable("aligned_ranks", csv=_csv_of_ranks),
    ),
    methods=_methods,
)
