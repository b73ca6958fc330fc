"""What withdrawals do to a result: sensitivity tests and a comparison of counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from vrcomfort.stats.signed_rank import PValue, SignedRank, Zeros, signed_rank

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from vrcomfort.stats.ranks import Alternative


def worst_rank(
    differences: ArrayLike,
    lost: ArrayLike,
    *,
    zeros: Zeros = "pratt",
    alternative: Alternative = "two-sided",
    p_value: PValue = "exact",
) -> SignedRank:
    """Repeat a signed-rank test with participants who could not be paired.

    Each lost participant gets a difference larger than any observed, so only its rank and sign
    matter (Lachin 1999, worst-rank score). The result has neither shift nor
    effect size: they would be those of the assumption.

    Parameters
    ----------
    differences
        Observed integer differences, first minus second, shape (n,).
    lost
        Assumed sign of each lost participant: 1 where the first condition was worse, −1 where
        the second was, 0 for no difference. Shape (m,).
    """
    observed = np.asarray(differences, dtype=np.int64)
    signs = np.asarray(lost, dtype=np.int64)
    largest = int(np.max(np.abs(observed), initial=0))
    together = np.concatenate([observed, np.sign(signs) * (largest + 1)])
    return signed_rank(
        together, zeros=zeros, alternative=alternative, p_value=p_value, intervals=False
    )


def fisher_exact(counts: ArrayLike) -> float:
    """Two-sided p of Fisher's exact test for a 2 × 2 table of counts."""
    return float(stats.fisher_exact(np.asarray(counts, dtype=np.int64)).pvalue)
