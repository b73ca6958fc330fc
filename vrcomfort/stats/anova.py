"""Analysis of variance: within, between and mixed designs, type II or III sums of squares."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Literal

import numpy as np
import pandas as pd
from scipy.special import chdtrc, fdtrc

from vrcomfort.errors import InputError
from vrcomfort.stats.effects import EffectSize, partial_eta_squared

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# From a long table to the participants × cells table of a factorial design.


@dataclass(frozen=True)
class Cells:
    """The complete participants of a design."""

    scores: NDArray[np.float64]
    """Shape (n, cells); cells in the product order of the levels."""
    levels: dict[str, tuple[str, ...]]
    """Levels of each within factor, sorted."""
    groups: dict[str, NDArray[np.int64]]
    """Between factor → number of each participant's group, shape (n,)."""
    excluded: tuple[str, ...]
    """Participants without a value in every cell."""


def cells(
    table: pd.DataFrame,
    *,
    value: str,
    participant: str,
    within: Sequence[str] = (),
    between: Sequence[str] = (),
) -> Cells:
    """Arrange a long table with at most one row per participant and cell.

    Raises
    ------
    InputError
        If a participant has two values in a cell or changes group.
    """
    names = list(within)
    if table.duplicated([participant, *names]).any():
        raise InputError("a participant has two values in one cell; average them first")
    levels = {n: tuple(sorted(map(str, table[n].dropna().unique()))) for n in names}
    wide = _wide(table, value, participant, levels)
    complete = wide.dropna()
    return Cells(
        scores=complete.to_numpy(dtype=np.float64),
        levels=levels,
        groups={name: _groups(table, participant, name, complete.index) for name in between},
        excluded=tuple(str(name) for name in wide.index.difference(complete.index)),
    )


def _wide(
    table: pd.DataFrame, value: str, participant: str, levels: dict[str, tuple[str, ...]]
) -> pd.DataFrame:
    names = [table[name].map(str) for name in levels]
    keys = ["\x1f".join(cell) for cell in zip(*names, strict=True)] if names else ""
    there = table.assign(_cell=keys).dropna(subset=[participant, value])
    flat = there.pivot(index=participant, columns="_cell", values=value)  # noqa: PD010 - 3 × faster
    wanted = ["\x1f".join(cell) for cell in product(*levels.values())]
    return flat.reindex(columns=wanted)


def _groups(
    table: pd.DataFrame, participant: str, between: str, people: pd.Index
) -> NDArray[np.int64]:
    pairs = table[[participant, between]].drop_duplicates()
    if pairs[participant].duplicated().any():
        raise InputError(f"{between!r} changes within a participant; it is not a between factor")
    group = pairs.set_index(participant)[between].loc[people]
    return np.unique(group.astype(str), return_inverse=True)[1].astype(np.int64)


# Sphericity of repeated measures: Mauchly's test and the two epsilon corrections.


@dataclass(frozen=True)
class Sphericity:
    """How far the covariance of the contrasts is from spherical."""

    mauchly_w: float | None
    """None where the error covariance is singular (too few participants)."""
    mauchly_p: float | None
    greenhouse_geisser: float
    huynh_feldt: float
    """Capped at 1."""


def sphericity(error: NDArray[np.float64], df_error: int) -> Sphericity:
    """Describe the error matrix of a within effect.

    Parameters
    ----------
    error
        Sums of squares and products of the orthonormal contrasts, shape (p, p), p >= 2.
    df_error
        Its degrees of freedom (participants minus groups).
    """
    p = error.shape[0]
    trace = float(np.trace(error))
    if trace <= 0:
        return Sphericity(None, None, 1.0, 1.0)
    gg = trace**2 / (p * float(np.sum(error**2)))
    mauchly_w = mauchly_p = None
    if df_error >= p:
        mauchly_w = max(float(np.linalg.det(error / (trace / p))), 0.0)
        mauchly_p = _mauchly_p(mauchly_w, p, df_error)
    return Sphericity(mauchly_w, mauchly_p, gg, _huynh_feldt(gg, p, df_error))


def _huynh_feldt(gg: float, p: int, df_error: int) -> float:
    """Huynh & Feldt (1976) with Lecoutre's (1991) correction for groups."""
    denominator = p * (df_error - p * gg)
    if denominator <= 0:
        return 1.0
    return min(1.0, ((df_error + 1) * p * gg - 2) / denominator)


def _mauchly_p(w: float, p: int, df_error: int) -> float:
    """Second-order chi-square approximation (Anderson 2003, section 10.7)."""
    if w <= 0:
        return 0.0
    rho = 1 - (2 * p**2 + p + 2) / (6 * p * df_error)
    order_2 = (p + 2) * (p - 1) * (p - 2) * (2 * p**3 + 6 * p**2 + 3 * p + 2)
    omega = order_2 / (288 * (df_error * p * rho) ** 2)
    statistic = -df_error * rho * np.log(w)
    df = p * (p + 1) / 2 - 1
    first, second = chdtrc(df, statistic), chdtrc(df + 4, statistic)
    return float(np.clip(first + omega * (second - first), 0, 1))


# Own code because the packages each lack a part (Huynh-Feldt p values, ε of two-way and mixed
# designs, type III in unbalanced mixed designs). The univariate tests are read off the
# multivariate model: with Y the participants × cells table and M the orthonormal contrasts of a
# within effect, an effect's sum of squares is the trace of its hypothesis matrix in Y·M, its
# error the trace of the error matrix, and ε comes from the latter (Maxwell, Delaney & Kelley
# 2018, chapter 13).


SumsOfSquares = Literal["II", "III"]

ROUNDING = 1e-26
"""Share of the total sum of squares below which an error term is rounding, not variance."""


@dataclass(frozen=True)
class AnovaEffect:
    """One line of an ANOVA table."""

    effect: str
    """Factor names joined by ``×``."""
    sum_of_squares: float
    error_sum_of_squares: float
    df_effect: int
    df_error: int
    f: float | None
    """None without error variance."""
    p: float | None
    """Sphericity assumed."""
    sphericity: Sphericity | None
    """None for effects with one degree of freedom, where sphericity holds."""
    p_greenhouse_geisser: float | None
    p_huynh_feldt: float | None
    generalised_eta_squared: float | None
    """All factors taken as manipulated (Olejnik & Algina 2003)."""
    partial_eta_squared: EffectSize | None
    """With its 90 % interval, from the uncorrected degrees of freedom."""


@dataclass(frozen=True)
class Anova:
    """An ANOVA, its participants, and the residuals to judge it by."""

    effects: tuple[AnovaEffect, ...]
    n: int
    excluded: tuple[str, ...]
    """Participants without a value in every cell."""
    residuals: Floats
    """Shape (n, cells): each value without its cell mean (in the participant's group) and, with
    within factors, without the participant's own level."""


@dataclass(frozen=True)
class _Fit:
    """Least squares of the contrasts of one within effect on the between design."""

    name: str
    error: Floats
    """Sums of squares and products of the residuals, shape (p, p)."""
    df_error: int
    scale: float
    """Sum of squares of the data, against which an error of rounding is none."""
    hypotheses: dict[str, tuple[float, int]]
    """Between term ("" is the intercept): its sum of squares and degrees of freedom."""


def anova(
    table: pd.DataFrame,
    *,
    value: str,
    participant: str,
    within: Sequence[str] = (),
    between: str | Sequence[str] = (),
    sums_of_squares: SumsOfSquares = "III",
) -> Anova:
    """Analyse a long table with at most one row per participant and cell.

    Parameters
    ----------
    table
        Long data; the columns named by the other arguments are used.
    within
        Factors crossed within participants (none, one, two or more).
    between
        A factor that groups participants, or several, crossed.
    sums_of_squares
        ``III``: each effect given all others, groups weighing alike. ``II``: given those that do
        not contain it, participants weighing alike (Langsrud 2003). They differ where groups differ
        in size.

    Raises
    ------
    InputError
        If a participant has two values in a cell, a factor has fewer than two levels, or there
        are too few complete participants for an error term.
    """
    grouping = (between,) if isinstance(between, str) else tuple(between)
    data = cells(table, value=value, participant=participant, within=within, between=grouping)
    return anova_of_cells(data, sums_of_squares)


def anova_of_cells(data: Cells, sums_of_squares: SumsOfSquares = "III") -> Anova:
    """Analyse the complete participants of a design; see `anova`."""
    _check_levels(data)
    terms = _between_terms(data)
    design = np.column_stack(list(terms.values()))
    if np.linalg.matrix_rank(design) < design.shape[1]:
        names = " and ".join(repr(name) for name in data.groups)
        raise InputError(f"no complete participant is in some combination of {names}")
    centred = data.scores - data.scores.mean()  # keeps digits when values share leading ones
    scale = float(np.sum(centred**2))
    fits = [
        _fit(name, scale, centred @ m, terms, sums_of_squares) for name, m in _strata(data.levels)
    ]
    return Anova(
        effects=tuple(_effects(fits)),
        n=data.scores.shape[0],
        excluded=data.excluded,
        residuals=_residuals(centred, design),
    )


def _check_levels(data: Cells) -> None:
    short = [name for name, found in data.levels.items() if len(found) < 2]
    if short:
        raise InputError(f"factor {short[0]!r} has fewer than two levels in the data")
    for name, codes in data.groups.items():
        if np.unique(codes).size < 2:
            raise InputError(f"factor {name!r} has fewer than two groups among the complete")
    groups = prod(np.unique(codes).size for codes in data.groups.values())
    if data.scores.shape[0] <= groups:
        raise InputError(f"an ANOVA here needs more than {groups} complete participants")


def _between_terms(data: Cells) -> dict[tuple[str, ...], Floats]:
    """Term (names of its factors; none: the intercept) → sum-coded columns, shape (n, df).

    Type III needs columns that sum to 0 over the groups.
    """
    n = data.scores.shape[0]
    terms: dict[tuple[str, ...], Floats] = {(): np.ones((n, 1))}
    for name, codes in data.groups.items():
        indicator = (codes[:, None] == np.unique(codes)).astype(np.float64)
        coded = indicator[:, :-1] - indicator[:, -1:]
        terms |= {
            (*term, name): (columns[:, :, None] * coded[:, None, :]).reshape(n, -1)
            for term, columns in terms.items()
        }
    return dict(sorted(terms.items(), key=lambda item: len(item[0])))


def _strata(levels: dict[str, tuple[str, ...]]) -> list[tuple[str, Floats]]:
    """Each combination of within factors (none of them first) with its contrasts (cells, p)."""
    strata = []
    for used in sorted(product((True, False), repeat=len(levels)), key=sum):
        parts = [
            _contrasts(len(found)) if take else np.full((len(found), 1), len(found) ** -0.5)
            for take, found in zip(used, levels.values(), strict=True)
        ]
        name = " × ".join(n for n, take in zip(levels, used, strict=True) if take)
        strata.append((name, _kron(parts)))
    return strata


def _kron(parts: list[Floats]) -> Floats:
    together: Floats = np.ones((1, 1))
    for part in parts:
        together = np.asarray(np.kron(together, part), dtype=np.float64)
    return together


def _contrasts(k: int) -> Floats:
    """Orthonormal columns that are orthogonal to a constant, shape (k, k - 1)."""
    basis = np.column_stack([np.ones(k), np.eye(k)[:, 1:]])
    q: Floats = np.linalg.qr(basis)[0][:, 1:]
    return q


def _fit(
    name: str,
    scale: float,
    z: Floats,
    terms: dict[tuple[str, ...], Floats],
    sums_of_squares: SumsOfSquares,
) -> _Fit:
    """Regress the contrasts `z` (n, p) on the between design; test each of its terms."""
    design = np.column_stack(list(terms.values()))
    residuals = _left(z, design)
    hypotheses = {
        " × ".join(term): (
            _explained(z, columns, _given(term, terms, sums_of_squares)),
            columns.shape[1] * z.shape[1],
        )
        for term, columns in terms.items()
    }
    return _Fit(name, residuals.T @ residuals, z.shape[0] - design.shape[1], scale, hypotheses)


def _given(
    term: tuple[str, ...], terms: dict[tuple[str, ...], Floats], sums_of_squares: SumsOfSquares
) -> list[Floats]:
    """Return the columns that a term is adjusted for: all others, or those not containing it."""
    if sums_of_squares == "III":
        return [columns for name, columns in terms.items() if name != term]
    return [columns for name, columns in terms.items() if not set(term) <= set(name)]


def _explained(z: Floats, columns: Floats, given: list[Floats]) -> float:
    """Return the sum of squares of a term's columns after adjustment for the columns given.

    It is that of a projection, and so never below 0; a difference of two residual sums may be.
    """
    own = _left(columns, np.column_stack(given)) if given else columns
    return float(np.sum((np.linalg.qr(own)[0].T @ z) ** 2))


def _left(z: Floats, design: Floats) -> Floats:
    """Return the residuals of a regression."""
    left: Floats = z - design @ np.linalg.lstsq(design, z, rcond=None)[0]
    return left


def _effects(fits: list[_Fit]) -> list[AnovaEffect]:
    total_error = sum(float(np.trace(fit.error)) for fit in fits)
    return [
        _effect(" × ".join(n for n in (term, fit.name) if n), fit, *hypothesis, total_error)
        for fit in fits
        for term, hypothesis in fit.hypotheses.items()
        if term or fit.name  # the grand mean is no effect
    ]


def _effect(name: str, fit: _Fit, explained: float, df: int, total_error: float) -> AnovaEffect:
    p = fit.error.shape[0]
    error, df_error = float(np.trace(fit.error)), fit.df_error * p
    f = (explained / df) / (error / df_error) if error > ROUNDING * fit.scale else None
    shape = sphericity(fit.error, fit.df_error) if p > 1 else None
    total = explained + total_error
    return AnovaEffect(
        effect=name,
        sum_of_squares=explained,
        error_sum_of_squares=error,
        df_effect=df,
        df_error=df_error,
        f=f,
        p=_p(f, df, df_error, 1.0),
        sphericity=shape,
        p_greenhouse_geisser=_p(f, df, df_error, shape.greenhouse_geisser) if shape else None,
        p_huynh_feldt=_p(f, df, df_error, shape.huynh_feldt) if shape else None,
        generalised_eta_squared=explained / total if total > 0 else None,
        partial_eta_squared=None if f is None else partial_eta_squared(f, df, df_error),
    )


def _p(f: float | None, df_effect: int, df_error: int, epsilon: float) -> float | None:
    if f is None:
        return None
    return float(fdtrc(df_effect * epsilon, df_error * epsilon, f))


def _residuals(centred: Floats, design: Floats) -> Floats:
    left = _left(centred, design)
    within: Floats = left - left.mean(axis=1, keepdims=True) if left.shape[1] > 1 else left
    return within
