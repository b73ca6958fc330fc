"""Order statistics of Walsh averages, without making the n(n+1)/2 of them.

A Walsh average is the mean of two differences, or one of them. Of integers, twice the average is
an integer as well: the sums of pairs. They are counted by a binary search for each difference, so
one order statistic costs O(n log n) for each bit of the range (after Johnson & Mizoguchi 1978).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


class WalshSums:
    """The sums d_i + d_j, i ≤ j, of integers: twice the Walsh averages."""

    def __init__(self, differences: ArrayLike) -> None:
        self._values: NDArray[np.int64] = np.sort(np.asarray(differences, dtype=np.int64))
        self.count = self._values.size * (self._values.size + 1) // 2

    def at_most(self, bound: int) -> int:
        """Return how many sums are ≤ `bound`."""
        ordered = int(np.searchsorted(self._values, bound - self._values, side="right").sum())
        own = int(np.searchsorted(2 * self._values, bound, side="right"))
        return (ordered + own) // 2  # pairs were counted twice, a difference with itself once

    def order_statistic(self, rank: int) -> int:
        """Return the sum of a 1-based rank from below."""
        low, high = 2 * int(self._values[0]), 2 * int(self._values[-1])
        while low < high:
            middle = (low + high) // 2
            if self.at_most(middle) >= rank:
                high = middle
            else:
                low = middle + 1
        return low

    def median_of_four(self) -> int:
        """Return four times the median Walsh average, which is an integer."""
        below, above = (self.count + 1) // 2, self.count // 2 + 1
        first = self.order_statistic(below)
        return first + (first if above == below else self.order_statistic(above))

    def below(self, bound: int) -> int | None:
        """Return the largest sum < `bound`."""
        places = np.searchsorted(self._values, bound - self._values, side="left") - 1
        first = np.flatnonzero(places >= 0)
        sums = self._values[first] + self._values[places[first]]
        return int(sums.max()) if sums.size else None
