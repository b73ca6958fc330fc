"""Simulated studies of few people, and what models of incomplete data, times and effect sizes say.

Scores are those of `calibration_studies`, and ``tied``: whole answers from 0 to 3 around a level of
each person. A fifth of the scores is missing at random for the mixed model. Times to leaving are
exponential with a level of each person (SD 0.7 of its logarithm) under A and B, the effect being
the logarithm of the hazard ratio, and are watched until seven in ten have left under B. A study
without an interval counts as one that covers; of curves, how many have none is counted.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from bench.calibration_studies import BLOCK, DRAWS, GENERATORS, LEVEL, SEED, SHARES, Random, holds
from vrcomfort.errors import InputError
from vrcomfort.stats.cluster_robust import cluster_robust
from vrcomfort.stats.correlation import correlation
from vrcomfort.stats.mixed import Estimate, t_estimate
from vrcomfort.stats.random_intercept import fit_random_intercept
from vrcomfort.stats.survival import kaplan_meier, log_rank
from vrcomfort.stats.t_tests import paired_t

Floats = NDArray[np.float64]
SCORES = ("ssq", "heavy", "tied")
MISSING, FRAILTY, LEFT = 0.2, 0.7, 0.7


def _tied(random: Random, n: int, effect: float) -> NDArray[np.int64]:
    felt = 1.5 + random.normal(0, 1, (n, 1)) + effect * SHARES + random.normal(0, 1, (n, 3))
    return np.asarray(np.clip(np.floor(felt), 0, 3), dtype=np.int64)


DRAWN = {**GENERATORS, "tied": _tied}


@cache
def truths(generator: str, effect: float) -> dict[str, float]:
    """Return the mean difference of A and B, d_z and both correlations, from a million people."""
    random = np.random.default_rng([SEED, 2])
    draw = DRAWN[generator]
    a, b, _ = np.concatenate([draw(random, BLOCK, effect) for _ in range(DRAWS // BLOCK)]).T
    d = (a - b).astype(np.float64)
    return {
        "difference": float(d.mean()),
        "d_z": float(d.mean() / d.std()),
        "pearson": float(np.corrcoef(a, b)[0, 1]),
        "spearman": float(np.corrcoef(rankdata(a), rankdata(b))[0, 1]),
    }


def study(generator: str, n: int, effect: float, number: int) -> dict[str, bool]:
    """Simulate one study and return its outcomes."""
    place = [3, [*SCORES, "times"].index(generator), n, int(10 * effect), number]
    random = np.random.default_rng([SEED, *place])
    if generator == "times":
        return _times(random, n, effect)
    scores = DRAWN[generator](random, n, effect)
    truth = truths(generator, effect)
    mixed = _mixed(scores.astype(np.float64), random)
    t = paired_t(scores[:, 0] - scores[:, 1])
    r = {of: correlation(*scores[:, :2].T, method=of) for of in ("pearson", "spearman")}
    return {
        "mixed model rejects": mixed is not None and (mixed.p or 1.0) <= LEVEL,
        "mixed model covers": holds(mixed, truth["difference"]),
        "d_z covers": t is None or holds(t.cohen_d_interval, truth["d_z"]),
        "Pearson covers": holds(r["pearson"], truth["pearson"]),
        "Spearman covers": holds(r["spearman"], truth["spearman"]),
    }


def _mixed(scores: Floats, random: Random) -> Estimate | None:
    """Return A minus B of the model with CR2 errors, without a fifth of the scores."""
    there = random.random(scores.shape) >= MISSING
    who, condition = np.nonzero(there)
    design = np.column_stack([np.ones(who.size), condition == 0, condition == 2]).astype(float)
    groups = np.unique(who, return_inverse=True)[1]
    try:
        fit = fit_random_intercept(scores[there], design, groups)
    except InputError:
        return None
    robust, row = cluster_robust(fit, scores[there], design, groups), np.array([0.0, 1.0, 0.0])
    error, df = robust.standard_error(row), robust.degrees_of_freedom(row)
    return t_estimate(float(row @ fit.coefficients), error, df, 0.95)


@cache
def _planned_end(effect: float) -> float:
    """Return the time by which `LEFT` of those under B have left."""
    random = np.random.default_rng([SEED, 4])
    return float(np.quantile(_leaving(random, DRAWS, effect)[:, 1], LEFT))


def _leaving(random: Random, n: int, effect: float) -> Floats:
    level = random.normal(0, FRAILTY, (n, 1))
    rates = np.exp(level + effect * np.array([1.0, 0.0]))
    return np.asarray(random.exponential(1 / rates), dtype=np.float64)


@cache
def _share_left(effect: float) -> float:
    """Return the share under A who are there at half of the planned time."""
    random = np.random.default_rng([SEED, 5])
    return float(np.mean(_leaving(random, DRAWS, effect)[:, 0] > _planned_end(effect) / 2))


def _times(random: Random, n: int, effect: float) -> dict[str, bool]:
    end = _planned_end(effect)
    left = _leaving(random, n, effect)
    times, events = np.minimum(left, end), left <= end
    (half,) = kaplan_meier(times[:, 0], events[:, 0]).at([end / 2]) or (None,)
    try:
        people = np.repeat(np.arange(n), 2)
        p = log_rank(times.ravel(), events.ravel(), ["a", "b"] * n, strata=people).p
    except InputError:
        p = 1.0
    return {
        "log-rank within people rejects": p <= LEVEL,
        "Kaplan–Meier covers": holds(half, _share_left(effect)),
        "Kaplan–Meier has no interval": half is None or half.low is None,
    }
