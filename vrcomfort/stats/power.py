"""Power of tests of paired differences, by simulation; of the t test also by its formula."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from vrcomfort.stats.packages import quiet
from vrcomfort.stats.proportions import wilson_bounds
from vrcomfort.stats.signed_rank import signed_rank
from vrcomfort.stats.t_tests import p_of_t

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vrcomfort.stats.ranks import Alternative
    from vrcomfort.stats.signed_rank import PValue, Zeros

    Floats = NDArray[np.float64]

STEPS_PER_SD = 1e6
"""Normal differences are rounded to this, for rank tests are made on whole numbers: no ties."""
SEARCH_STEPS = 12
"""Of the bisection for the smallest effect: to 5/2¹² = .001 standard deviations."""
# In standard deviations of the differences; a test that misses it finds none, however large.
LARGEST_EFFECT = 5.0


@dataclass(frozen=True)
class PairedTest:
    """A test of paired differences, as a plan has it.

    Parameters
    ----------
    name
        ``signed_rank`` or ``paired_t``.
    alpha
        Level: a study finds a difference where p is at most this.
    """

    name: Literal["signed_rank", "paired_t"] = "signed_rank"
    alternative: Alternative = "two-sided"
    alpha: float = 0.05
    zeros: Zeros = "pratt"
    p_value: PValue = "exact"

    def p(self, differences: NDArray[np.int64]) -> float:
        """Return p of whole differences, shape (n,)."""
        if self.name == "paired_t":
            return paired_t_p(differences.astype(np.float64), self.alternative)
        return signed_rank(
            differences,
            zeros=self.zeros,
            alternative=self.alternative,
            p_value=self.p_value,
            intervals=False,
        ).p


@dataclass(frozen=True)
class NormalDifferences:
    """Differences that are normal, with a mean of `effect_sd` standard deviations."""

    effect_sd: float

    def draw(self, random: np.random.Generator, n: int) -> NDArray[np.int64]:
        """Return the differences of a study of n people, as whole numbers."""
        values = random.normal(self.effect_sd, 1.0, n)
        return np.asarray(np.rint(STEPS_PER_SD * values), dtype=np.int64)


@dataclass(frozen=True)
class ResampledDifferences:
    """Differences of a pilot study, drawn with replacement and moved to another mean.

    Parameters
    ----------
    differences
        Whole differences of the pilot's people.
    effect_steps
        Mean difference wanted, in steps of the score; None: the pilot's own.

    Notes
    -----
    Moved differences are rounded to whole steps at random, up as often as the fraction says, so
    that their mean is the one wanted and scores keep their steps, ties and zeros.
    """

    differences: tuple[int, ...]
    effect_steps: float | None = None

    def draw(self, random: np.random.Generator, n: int) -> NDArray[np.int64]:
        """Return the differences of a study of n people, as whole numbers."""
        drawn = random.choice(np.array(self.differences, dtype=np.int64), n)
        if self.effect_steps is None:
            return drawn
        moved = drawn + (self.effect_steps - float(np.mean(self.differences)))
        whole = np.floor(moved)
        return np.asarray(whole + (random.random(n) < moved - whole), dtype=np.int64)


Generator = NormalDifferences | ResampledDifferences


class Power(NamedTuple):
    """How many of the simulated studies found the difference, with Wilson's interval."""

    found: int
    studies: int
    low: float
    high: float

    @property
    def share(self) -> float:
        """Return the power."""
        return self.found / self.studies


def p_values(
    tests: tuple[PairedTest, ...], generator: Generator, n: int, seed: list[int], studies: int
) -> Floats:
    """Return p of each test in each simulated study of n people, shape (studies, tests)."""
    random = np.random.default_rng(seed)
    found = np.empty((studies, len(tests)))
    for study in range(studies):
        differences = generator.draw(random, n)
        found[study] = [test.p(differences) for test in tests]
    return found


def power_of(p: Floats, alpha: float, confidence: float = 0.95) -> Power:
    """Return the share of p values at or below a level, shape (studies,)."""
    found = int(np.count_nonzero(p <= alpha))
    return Power(found, len(p), *wilson_bounds(found, len(p), confidence))


def paired_t_p(differences: Floats, alternative: Alternative) -> float:
    """Return p of the paired t test; 1 where no difference varies."""
    sd = float(differences.std(ddof=1))
    if sd == 0:
        return 1.0
    t = float(differences.mean()) / sd * math.sqrt(differences.size)
    return p_of_t(t, differences.size - 1, alternative)


def t_test_power(effect_sd: float, n: int, alpha: float, alternative: Alternative) -> float:
    """Return the power of the paired t test of normal differences (noncentral t, statsmodels)."""
    from statsmodels.stats.power import TTestPower  # noqa: PLC0415 - a second to load

    sides = {"two-sided": "two-sided", "greater": "larger", "less": "smaller"}
    with quiet():
        power = TTestPower().power(effect_sd, n, alpha, alternative=sides[alternative])
    return float(power)


def smallest_effect(
    test: PairedTest, n: int, *, power: float, studies: int, seed: int
) -> float | None:
    """Return the smallest effect that a study of n people finds with this power, in SD.

    Differences are normal; the same draws are moved by each effect that is tried, so that power
    rises with it. One-sided tests for smaller values have a negative effect.

    Returns
    -------
    float or None
        None where even `LARGEST_EFFECT` is not enough, as with too few people for any test.
    """
    random = np.random.default_rng([seed, n])
    noise = random.normal(size=(studies, n))
    sign = -1.0 if test.alternative == "less" else 1.0

    def enough(effect: float) -> bool:
        moved = np.rint(STEPS_PER_SD * (noise + sign * effect)).astype(np.int64)
        return sum(test.p(row) <= test.alpha for row in moved) >= power * studies

    low, high = 0.0, LARGEST_EFFECT
    if not enough(high):
        return None
    for _ in range(SEARCH_STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return sign * high
