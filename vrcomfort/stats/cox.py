"""Cox's proportional hazards: how often an event comes under one condition for once under another.

Ties are Efron's. Errors are robust to people who come more than once (Lin & Wei 1989). The tests
hold all of it to R's ``coxph``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2, norm

from vrcomfort.errors import InputError
from vrcomfort.stats.survival import one_time

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Integers = NDArray[np.int64]

MOST_STEPS = 50
CONVERGED = 1e-12
"""Newton's decrement, relative to the log likelihood, at which the search ends."""
UNBOUNDED = 100.0
"""Standard error × SD of a covariate from which on the likelihood is flat: it has no maximum."""


@dataclass(frozen=True)
class HazardRatio:
    """One effect: the ratio of hazards per unit of a covariate."""

    ratio: float
    low: float
    high: float
    coefficient: float
    """Its natural logarithm."""
    standard_error: float
    """Of the coefficient, by the likelihood alone."""
    robust_error: float | None
    """Of the coefficient, robust to repeated people; None where everybody came once."""
    z: float
    """Over the robust error where there is one, as are p and the interval."""
    p: float


@dataclass(frozen=True)
class Cox:
    """A fitted model."""

    n: int
    events: int
    people: int
    effects: dict[str, HazardRatio]
    log_likelihood: float
    likelihood_ratio: float
    """2 × the gain in log likelihood over no effect; it ignores that people repeat."""
    wald: float
    """Of all effects together, with the errors that are printed."""
    df: int
    p: float
    """Of `wald`."""


@dataclass(frozen=True)
class _Risk:
    """The risk set at one time of events: Efron's denominators."""

    dying: Integers
    at_risk: Integers
    shares: Floats
    """k/d for k = 0 … d − 1: how much of the dying is out of each denominator."""


class NoHazardRatioError(InputError):
    """A hazard ratio that grows, or falls, without end.

    Parameters
    ----------
    term
        Name of its column.
    """

    def __init__(self, term: str) -> None:
        self.term = term
        side = "all events, or none, lie on one side of it"
        super().__init__(f"the hazard ratio of {term} has no estimate: {side}")


def cox(
    times_s: ArrayLike,
    events: ArrayLike,
    covariates: Mapping[str, ArrayLike],
    *,
    people: ArrayLike | None = None,
    confidence: float = 0.95,
) -> Cox:
    """Fit hazards that are proportional over time.

    Parameters
    ----------
    times_s, events
        As in `kaplan_meier`.
    covariates
        Name → values, shape (n,).
    people
        Who each course is of, shape (n,). Where somebody comes twice, standard errors, intervals
        and p are robust: scores are summed within people.

    Raises
    ------
    InputError
        If there is no event, a covariate says nothing of its own, or the hazard ratio is 0 or
        infinite because all events, or none, lie on one side of it.
    """
    times = one_time(np.asarray(times_s, dtype=np.float64))
    had = np.asarray(events, dtype=np.float64) > 0
    names = list(covariates)
    raw = np.column_stack([np.asarray(covariates[name], dtype=np.float64) for name in names])
    design = raw - raw.mean(axis=0)
    if not had.any():
        raise InputError("nobody had the event, so there are no hazards to compare")
    if np.linalg.matrix_rank(design) < design.shape[1]:
        raise InputError(f"{' and '.join(names)} cannot be told apart in these data")
    risks = _risk_sets(times, had)
    fit = _maximise(design, risks, names)
    likelihood, information = fit[1], fit[2]
    coefficients = fit[0]
    naive = np.linalg.inv(information)
    who = np.arange(times.size) if people is None else np.unique(people, return_inverse=True)[1]
    repeated = int(who.max()) + 1 < times.size
    covariance = naive
    if repeated:
        scores = _score_residuals(design, coefficients, risks)
        totals = np.stack([np.bincount(who, column) for column in scores.T], axis=1)
        covariance = naive @ (totals.T @ totals) @ naive
    wald = float(coefficients @ np.linalg.pinv(covariance, hermitian=True) @ coefficients)
    half = float(norm.isf((1 - confidence) / 2))
    errors, plain = np.sqrt(np.diag(covariance)), np.sqrt(np.diag(naive))
    return Cox(
        n=times.size,
        events=int(had.sum()),
        people=int(who.max()) + 1,
        effects={
            name: _effect(float(beta), float(one), float(two) if repeated else None, half)
            for name, beta, one, two in zip(names, coefficients, plain, errors, strict=True)
        },
        log_likelihood=likelihood,
        likelihood_ratio=2 * (likelihood - _likelihood(design, np.zeros(len(names)), risks)[0]),
        wald=wald,
        df=len(names),
        p=float(chi2.sf(wald, len(names))),
    )


def _effect(beta: float, plain: float, robust: float | None, half: float) -> HazardRatio:
    error = plain if robust is None else robust
    z = beta / error
    return HazardRatio(
        ratio=float(np.exp(beta)),
        low=float(np.exp(beta - half * error)),
        high=float(np.exp(beta + half * error)),
        coefficient=beta,
        standard_error=plain,
        robust_error=robust,
        z=z,
        p=float(2 * norm.sf(abs(z))),
    )


def _risk_sets(times: Floats, had: NDArray[np.bool_]) -> list[_Risk]:
    found = []
    for moment in np.unique(times[had]):
        dying = np.flatnonzero((times == moment) & had)
        shares = np.arange(dying.size) / dying.size
        found.append(_Risk(dying, np.flatnonzero(times >= moment), shares))
    return found


def _maximise(design: Floats, risks: list[_Risk], names: list[str]) -> tuple[Floats, float, Floats]:
    """Return coefficients, log likelihood and information, by Newton's method with halved steps."""
    beta = np.zeros(design.shape[1])
    value, score, information = _likelihood(design, beta, risks)
    spread = design.std(axis=0)
    for _ in range(MOST_STEPS):
        step = np.linalg.lstsq(information, score, rcond=None)[0]
        gain = float(step @ score)
        while True:
            there = _likelihood(design, beta + step, risks)
            if there[0] >= value or np.abs(step).max() < CONVERGED:
                break
            step = step / 2
        beta = beta + step
        value, score, information = there
        if np.linalg.matrix_rank(information, hermitian=True) < beta.size or np.any(
            np.sqrt(np.diag(np.linalg.inv(information))) * spread > UNBOUNDED
        ):
            break
        if abs(gain) <= CONVERGED * max(abs(value), 1.0):
            return beta, value, information
    worst = names[int(np.argmax(np.abs(beta) * spread))]
    raise NoHazardRatioError(worst)


def _likelihood(design: Floats, beta: Floats, risks: list[_Risk]) -> tuple[float, Floats, Floats]:
    """Return Efron's log partial likelihood, its gradient and minus its second derivative."""
    linear = design @ beta
    weights = np.exp(linear - linear.max())
    value, p = 0.0, beta.size
    score, information = np.zeros(p), np.zeros((p, p))
    for risk in risks:
        totals, means, second = _moments(design, weights, risk)
        value += float(linear[risk.dying].sum() - np.log(totals).sum())
        value -= float(linear.max()) * risk.dying.size
        score += design[risk.dying].sum(axis=0) - means.sum(axis=0)
        information += second - means.T @ means
    return value, score, information


def _moments(design: Floats, weights: Floats, risk: _Risk) -> tuple[Floats, Floats, Floats]:
    """Return each denominator, shape (d,), its mean covariates (d, p), and the sum of squares."""
    x, w = design[risk.at_risk], weights[risk.at_risk]
    dx, dw = design[risk.dying], weights[risk.dying]
    totals = w.sum() - risk.shares * dw.sum()
    means = ((w @ x)[None, :] - risk.shares[:, None] * (dw @ dx)) / totals[:, None]
    second = (x * w[:, None]).T @ x * np.sum(1 / totals)
    second = second - (dx * dw[:, None]).T @ dx * np.sum(risk.shares / totals)
    return totals, means, second


def _score_residuals(design: Floats, beta: Floats, risks: list[_Risk]) -> Floats:
    """Return what each course adds to the score, shape (n, p), as R's ``coxph`` with Efron ties."""
    linear = design @ beta
    weights = np.exp(linear - linear.max())
    residuals = np.zeros_like(design)
    for risk in risks:
        totals, means, _ = _moments(design, weights, risk)
        out = np.zeros(design.shape[0])
        out[risk.dying] = 1.0
        residuals[risk.dying] += design[risk.dying] - means.mean(axis=0)
        for total, mean, share in zip(totals, means, risk.shares, strict=True):
            here = risk.at_risk
            hazard = weights[here] * (1 - share * out[here]) / total
            residuals[here] -= hazard[:, None] * (design[here] - mean)
    return residuals
