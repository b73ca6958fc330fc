"""Proportional odds of ordered answers: what conditions do to the odds of a higher answer.

A single item has few answers, whose distances mean nothing; a cumulative logit model takes only
their order (McCullagh 1980). statsmodels' ``OrderedModel`` has no random intercept.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2, norm

from vrcomfort.errors import InputError
from vrcomfort.stats.cumulative_link import CumulativeLink, fit_cumulative_link
from vrcomfort.stats.mixed import treatment_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Whole = NDArray[np.int64]


@dataclass(frozen=True)
class OddsRatio:
    """A log odds ratio of a higher answer with Wald's test and interval, and the ratio."""

    estimate: float
    standard_error: float
    z: float
    p: float
    low: float
    high: float
    odds_ratio: float
    odds_low: float
    odds_high: float


@dataclass(frozen=True)
class LikelihoodRatio:
    """A likelihood-ratio test."""

    chi_squared: float
    df: int
    p: float


@dataclass(frozen=True)
class Proportionality:
    """Whether one odds ratio stands for all cuts between answers.

    Parameters
    ----------
    test
        Against a model with an odds ratio for every cut; None with a reason.
    together
        Answers that were taken together for the test, for some level lacked one of them.
    reason
        Why there is no test.
    cuts
        Term → odds ratio of answers above each cut, fitted alone; None where answers are
        separated.
    """

    test: LikelihoodRatio | None
    together: tuple[tuple[float, ...], ...]
    reason: str
    cuts: dict[str, tuple[float | None, ...]]


@dataclass(frozen=True)
class OrdinalModel:
    """A cumulative logit model.

    Parameters
    ----------
    answers
        The different ones, from the lowest.
    thresholds
        Log odds of an answer up to each of them but the last, at the reference levels.
    terms
        ``factor: level − reference level`` → odds of a higher answer.
    omnibus
        Factor → test of all its levels.
    participant_sd
        Of the random intercept, in log odds; None where everybody answered once.
    proportional
        Factor → check of proportional odds; empty with two answers, which have one cut.
    """

    n_values: int
    n_participants: int
    answers: tuple[float, ...]
    thresholds: tuple[float, ...]
    terms: dict[str, OddsRatio]
    omnibus: dict[str, LikelihoodRatio]
    participant_sd: float | None
    log_likelihood: float
    proportional: dict[str, Proportionality]


def ordinal_model(
    table: pd.DataFrame,
    *,
    value: str,
    participant: str,
    factors: Sequence[str],
    references: dict[str, str] | None = None,
    confidence: float = 0.95,
) -> OrdinalModel:
    """Fit ``value ~ factors`` to ordered answers, with a random intercept if people repeat.

    Parameters
    ----------
    factors
        Columns with categories. Those with one level are left out.
    references
        Reference level of a factor; the first in sorted order otherwise.

    Raises
    ------
    InputError
        If all answers are alike, no factor has two levels, factors cannot be told apart, or an
        effect separates the answers.
    """
    rows = table.dropna(subset=[value, participant, *factors])
    columns = {
        name: treatment_columns(rows, name, (references or {}).get(name)) for name in factors
    }
    columns = {name: found for name, found in columns.items() if found}
    if not columns:
        raise InputError("no effect has two levels in the data")
    answers, place = np.unique(rows[value].to_numpy(dtype=np.float64), return_inverse=True)
    if answers.size < 2:
        raise InputError("all answers are alike")
    people, groups = np.unique(rows[participant].astype(str), return_inverse=True)
    repeated = groups if people.size < len(rows) else None
    work = _Work(place, columns, repeated)
    fit = work.fit(place)
    names = [term for found in columns.values() for term in found]
    errors = np.sqrt(np.diag(fit.covariance))
    pairs = zip(names, fit.coefficients.tolist(), errors.tolist(), strict=True)
    return OrdinalModel(
        n_values=len(rows),
        n_participants=people.size,
        answers=tuple(answers.tolist()),
        thresholds=tuple(fit.thresholds.tolist()),
        terms={name: _odds_ratio(b, se, confidence) for name, b, se in pairs},
        omnibus={name: work.omnibus(name, fit) for name in columns},
        participant_sd=None if repeated is None else fit.sd,
        log_likelihood=fit.log_likelihood,
        proportional={name: work.proportional(name, answers, fit) for name in columns}
        if answers.size > 2
        else {},
    )


def _odds_ratio(estimate: float, error: float, confidence: float) -> OddsRatio:
    z, half = estimate / error, float(norm.ppf((1 + confidence) / 2)) * error
    low, high = estimate - half, estimate + half
    ratios = np.exp([estimate, low, high]).tolist()
    return OddsRatio(estimate, error, z, float(2 * norm.sf(abs(z))), low, high, *ratios)


def _ratio(larger: CumulativeLink, smaller: CumulativeLink, df: int) -> LikelihoodRatio:
    statistic = max(0.0, 2 * (larger.log_likelihood - smaller.log_likelihood))
    return LikelihoodRatio(statistic, df, float(chi2.sf(statistic, df)))


class _Work:
    """Fits the model again, without a factor, or with its odds different from cut to cut."""

    def __init__(
        self, answers: Whole, columns: dict[str, dict[str, Floats]], groups: Whole | None
    ) -> None:
        self._answers, self._columns, self._groups = answers, columns, groups
        design = np.column_stack([np.ones(len(answers)), self._design()])
        if np.linalg.matrix_rank(design) < design.shape[1]:
            raise InputError(f"{' and '.join(columns)} cannot be told apart in these data")

    def _design(self, without: str | None = None) -> Floats:
        found = [c for name, own in self._columns.items() if name != without for c in own.values()]
        return np.column_stack(found) if found else np.empty((len(self._answers), 0))

    def fit(self, answers: Whole) -> CumulativeLink:
        """Return the model of all factors."""
        return fit_cumulative_link(answers, self._design(), self._groups)

    def omnibus(self, factor: str, whole: CumulativeLink) -> LikelihoodRatio:
        """Test all levels of a factor together."""
        smaller = fit_cumulative_link(self._answers, self._design(factor), self._groups)
        return _ratio(whole, smaller, len(self._columns[factor]))

    def proportional(self, factor: str, values: Floats, whole: CumulativeLink) -> Proportionality:
        """Check whether the odds ratios of a factor are those of every cut."""
        own = np.column_stack(list(self._columns[factor].values()))
        merged = _merged(self._answers, np.where(own.any(axis=1), 1 + own.argmax(axis=1), 0))
        parts = [values[merged == each] for each in range(int(merged.max()) + 1)]
        together = tuple(tuple(part.tolist()) for part in parts if part.size > 1)
        cuts = self._by_cut(factor)
        if len(parts) < 3:
            reason = "too few different answers were given under every level"
            return Proportionality(None, together, reason, cuts)
        answers = merged[self._answers]
        try:
            larger = fit_cumulative_link(answers, self._design(factor), self._groups, nominal=own)
        except InputError as error:
            return Proportionality(None, together, error.message, cuts)
        df = own.shape[1] * (len(parts) - 2)
        smaller = self.fit(answers) if together else whole
        return Proportionality(_ratio(larger, smaller, df), together, "", cuts)

    def _by_cut(self, factor: str) -> dict[str, tuple[float | None, ...]]:
        names = [name for own in self._columns.values() for name in own]
        found: dict[str, list[float | None]] = {name: [] for name in self._columns[factor]}
        for cut in range(int(self._answers.max())):
            above = (self._answers > cut).astype(np.int64)
            try:
                fit = self.fit(above)
            except InputError:
                fit = None
            for name, ratios in found.items():
                ratios.append(float(np.exp(fit.coefficients[names.index(name)])) if fit else None)
        return {name: tuple(ratios) for name, ratios in found.items()}


def _merged(answers: Whole, levels: Whole) -> Whole:
    """Return answer → place after neighbours are taken together until every level has all.

    The rarest answer that some level lacks is taken together with its rarer neighbour.
    """
    counts = np.zeros((int(answers.max()) + 1, int(levels.max()) + 1), dtype=np.int64)
    np.add.at(counts, (answers, levels), 1)
    place = np.arange(len(counts))
    while len(counts) > 1 and (counts == 0).any():
        sums = counts.sum(axis=1)
        lacking = np.flatnonzero((counts == 0).any(axis=1))
        rarest = int(lacking[sums[lacking].argmin()])
        near = [each for each in (rarest - 1, rarest + 1) if 0 <= each < len(counts)]
        low = min(rarest, min(near, key=lambda each: sums[each]))
        counts[low] += counts[low + 1]
        counts = np.delete(counts, low + 1, axis=0)
        place = np.where(place > low, place - 1, place)
    return place
