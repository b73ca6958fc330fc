"""Simulated studies of few people: models of incomplete data, two groups, times and effect sizes.

Scores are those of `calibration_studies`. A fifth of them is missing at random for the mixed model.
Two groups are the scores of one half of the people under A and of the other half under B. Times to
leaving are exponential with a level of each person (SD 0.7 of its logarithm) under A and B, the
effect being the logarithm of the hazard ratio, and are watched until seven in ten have left under
B. A study without an interval counts as one that covers; of curves, how many have none is counted.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from bench.calibration_studies import (
    BLOCK,
    DRAWS,
    GENERATORS,
    LEVEL,
    SEED,
    Integers,
    Random,
    contradicts,
    holds,
)
from vrcomfort.errors import InputError
from vrcomfort.stats.cluster_robust import cluster_robust
from vrcomfort.stats.correlation import correlation
from vrcomfort.stats.mann_whitney import mann_whitney
from vrcomfort.stats.mixed import Estimate, t_estimate
from vrcomfort.stats.random_intercept import fit_random_intercept
from vrcomfort.stats.survival import kaplan_meier, log_rank
from vrcomfort.stats.t_tests import paired_t, two_sample_t

Floats = NDArray[np.float64]
SCORES = ("ssq", "heavy", "tied")
MISSING, FRAILTY, LEFT = 0.2, 0.7, 0.7


@cache
def truths(generator: str, effect: float) -> dict[str, float]:
    """Return what is true of A and B, from a million people; other people's B for two groups."""
    random = np.random.default_rng([SEED, 2])
    draw = GENERATORS[generator]
    a, b, _ = np.concatenate([draw(random, BLOCK, effect) for _ in range(DRAWS // BLOCK)]).T
    d, apart = (a - b).astype(np.float64), a - np.roll(b, 1)
    return {
        "difference": float(d.mean()),
        "d_z": float(d.mean() / d.std()),
        "shift of groups": float(np.median(apart)),
        "superiority": float(np.sign(apart).mean()),
        "g": float(d.mean() / np.sqrt((a.var() + b.var()) / 2)),
        "pearson": float(np.corrcoef(a, b)[0, 1]),
        "spearman": float(np.corrcoef(rankdata(a), rankdata(b))[0, 1]),
    }


def study(generator: str, n: int, effect: float, number: int) -> dict[str, bool]:
    """Simulate one study and return its outcomes."""
    place = [3, [*SCORES, "times"].index(generator), n, int(10 * effect), number]
    random = np.random.default_rng([SEED, *place])
    if generator == "times":
        return _times(random, n, effect)
    scores = GENERATORS[generator](random, n, effect)
    truth = truths(generator, effect)
    mixed = _mixed(scores.astype(np.float64), random)
    t = paired_t(scores[:, 0] - scores[:, 1])
    r = {of: correlation(*scores[:, :2].T, method=of) for of in ("pearson", "spearman")}
    return {
        "mixed model rejects": mixed is not None and _rejects(mixed.p),
        "mixed model covers": holds(mixed, truth["difference"]),
        "d_z covers": t is None or holds(t.cohen_d_interval, truth["d_z"]),
        "d_z against p": t is not None and contradicts(t.cohen_d_interval, t.p),
        "Spearman covers": holds(r["spearman"], truth["spearman"]),
        "Spearman against p": contradicts(r["spearman"], r["spearman"].p),
        "Pearson covers": holds(r["pearson"], truth["pearson"]),
        "Pearson against p": contradicts(r["pearson"], r["pearson"].p),
        **_groups(scores, truth),
    }


def _rejects(p: float | None) -> bool:
    return p is not None and p <= LEVEL


def _groups(scores: Integers, truth: dict[str, float]) -> dict[str, bool]:
    """Compare one half of the people under A with the other half under B."""
    half = len(scores) // 2
    a, b = scores[:half, 0], scores[half:, 1]
    ranks, t = mann_whitney(a, b), two_sample_t(a, b)
    assert ranks is not None  # noqa: S101 - both groups have people
    return {
        "Mann–Whitney rejects": ranks.p <= LEVEL,
        "shift of groups covers": holds(ranks.shift, truth["shift of groups"]),
        "shift of groups against p": contradicts(ranks.shift, ranks.p),
        "r of groups covers": holds(ranks.effect, truth["superiority"]),
        "r of groups against p": contradicts(ranks.effect, ranks.p),
        "Welch’s t rejects": t is not None and t.p <= LEVEL,
        "Welch’s t covers": holds(t, truth["difference"]),
        "g covers": t is None or holds(t.hedges_g, truth["g"]),
        "g against p": t is not None and contradicts(t.hedges_g, t.p),
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
