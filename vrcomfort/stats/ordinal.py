"""Proportional odds of ordered answers: cumulative logit models and their checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit
from scipy.stats import chi2, norm

from vrcomfort.errors import InputError
from vrcomfort.stats.mixed import treatment_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Whole = NDArray[np.int64]

# Cumulative logit models of ordered answers, with or without a random intercept.
#
# P(answer ≤ j) = F(θ_j + N γ_j − X β − σ z), F the logistic function and z standard normal, one
# for each group (McCullagh 1980; with random intercepts, Hedeker & Gibbons 1994). γ is of the
# effects whose odds differ from cut to cut. The likelihood is integrated over z by adaptive
# Gauss–Hermite quadrature (Pinheiro & Bates 1995) and maximised with its own derivatives.


NODES = 25
"""Of the quadrature. From 15 on, the seventh digit of what the tests fit does not change."""
LEAST_SD = 1e-3
"""A smaller standard deviation between groups is none."""
LARGEST_ERROR = 30.0
"""Of a log odds ratio or threshold; larger ones are those of data that a line separates, whose
likelihood has no maximum."""
# Keeps the logarithm finite where a step of the search makes a probability 0.
_TINY = 1e-100


@dataclass(frozen=True)
class CumulativeLink:
    """A fit.

    Parameters
    ----------
    thresholds
        (J − 1,) θ.
    coefficients
        (p,) β: positive ones make higher answers more frequent.
    covariance
        (p, p) of β, from the observed information.
    by_cut
        (J − 1, q) −γ, of the sign of β.
    sd
        σ; 0 without groups, or where they differ no more than chance lets expect.
    """

    thresholds: Floats
    coefficients: Floats
    covariance: Floats
    by_cut: Floats
    sd: float
    log_likelihood: float


def fit_cumulative_link(
    answers: Whole, design: Floats, groups: Whole | None = None, *, nominal: Floats | None = None
) -> CumulativeLink:
    """Fit the model by maximum likelihood.

    Parameters
    ----------
    answers
        (n,) from 0, every value up to the largest at least once.
    design
        (n, p), without a column of ones.
    groups
        (n,) number of each answer's group, from 0; None: no random intercept.
    nominal
        (n, q) effects that have a coefficient for every cut.

    Raises
    ------
    InputError
        If the likelihood has no maximum: an effect separates the answers.
    """
    nominal = np.empty((len(answers), 0)) if nominal is None else nominal
    found = None if groups is None else _Likelihood(answers, design, nominal, groups).fit()
    return found or _Likelihood(answers, design, nominal, None).fit_alone()


class _Likelihood:
    """The log likelihood of (θ, γ by cut, β, σ)."""

    def __init__(
        self, answers: Whole, design: Floats, nominal: Floats, groups: Whole | None
    ) -> None:
        self._answers, self._design, self._nominal = answers, design, nominal
        self._cuts = int(answers.max())
        self._random = groups is not None
        self._groups = np.arange(len(answers)) if groups is None else groups
        self._count = int(self._groups.max()) + 1
        nodes, weights = np.polynomial.hermite.hermgauss(NODES)
        self._nodes, self._weights = nodes, weights * np.exp(nodes**2)
        self._modes = np.zeros(self._count)

    def _split(self, parameters: Floats) -> tuple[Floats, Floats, Floats, float]:
        q = self._nominal.shape[1]
        ends = np.cumsum([self._cuts, self._cuts * q, self._design.shape[1]])
        theta, gamma, beta, rest = np.split(parameters, ends)
        return theta, gamma.reshape(self._cuts, q), beta, float(rest[0]) if self._random else 0.0

    def _edges(self, parameters: Floats) -> tuple[Floats, Floats]:
        """Return the lower and the upper edge of each answer without its random part, (n,)."""
        theta, gamma, beta, _ = self._split(parameters)
        cuts = theta[:, None] + gamma @ self._nominal.T - self._design @ beta
        far = np.full((1, len(self._answers)), np.inf)
        edges = np.vstack([-far, cuts, far])
        rows = np.arange(len(self._answers))
        return edges[self._answers, rows], edges[self._answers + 1, rows]

    def value(self, parameters: Floats) -> tuple[float, Floats]:
        """Return the log likelihood and its gradient."""
        low, high = self._edges(parameters)
        if not self._random:
            logs, below, above = _logs(low[:, None], high[:, None])
            return float(logs.sum()), self._gradient(below[:, 0], above[:, 0])
        sd = self._split(parameters)[3]
        modes, widths = self._centre(low, high, sd)
        z = modes[:, None] + np.sqrt(2) * widths[:, None] * self._nodes  # (groups, nodes)
        moved = sd * z[self._groups]
        logs, below, above = _logs(low[:, None] - moved, high[:, None] - moved)
        joint = self._sums(logs) - z**2 / 2
        top = joint.max(axis=1, keepdims=True)
        parts = self._weights * np.exp(joint - top)
        whole = parts.sum(axis=1)
        # √2 width / √(2π) is that of the change of variable and of the normal density.
        likelihood = float(np.sum(top[:, 0] + np.log(whole * widths / np.sqrt(np.pi))))
        share = (parts / whole[:, None])[self._groups]
        of_sd = -float(np.sum(share * (below + above) * z[self._groups]))
        gradient = self._gradient((share * below).sum(axis=1), (share * above).sum(axis=1))
        return likelihood, np.append(gradient, of_sd)

    def _sums(self, values: Floats) -> Floats:
        found = np.zeros((self._count, values.shape[1]))
        np.add.at(found, self._groups, values)
        return found

    def _centre(self, low: Floats, high: Floats, sd: float) -> tuple[Floats, Floats]:
        """Return mode and width of each group's integrand by Newton's method: it is log-concave."""
        z = self._modes
        for _ in range(100):
            moved = sd * z[self._groups]
            below, above = expit(low - moved), expit(high - moved)
            slope = np.bincount(self._groups, sd * (below + above - 1), self._count) - z
            bends = sd**2 * (below * (1 - below) + above * (1 - above))
            bend = np.bincount(self._groups, bends, self._count) + 1
            step = np.clip(slope / bend, -2, 2)
            z = z + step
            if np.abs(step).max() < 1e-9:
                break
        self._modes = z
        return z, 1 / np.sqrt(bend)

    def _gradient(self, below: Floats, above: Floats) -> Floats:
        """Return the slopes in θ, γ and β; `below` and `above` are −f(low)/P and f(high)/P."""
        theta = np.zeros(self._cuts + 2)
        gamma = np.zeros((self._cuts + 2, self._nominal.shape[1]))
        np.add.at(theta, self._answers, below)
        np.add.at(theta, self._answers + 1, above)
        np.add.at(gamma, self._answers, below[:, None] * self._nominal)
        np.add.at(gamma, self._answers + 1, above[:, None] * self._nominal)
        beta = -(below + above) @ self._design
        return np.concatenate([theta[1:-1], gamma[1:-1].ravel(), beta])

    def fit_alone(self) -> CumulativeLink:
        """Return the maximum without a random intercept."""
        found = self.fit()
        assert found is not None  # noqa: S101 - only a random intercept can be none
        return found

    def fit(self) -> CumulativeLink | None:
        """Return the maximum: found with ordered thresholds by BFGS, made exact by Newton.

        None where a random intercept has no variance.
        """
        free = np.zeros(self._cuts * (1 + self._nominal.shape[1]) + self._design.shape[1])
        shares = np.cumsum(np.bincount(self._answers))[:-1] / len(self._answers)
        free[: self._cuts] = _apart(np.log(shares / (1 - shares)))
        start = np.append(free, 1.0) if self._random else free
        found = minimize(self._negative, start, jac=True, method="BFGS", options={"gtol": 1e-6})
        parameters, hessian = self._newton(_together(found.x, self._cuts))
        theta, gamma, beta, sd = self._split(parameters)
        if self._random and abs(sd) < LEAST_SD:
            return None
        first = self._cuts * (1 + self._nominal.shape[1])
        covariance = _inverted(-hessian)
        here = slice(first, first + self._design.shape[1])
        return CumulativeLink(
            theta, beta, covariance[here, here], -gamma, abs(sd), self.value(parameters)[0]
        )

    def _negative(self, free: Floats) -> tuple[float, Floats]:
        parameters = _together(free, self._cuts)
        value, gradient = self.value(parameters)
        gaps = np.diff(parameters[: self._cuts])
        tails = np.cumsum(gradient[: self._cuts][::-1])[::-1]  # a gap moves all later thresholds
        gradient = gradient.copy()
        gradient[: self._cuts] = np.append(tails[:1], tails[1:] * gaps)
        return -value, -gradient

    def _newton(self, parameters: Floats) -> tuple[Floats, Floats]:
        hessian = self._hessian(parameters)
        for _ in range(8):
            if np.linalg.eigvalsh(hessian).max() >= 0:
                break  # at a standard deviation of 0 or without a maximum; BFGS has the best
            step = np.linalg.solve(hessian, self.value(parameters)[1])
            if np.abs(step).max() > 1:
                break
            parameters = parameters - step
            hessian = self._hessian(parameters)
            if np.abs(step).max() < 1e-10:
                break
        return parameters, hessian

    def _hessian(self, parameters: Floats) -> Floats:
        width = 1e-5
        rows = [
            (self.value(parameters + step)[1] - self.value(parameters - step)[1]) / (2 * width)
            for step in width * np.eye(len(parameters))
        ]
        hessian = np.array(rows)
        symmetric: Floats = (hessian + hessian.T) / 2
        return symmetric


def _inverted(information: Floats) -> Floats:
    """Return the covariance of the estimates.

    Raises
    ------
    InputError
        If the likelihood is flat in some direction.
    """
    least = 1 / LARGEST_ERROR**2
    if not np.isfinite(information).all() or np.linalg.eigvalsh(information).min() < least:
        raise InputError(
            "an effect separates the answers: all of one side are higher, so that there is no "
            "finite odds ratio"
        )
    return np.asarray(np.linalg.inv(information), dtype=np.float64)


def _logs(low: Floats, high: Floats) -> tuple[Floats, Floats, Floats]:
    """Return log P, −f(low)/P and f(high)/P of P = F(high) − F(low), without cancellation."""
    right = low + high > 0  # infinite ends never meet: an answer has at most one
    a, b = np.where(right, -high, low), np.where(right, -low, high)
    share = np.maximum(expit(b) - expit(a), _TINY)
    below, above = expit(low) * expit(-low), expit(high) * expit(-high)
    return np.log(share), -below / share, above / share


def _apart(thresholds: Floats) -> Floats:
    """Return the first threshold and the logarithms of the gaps."""
    return np.concatenate([thresholds[:1], np.log(np.diff(thresholds))])


def _together(free: Floats, cuts: int) -> Floats:
    """Return parameters with thresholds in place of a threshold and gaps."""
    thresholds = np.cumsum(np.append(free[:1], np.exp(np.clip(free[1:cuts], -30, 10))))
    return np.concatenate([thresholds, free[cuts:]])


# Proportional odds of ordered answers: what conditions do to the odds of a higher answer.
#
# A single item has few answers, whose distances mean nothing; a cumulative logit model takes only
# their order (McCullagh 1980). statsmodels' ``OrderedModel`` has no random intercept.


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
