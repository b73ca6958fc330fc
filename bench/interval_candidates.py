"""Intervals of means and rank-biserials that were tried: `python -m bench.interval_candidates`.

Prints how often each covers, in 2,000 studies of the generators of `calibration_studies`: for the
mean of condition A without an effect, and for the rank-biserial of A − B with δ = 0.8.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from bench.calibration_studies import GENERATORS, SEED, estimands
from vrcomfort.stats import effects
from vrcomfort.stats.ranks import doubled_midranks

Floats = NDArray[np.float64]
Ends = tuple[Floats, Floats]
STUDIES, RESAMPLES, BLOCK = 2000, 799, 100
EFFECT = 0.8


def of_means(values: Floats, random: np.random.Generator) -> dict[str, Ends]:
    """Return the ends of each interval, of studies (rows) of n values."""
    rows, n = values.shape
    t = float(stdtrit(n - 1, 0.975))
    mean, error = values.mean(axis=1), values.std(axis=1, ddof=1) / np.sqrt(n)
    third = _skewness(values)
    moved = mean + third * error / (6 * np.sqrt(n))
    found = {
        "t": (mean - t * error, mean + t * error),
        "Johnson's t (1978)": (moved - t * error, moved + t * error),
    }
    for name, size in (("bootstrap-t", n), ("bootstrap-t of n − 1", n - 1)):
        drawn = values[
            np.arange(rows)[:, None, None], random.integers(0, n, (rows, RESAMPLES, size))
        ]
        ratio = _ratio(drawn, mean)
        most, least = _quantile(ratio, 0.975), _quantile(ratio, 0.025)
        found[name] = mean - most * error, mean - least * error
        if size == n:
            half = _quantile(np.abs(ratio), 0.95) * error
            found["symmetric bootstrap-t"] = mean - half, mean + half
            found["Hall (1992)"] = _hall(values, drawn, ratio)
    low, high = found["bootstrap-t of n − 1"]
    found["t or bootstrap-t of n − 1 (ours)"] = (
        np.minimum(low, mean - t * error), np.maximum(high, mean + t * error),
    )  # fmt: skip
    return found


def _ratio(drawn: Floats, mean: Floats) -> Floats:
    above = drawn.mean(axis=2) - mean[:, None]
    error = drawn.std(axis=2, ddof=1) / np.sqrt(drawn.shape[2])
    constant = np.where(above == 0, 0.0, np.copysign(np.inf, above))
    return np.where(error > 0, above / np.where(error > 0, error, 1.0), constant)


def _quantile(ratio: Floats, share: float) -> Floats:
    return np.asarray(np.quantile(ratio, share, axis=1, method="nearest"), dtype=np.float64)


def _skewness(values: Floats) -> Floats:
    centred = values - values.mean(axis=-1, keepdims=True)
    variance = np.mean(centred**2, axis=-1)
    third: Floats = np.mean(centred**3, axis=-1) / np.maximum(variance, 1e-12) ** 1.5
    return third


def _hall(values: Floats, drawn: Floats, ratio: Floats) -> Ends:
    """Return the ends by Hall's cubic transformation of the studentised mean."""
    n = values.shape[1]
    bent = np.clip(ratio, -1e6, 1e6) / np.sqrt(n)
    third = _skewness(drawn)
    bent = bent + third * bent**2 / 3 + third**2 * bent**3 / 27 + third / (6 * n)
    own = _skewness(values)
    own = np.where(np.abs(own) < 1e-6, 1e-6, own)
    mean, deviation = values.mean(axis=1), values.std(axis=1, ddof=1)
    low, high = (
        mean - deviation * 3 * (np.cbrt(1 + own * (_quantile(bent, q) - own / (6 * n))) - 1) / own
        for q in (0.975, 0.025)
    )
    return low, high


def of_rank_biserial(differences: NDArray[np.int64]) -> dict[str, tuple[float, float]]:
    """Return the ends of each interval of one study."""
    values = differences[differences != 0]
    ranks = doubled_midranks(np.abs(values))
    plus = int(ranks[values > 0].sum())
    estimate = 2 * plus / int(ranks.sum()) - 1
    one = effects._normal_shift_ends(values.size, plus, 0.025)
    other = effects._studentised_ends(values, estimate, 0.025)
    z = np.arctanh(np.clip(estimate, -1 + 1e-12, 1 - 1e-12))
    slope = np.sqrt(1 - np.tanh(z) ** 2)
    half = abs(np.arcsin(other[1]) - np.arcsin(other[0])) / 2 / slope
    fisher = float(np.tanh(z - half)), float(np.tanh(z + half))
    return {
        "normal shift": one,
        "arcsin, studentised": other,
        "Fisher's z, studentised": fisher,
        "normal shift or z": effects._wider(one, fisher),
        "normal shift or arcsin (ours)": effects._wider(one, other),
    }


def main() -> None:
    """Print both tables."""
    for generator in ("ssq", "heavy", "log-normal"):
        for n in (8, 40):
            random = np.random.default_rng([SEED, 2, n])
            covered: dict[str, list[bool]] = {}
            truth = estimands(generator, 0.0).mean
            for _ in range(STUDIES // BLOCK):
                scores = GENERATORS[generator](random, n * BLOCK, 0.0)[:, 0].astype(np.float64)
                for name, (low, high) in of_means(scores.reshape(BLOCK, n), random).items():
                    covered.setdefault(name, []).extend((low <= truth) & (truth <= high))
            _print(f"mean, {generator}, n = {n}", covered)
    for generator in ("normal", "heavy", "log-normal"):
        for n in (8, 40):
            random = np.random.default_rng([SEED, 3, n])
            covered = {}
            rho = estimands(generator, EFFECT).rank_biserial
            for _ in range(STUDIES):
                scores = GENERATORS[generator](random, n, EFFECT)
                for name, ends in of_rank_biserial(scores[:, 0] - scores[:, 1]).items():
                    covered.setdefault(name, []).append(ends[0] <= rho <= ends[1])
            _print(f"rank-biserial, {generator}, n = {n}", covered)


def _print(what: str, covered: dict[str, list[bool]]) -> None:
    shares = "; ".join(f"{name} {np.mean(each):.3f}" for name, each in covered.items())
    print(f"{what}: {shares}", flush=True)


if __name__ == "__main__":
    main()
