"""Simulated studies of known truth, and the default tests' results on each.

A study has n participants under three conditions A, B and C, whole raw points, and an effect of δ
in A and δ/2 in C. Half of them had A before B. Generators:

- ``normal``: 30 + a level of SD 6 + 4 δ + an error of SD 4/√2, so that A − B ~ N(4 δ, 4²).
- ``ssq``: raw totals of 16 answers from 0 to 3, weighted as those of the SSQ. An answer is the
  whole part of 1 + level + δ/2 + how common the symptom is + an error. Without an effect 19 % of
  the totals are 0; mean 23.5 and SD 25.7 in points, skewness 1.7.
- ``heavy``: as ``normal``, level and errors t with 2.5 degrees of freedom, of scale 3 and 2.1.
- ``tied``: whole answers from 0 to 3, the whole part of 1.5 + level + δ + an error, of SD 1 each.
- ``log-normal``: the whole part of exp(level + δ + error) of SD 0.9 and 0.6: no bound above and a
  skewness of about 7, which questionnaires do not have.
- ``unequal``: as ``normal``, but C has an error of SD 12/√2, so there is no sphericity. A and B are
  those of ``normal``: tests of three conditions alone.

Estimands of A − B = D: the median of (D₁ + D₂)/2 (shift), P(D₁ + D₂ > 0) − P(D₁ + D₂ < 0) of
non-zero D (rank-biserial), and the mean; of A, the mean; of the three, λ/(λ + df + 1) (partial η²)
with the noncentrality λ of the variances of the generator (Steiger 2004). From 1,000,000 draws.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from vrcomfort.report.families import holds as in_interval
from vrcomfort.stats.anova import Cells, anova_of_cells
from vrcomfort.stats.means import mean_interval
from vrcomfort.stats.mixed import crossover, t_estimate
from vrcomfort.stats.rank_anova import friedman
from vrcomfort.stats.signed_rank import signed_rank

Integers = NDArray[np.int64]
Random = np.random.Generator
SEED, LEVEL = 20150323, 0.05
CONDITIONS = ("A", "B", "C")
SHARES = np.array([1.0, 0.0, 0.5])
"""Of the effect, that A, B and C have."""
WEIGHTS = np.array([2, 1, 1, 1, 2, 1, 1, 2, 2, 1, 2, 1, 1, 1, 1, 1])
"""Number of subscales of each item of the SSQ."""
COMMON = np.linspace(0.5, -1.3, WEIGHTS.size)
DRAWS, BLOCK = 1_000_000, 50_000


def _normal(random: Random, n: int, effect: float) -> Integers:
    level, errors = random.normal(30, 6, (n, 1)), random.normal(0, 8**0.5, (n, 3))
    return np.rint(level + 4 * effect * SHARES + errors).astype(np.int64)


def _ssq(random: Random, n: int, effect: float) -> Integers:
    level = random.normal(-0.55, 0.69, (n, 1)) + effect / 2 * SHARES + random.normal(0, 0.3, (n, 3))
    felt = level[:, :, None] + COMMON + random.normal(0, 0.8, (n, 3, WEIGHTS.size))
    return np.asarray(np.clip(np.floor(felt + 1), 0, 3).astype(np.int64) @ WEIGHTS, dtype=np.int64)


def _heavy(random: Random, n: int, effect: float) -> Integers:
    level, errors = random.standard_t(2.5, (n, 1)), random.standard_t(2.5, (n, 3))
    return np.rint(30 + 3 * level + 4 * effect * SHARES + 2.1 * errors).astype(np.int64)


def _log_normal(random: Random, n: int, effect: float) -> Integers:
    level, errors = random.normal(0.2, 0.9, (n, 1)), random.normal(0, 0.6, (n, 3))
    return np.floor(np.exp(level + effect * SHARES + errors)).astype(np.int64)


def _unequal(random: Random, n: int, effect: float) -> Integers:
    level, errors = random.normal(30, 6, (n, 1)), random.normal(0, 8**0.5, (n, 3)) * [1, 1, 3]
    return np.rint(level + 4 * effect * SHARES + errors).astype(np.int64)


def _tied(random: Random, n: int, effect: float) -> Integers:
    felt = 1.5 + random.normal(0, 1, (n, 1)) + effect * SHARES + random.normal(0, 1, (n, 3))
    return np.asarray(np.clip(np.floor(felt), 0, 3), dtype=np.int64)


GENERATORS: dict[str, Callable[[Random, int, float], Integers]] = {
    "normal": _normal,
    "ssq": _ssq,
    "heavy": _heavy,
    "log-normal": _log_normal,
    "unequal": _unequal,
    "tied": _tied,
}


@dataclass(frozen=True)
class Estimands:
    """Values that the intervals are to cover."""

    shift: float
    rank_biserial: float
    mean_difference: float
    mean: float
    noncentrality: float
    """Of the F of the three conditions, for each participant."""

    def partial_eta_squared(self, n: int) -> float:
        """Return it as a study of n participants has it."""
        found = n * self.noncentrality
        return found / (found + 2 + 2 * (n - 1) + 1)


@cache
def estimands(generator: str, effect: float) -> Estimands:
    """Return the estimands of a generator's studies."""
    random = np.random.default_rng([SEED, 1])
    draw = GENERATORS[generator]
    scores = np.concatenate([draw(random, BLOCK, effect) for _ in range(DRAWS // BLOCK)])
    d = scores[:, 0] - scores[:, 1]
    other = d[d != 0][: 2 * (np.count_nonzero(d) // 2)]
    centred = scores - scores.mean(axis=1, keepdims=True)
    means = centred.mean(axis=0)
    error = float(np.sum((centred - means) ** 2)) / (2 * DRAWS)
    return Estimands(
        shift=float(np.median(d[::2] + d[1::2])) / 2,
        rank_biserial=float(np.sign(other[::2] + other[1::2]).mean()),
        mean_difference=float(d.mean()),
        mean=float(scores[:, 0].mean()),
        noncentrality=float(np.sum(means**2)) / error if effect else 0.0,
    )


def holds(interval: object, value: float) -> bool:
    """Return whether an interval holds a value, as reports print it; without one, every value."""
    return interval is None or in_interval(interval, value)


def contradicts(interval: object, p: float | None) -> bool:
    """Return whether an interval with an end, and its p, say different things of 0."""
    ends = getattr(interval, "low", None), getattr(interval, "high", None)
    return p is not None and ends != (None, None) and (p <= LEVEL) == holds(interval, 0)


def study(generator: str, n: int, effect: float, number: int) -> dict[str, bool]:
    """Simulate one study and return its outcomes."""
    place = [list(GENERATORS).index(generator), n, int(10 * effect), number]
    scores = GENERATORS[generator](np.random.default_rng([SEED, 0, *place]), n, effect)
    truth = estimands(generator, effect)
    three = _three(scores, truth)
    return three if generator == "unequal" else {**_two(scores, truth), **three}


def _two(scores: Integers, truth: Estimands) -> dict[str, bool]:
    differences = scores[:, 0] - scores[:, 1]
    test = signed_rank(differences)
    effect, n = test.effect, differences.size
    # What `paired_t` prints, without pingouin's Bayes factor (25 times the time).
    t = t_estimate(float(differences.mean()), float(differences.std(ddof=1)) / n**0.5, n - 1, 0.95)
    a_first = np.arange(n) % 2 == 0
    first, second = np.where(a_first, *scores[:, :2].T), np.where(a_first, *scores[:, 1::-1].T)
    order = crossover(first, second, a_first).condition
    return {
        "signed-rank rejects": test.p <= LEVEL,
        "shift covers": holds(test.shift, truth.shift),
        "shift against p": contradicts(test.shift, test.p),
        "rank-biserial covers": holds(effect, truth.rank_biserial),
        "rank-biserial against p": contradicts(effect, test.p),
        "t rejects": t.p is not None and t.p <= LEVEL,
        "t covers": holds(t, truth.mean_difference),
        "t against p": contradicts(t, t.p),
        "mean of A covers": holds(mean_interval(scores[:, 0]), truth.mean),
        "crossover rejects": order.p is not None and order.p <= LEVEL,
        "crossover covers": holds(order, truth.mean_difference),
    }


def _three(scores: Integers, truth: Estimands) -> dict[str, bool]:
    data = Cells(scores.astype(np.float64), {"condition": CONDITIONS}, {}, ())
    line, ranks = anova_of_cells(data).effects[0], friedman(scores)
    eta = line.partial_eta_squared
    return {
        "F rejects": line.p is not None and line.p <= LEVEL,
        "GG rejects": (line.p_greenhouse_geisser or 1.0) <= LEVEL,
        "η² covers (90 %)": holds(eta, truth.partial_eta_squared(len(scores))),
        "η² against p of F": contradicts(eta, line.p),
        "Friedman rejects": (1.0 if ranks.p is None else ranks.p) <= LEVEL,
    }
