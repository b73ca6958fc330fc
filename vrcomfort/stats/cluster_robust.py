"""Cluster-robust errors of a random-intercept model: CR2 with Satterthwaite's degrees of freedom.

The bias-reduced linearization of Bell & McCaffrey (2002), for weighted least squares and contrasts
as by Pustejovsky & Tipton (2018), with the fitted random-intercept covariance Φ as the working
model; R's ``clubSandwich`` is the oracle. With B = (X'Φ⁻¹X)⁻¹, each group's score is
X'Φ⁻¹ A e, where A = S (Φ² − S X B X' S)^(−1/2) S and S is the symmetric root of Φ. Under the
working model the covariances of the groups' parts of c'β are a diagonal minus a product of p
columns, so that sums over all pairs of groups cost p² for each group.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import fdtrc

from vrcomfort.stats.random_intercept import FTest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from vrcomfort.stats.random_intercept import RandomIntercept

    Floats = NDArray[np.float64]

ROUNDING = 1e-10
"""Share of the largest eigenvalue, before leverage is taken off, below which an eigenvalue
is 0: the group determines a coefficient alone (leverage 1), and the pseudo-inverse is taken."""
NO_VARIANCE = 1e-14
"""Share of a contrast's variance under the model below which its robust variance is rounding."""
DETERMINED = 1e-6
"""Share of a contrast's variance that a group with leverage 1 may hide."""


@dataclass(frozen=True)
class ClusterRobust:
    """CR2 errors of the coefficients of a fit; k groups, p coefficients."""

    coefficients: Floats
    covariance: Floats
    """Shape (p, p)."""
    _model: Floats
    """Covariance under the working model, which CR2's is expected to be there."""
    _roots: Floats
    """Φ^½ A Φ⁻¹ X B of each group, in a basis of the range of its design: shape (k, r, p)."""
    _shared: Floats
    """(A Φ⁻¹ X B)' X B^½ of each group: what residuals of all groups share, shape (k, p, p)."""

    def standard_error(self, contrast: Floats) -> float:
        """Return the standard error of a contrast of the coefficients, shape (p,)."""
        variance = float(contrast @ self.covariance @ contrast)
        rounding = NO_VARIANCE * float(contrast @ self._model @ contrast)
        return float(np.sqrt(variance)) if variance > rounding else 0.0

    def degrees_of_freedom(self, contrast: Floats) -> float:
        """Return Satterthwaite's df of a contrast of the coefficients, shape (p,).

        0 where a single group determines the contrast: its residuals are 0 whatever it answered,
        and nothing says how far the estimate may be off.
        """
        own, shared = self._parts(contrast[None])
        trace = float(own.sum() - np.sum(shared**2))
        if trace < (1 - DETERMINED) * float(contrast @ self._model @ contrast):
            return 0.0
        return trace**2 / _products(own[0, 0], own[0, 0], shared[0], shared[0])

    def omnibus(self, contrasts: Floats) -> FTest:
        """Test that all contrasts (rows, shape (q, p), independent) are zero.

        Hotelling's T² with the degrees of freedom of Tipton & Pustejovsky (2015), "HTZ" in
        ``clubSandwich``: F = Q (η − q + 1) / (η q), on q and η − q + 1 df. There is no test where
        these are none, or the errors of some contrast are 0.
        """
        q = len(contrasts)
        tested = all(
            self.degrees_of_freedom(c) > 0 and self.standard_error(c) > 0 for c in contrasts
        )
        errors = contrasts @ self.covariance @ contrasts.T
        eta = self._eta(contrasts) if tested else 0.0
        df = eta - q + 1
        if df <= 0 or np.linalg.matrix_rank(errors, hermitian=True) < q:
            return FTest(None, q, None, None)
        estimate = contrasts @ self.coefficients
        f = float(estimate @ np.linalg.solve(errors, estimate)) * df / (eta * q)
        return FTest(f, q, df, float(fdtrc(q, df, f)))

    def _eta(self, contrasts: Floats) -> float:
        """Return the degrees of freedom of the Wishart matrix that the errors resemble; 0: none."""
        q = len(contrasts)
        own, shared = self._parts(contrasts)
        values, vectors = np.linalg.eigh(own.sum(axis=2) - np.einsum("skp,tkp->st", shared, shared))
        if values[0] <= ROUNDING * values[-1]:
            return 0.0
        own, shared = self._parts((vectors / np.sqrt(values)) @ vectors.T @ contrasts)
        spread = sum(
            _products(own[s, s], own[t, t], shared[s], shared[t])
            + _crossed(own[s, t], shared[s], shared[t])
            for s in range(q)
            for t in range(q)
        )
        return q * (q + 1) / spread

    def _parts(self, contrasts: Floats) -> tuple[Floats, Floats]:
        """Return diagonals, shape (q, q, k), and shared columns, shape (q, k, p), of each pair."""
        roots = np.einsum("krp,qp->qkr", self._roots, contrasts)
        own = np.einsum("skr,tkr->stk", roots, roots)
        return own, np.einsum("kpc,qp->qkc", self._shared, contrasts)


def _products(one: Floats, two: Floats, left: Floats, right: Floats) -> float:
    """Sum the products of the entries of (diag(one) − L L') and (diag(two) − R R')."""
    diagonal = one * two - one * np.sum(right**2, axis=1) - two * np.sum(left**2, axis=1)
    return float(diagonal.sum() + np.sum((left.T @ right) ** 2))


def _crossed(own: Floats, left: Floats, right: Floats) -> float:
    """Return the trace of the square of diag(own) − L R'."""
    both = right.T @ left
    return float(np.sum(own**2 - 2 * own * np.sum(left * right, axis=1)) + np.sum(both * both.T))


def cluster_robust(
    fit: RandomIntercept, values: Floats, design: Floats, groups: NDArray[np.int64]
) -> ClusterRobust:
    """Return the CR2 errors of a fit, of the same arguments as `fit_random_intercept`."""
    bread, p = fit.covariance, design.shape[1]
    bread_root = np.linalg.cholesky(bread)
    residuals = values - design @ fit.coefficients
    covariance = np.zeros((p, p))
    roots, shared = [], []
    for x, e, ones in _by_size(design, residuals, groups):
        root, inverse, square = _working(fit, ones)
        scaled = root @ x
        left = square - scaled @ bread @ scaled.swapaxes(1, 2)
        influence = root @ _inverse_root(left, square) @ root @ inverse @ x @ bread
        parts = np.einsum("krp,kr->kp", influence, e)
        covariance += parts.T @ parts
        roots.append(np.pad(root @ influence, ((0, 0), (0, p - x.shape[1]), (0, 0))))
        shared.append(influence.swapaxes(1, 2) @ x @ bread_root)
    found = (np.concatenate(roots), np.concatenate(shared))
    return ClusterRobust(fit.coefficients, covariance, bread, *found)


def _by_size(
    design: Floats, residuals: Floats, groups: NDArray[np.int64]
) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Yield design, residuals and a column of ones of all groups of one size.

    In an orthonormal basis of the range of each design, which holds the ones: shapes (k, r, p),
    (k, r) and (k, r), r = min(size, p). What lies outside it has no part in any score.
    """
    order = np.argsort(groups, kind="stable")
    sizes = np.bincount(groups)
    first = np.cumsum(sizes) - sizes
    for n in np.unique(sizes):
        rows = order[first[sizes == n][:, None] + np.arange(n)]
        basis, x = np.linalg.qr(design[rows])
        yield x, np.einsum("knr,kn->kr", basis, residuals[rows]), basis.sum(axis=1)


def _working(fit: RandomIntercept, ones: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the symmetric root of Φ, its inverse and its square, shape (k, r, r)."""
    variance, ratio = fit.residual_variance, fit.group_variance / fit.residual_variance
    n = float(ones[0] @ ones[0])
    unit, all_ones = np.eye(ones.shape[1]), ones[:, :, None] * ones[:, None, :]
    of_root = (np.sqrt(1 + ratio * n) - 1) / n
    return (
        np.sqrt(variance) * (unit + of_root * all_ones),
        (unit - ratio / (1 + ratio * n) * all_ones) / variance,
        variance**2 * (unit + (2 * ratio + ratio**2 * n) * all_ones),
    )


def _inverse_root(matrices: Floats, whole: Floats) -> Floats:
    """Return the inverse square root of symmetric matrices, (k, r, r); pseudo where singular.

    `whole` is what they were before the leverage was taken off: of a group with leverage 1 in all
    its rows, nothing but rounding may be left.
    """
    values, vectors = np.linalg.eigh(matrices)
    positive = values > ROUNDING * np.linalg.eigvalsh(whole)[:, -1:]
    scales = np.where(positive, 1 / np.sqrt(np.where(positive, values, 1.0)), 0.0)
    found: Floats = (vectors * scales[:, None, :]) @ vectors.swapaxes(1, 2)
    return found
