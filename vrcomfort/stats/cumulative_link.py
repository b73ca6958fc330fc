"""Cumulative logit models of ordered answers, with or without a random intercept.

P(answer ≤ j) = F(θ_j + N γ_j − X β − σ z), F the logistic function and z standard normal, one for
each group (McCullagh 1980; with random intercepts, Hedeker & Gibbons 1994). γ is of the effects
whose odds differ from cut to cut. The likelihood is integrated over z by adaptive Gauss–Hermite
quadrature (Pinheiro & Bates 1995) and maximised with its own derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Whole = NDArray[np.int64]

NODES = 25
"""Of the quadrature. From 15 on, the seventh digit of what the tests fit does not change."""
LEAST_SD = 1e-3
"""A smaller standard deviation between groups is none."""
LARGEST_ERROR = 30.0
"""Of a log odds ratio or threshold; larger ones are those of data that a line separates, whose
likelihood has no maximum."""
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
