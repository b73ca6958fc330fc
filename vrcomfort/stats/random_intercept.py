"""A linear model with one random intercept, fitted by restricted maximum likelihood.

With V = σ²(I + λ J) in each group (J all ones), the restricted likelihood has a closed form in
λ = τ²/σ² alone: the fixed effects and σ² are functions of it (Bates et al. 2015, section 3.4). So
the fit is the search for the roots of one derivative, which is written out here, and the second
derivatives that Satterthwaite's degrees of freedom need are written out as well. Values are split
into means of groups and what is left within them, so that nothing is lost to cancellation.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq
from scipy.special import fdtrc

from vrcomfort.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RATIOS = np.concatenate([[0.0], np.logspace(-6, 8, 57)])
"""Between which λ, times the mean size of a group, the search looks for minima."""
FLAT = 1e-10
"""Slope of the deviance at λ = 0, for each value, that is rounding: the minimum is there."""
ROUNDING = 1e-20
"""Share of the sum of squares below which what is left within groups is rounding."""


@dataclass(frozen=True)
class FTest:
    """An omnibus test of several fixed effects; None where too few groups allow no test."""

    f: float | None
    df_effect: int
    df_error: float | None
    p: float | None


@dataclass(frozen=True)
class _Curve:
    """Parts of the restricted deviance at one λ, or at several (leading axes)."""

    weights: Floats
    """n / (1 + n λ) per group: what a group's mean counts."""
    information: Floats
    """X' W⁻¹ X, shape (p, p), with W = V/σ²."""
    coefficients: Floats
    squares: Floats
    """Generalised sum of squares of the residuals."""
    residual_means: Floats


@dataclass(frozen=True)
class RandomIntercept:
    """A fit. `covariance` is (X' V⁻¹ X)⁻¹ at the fitted components: the GLS errors of lme4."""

    coefficients: Floats
    covariance: Floats
    residual_variance: float
    group_variance: float
    _gradients: Floats
    """Derivatives of `covariance` in σ² and in λ, shape (2, p, p)."""
    _components: Floats
    """Covariance of the estimates of σ² and λ, shape (2, 2)."""

    def standard_error(self, contrast: Floats) -> float:
        """Return the standard error of a contrast of the coefficients, shape (p,)."""
        return float(np.sqrt(contrast @ self.covariance @ contrast))

    def degrees_of_freedom(self, contrast: Floats) -> float:
        """Return Satterthwaite's df of a contrast of the coefficients, shape (p,)."""
        variance = float(contrast @ self.covariance @ contrast)
        gradient = np.array([contrast @ part @ contrast for part in self._gradients])
        return 2 * variance**2 / float(gradient @ self._components @ gradient)

    def omnibus(self, contrasts: Floats) -> FTest:
        """Test that all contrasts (rows, shape (q, p), independent) are zero.

        F is the mean of the squared t of the q uncorrelated contrasts; its df are those of Fai &
        Cornelius (1996), as in R's ``lmerTest`` (Kuznetsova et al. 2017). F does not depend on
        which contrasts say the same; in unbalanced data its df do (162 or 138 for nine conditions
        that few people met), so it is to be said which were taken.
        """
        variances, rotation = np.linalg.eigh(contrasts @ self.covariance @ contrasts.T)
        uncorrelated = rotation.T @ contrasts
        f = float(np.mean((uncorrelated @ self.coefficients) ** 2 / variances))
        each = np.array([self.degrees_of_freedom(row) for row in uncorrelated])
        df = _fai_cornelius(each)
        return FTest(f, each.size, df, float(fdtrc(each.size, df, f)))


def _fai_cornelius(df: Floats) -> float:
    if np.ptp(df) < 1e-8 * df.max():
        return float(df.mean())
    if df.min() <= 2:
        return 2.0
    expected = float(np.sum(df / (df - 2)))
    return 2 * expected / (expected - df.size)


def fit_random_intercept(
    values: Floats, design: Floats, groups: NDArray[np.int64]
) -> RandomIntercept:
    """Fit ``values ~ design + (1 | group)``.

    Parameters
    ----------
    values
        Shape (n,).
    design
        Shape (n, p), of full column rank, with a column of ones.
    groups
        Number of each value's group, from 0, shape (n,).

    Raises
    ------
    InputError
        If two variances cannot be told from these data.
    """
    likelihood = _Likelihood(values - values.mean(), design, groups)
    ratio = likelihood.best_ratio()
    fit = likelihood.fit(ratio)
    fit.coefficients[0] += values.mean()
    return fit


def fit_independent(values: Floats, design: Floats) -> RandomIntercept:
    """Fit ``values ~ design`` by least squares: the same model, where no group has two values.

    Raises
    ------
    InputError
        If no residual, or no variance of residuals, is left.
    """
    df = values.size - design.shape[1]
    if df < 1:
        raise InputError("too few values for a linear model")
    coefficients: Floats = np.linalg.lstsq(design, values, rcond=None)[0].astype(np.float64)
    squares = float(np.sum((values - design @ coefficients) ** 2))
    if squares <= ROUNDING * float(np.sum((values - values.mean()) ** 2)):
        raise InputError("the scores leave no variance to model")
    variance = squares / df
    inverse = np.linalg.inv(design.T @ design)
    gradients = np.stack([inverse, np.zeros_like(inverse)])
    components = np.diag([2 * variance**2 / df, 0.0])
    return RandomIntercept(coefficients, variance * inverse, variance, 0.0, gradients, components)


class _Likelihood:
    """The restricted deviance (−2 log likelihood without constants) as a function of λ."""

    def __init__(self, values: Floats, design: Floats, groups: NDArray[np.int64]) -> None:
        self._sizes = np.bincount(groups).astype(np.float64)
        self._value_means = np.bincount(groups, values) / self._sizes
        self._design_means = np.stack(
            [np.bincount(groups, column) / self._sizes for column in design.T], axis=1
        )
        self._inner_values = values - self._value_means[groups]
        self._inner_design = design - self._design_means[groups]
        self._inner_information = self._inner_design.T @ self._inner_design
        self._inner_products = self._inner_design.T @ self._inner_values
        self._df = values.size - design.shape[1]
        self._require_two_variances(values.size, float(np.sum(values**2)))

    def _require_two_variances(self, n: int, squares: float) -> None:
        within = n - self._sizes.size - int(np.linalg.matrix_rank(self._inner_design))
        if within < 1 or within >= self._df:
            if self._sizes.max() == 1:
                raise InputError("no participant has two values, as a mixed model needs")
            raise InputError("too few values for a mixed model")
        solved = np.linalg.lstsq(self._inner_design, self._inner_values, rcond=None)[0]
        left = self._inner_values - self._inner_design @ solved
        if float(np.sum(left**2)) <= ROUNDING * squares:
            raise InputError("the scores leave no variance to model")

    def best_ratio(self) -> float:
        """Return the λ of the smallest deviance: 0, or the best root of its derivative."""
        ratios = RATIOS / self._sizes.mean()
        slopes = self._slopes(ratios)
        if abs(slopes[0]) < FLAT * self._sizes.sum():
            slopes[0] = 0.0
        found = [0.0] if slopes[0] >= 0 else []
        for (low, left), (high, right) in pairwise(zip(ratios, slopes, strict=True)):
            if left < 0 <= right:
                found.append(brentq(self._slope, low, high, xtol=1e-300, rtol=1e-14))
        if not found:
            raise InputError("the mixed model did not converge: no variance is left within people")
        return min(found, key=self._deviance)

    def _curve(self, ratio: float | Floats) -> _Curve:
        weights = self._sizes / (1 + self._sizes * np.asarray(ratio)[..., None])
        information = self._inner_information + self._moment(weights)
        products = self._inner_products + (weights * self._value_means) @ self._design_means
        solved = np.linalg.solve(information, products[..., None])[..., 0]
        coefficients = np.asarray(solved, dtype=np.float64)
        inner = self._inner_values - coefficients @ self._inner_design.T
        means = self._value_means - coefficients @ self._design_means.T
        squares = np.sum(inner**2, axis=-1) + np.sum(weights * means**2, axis=-1)
        return _Curve(weights, information, coefficients, squares, means)

    def _deviance(self, ratio: float) -> float:
        at = self._curve(ratio)
        spread = np.sum(np.log1p(self._sizes * ratio)) + np.linalg.slogdet(at.information)[1]
        return float(self._df * np.log(at.squares) + spread)

    def _slope(self, ratio: float) -> float:
        return float(self._slopes(np.float64(ratio)))

    def _slopes(self, ratio: Floats | np.float64) -> Floats:
        at = self._curve(ratio)
        steps = np.linalg.solve(at.information, self._moment(at.weights**2))
        determinants = np.sum(at.weights, axis=-1) - np.trace(steps, axis1=-2, axis2=-1)
        squares = np.sum((at.weights * at.residual_means) ** 2, axis=-1)
        slopes: Floats = determinants - self._df * squares / at.squares
        return slopes

    def _moment(self, weights: Floats) -> Floats:
        """Return the sum of w x̄ x̄' over groups; w² and w³ give derivatives of the information."""
        means = self._design_means
        moment: Floats = (means.T * weights[..., None, :]) @ means
        return moment

    def fit(self, ratio: float) -> RandomIntercept:
        """Return the fit at a minimum of the deviance."""
        at = self._curve(ratio)
        variance = float(at.squares) / self._df
        inverse = np.asarray(np.linalg.inv(at.information), dtype=np.float64)
        in_ratio = variance * inverse @ self._moment(at.weights**2) @ inverse
        return RandomIntercept(
            coefficients=at.coefficients,
            covariance=variance * inverse,
            residual_variance=variance,
            group_variance=variance * ratio,
            _gradients=np.stack([inverse, in_ratio]),
            _components=self._components(at, inverse, variance, at_edge=ratio == 0),
        )

    def _components(self, at: _Curve, inverse: Floats, variance: float, *, at_edge: bool) -> Floats:
        """Return twice the inverse Hessian of the deviance in σ² and λ.

        At λ = 0 the deviance has no slope of 0 there. In θ = √λ, which lme4 and lmerTest use, it
        has one, and λ does not change to first order: only σ² counts.
        """
        of_variance = self._df / variance**2
        if at_edge:
            return np.diag([2 / of_variance, 0.0])
        twice, thrice = self._moment(at.weights**2), self._moment(at.weights**3)
        pull = (at.weights**2 * at.residual_means) @ self._design_means
        bend = np.sum(at.weights**3 * at.residual_means**2) - pull @ inverse @ pull
        step = inverse @ twice
        of_determinants = 2 * np.trace(inverse @ thrice) - np.trace(step @ step)
        of_ratio = of_determinants - np.sum(at.weights**2) + 2 * bend / variance
        both = np.sum((at.weights * at.residual_means) ** 2) / variance**2
        hessian = np.array([[of_variance, both], [both, of_ratio]])
        return np.asarray(2 * np.linalg.inv(hessian), dtype=np.float64)
