"""What exact, Monte-Carlo and asymptotic p cost, and how far the last two are off, by n.

`OPENBLAS_NUM_THREADS=1 python -m bench.p_values`: a row per test and number of people. Scores are
like raw sums of the SSQ, with ties, and differ so that p lies between .005 and .2. The limits of
the exact tests (`EXACT_UP_TO` in `vrcomfort.stats.signed_rank` and `mann_whitney`) are read off
this table.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator

import numpy as np

from vrcomfort.stats import mann_whitney as of_groups
from vrcomfort.stats import signed_rank as of_pairs
from vrcomfort.stats.ranks import doubled_midranks

SEED = 20261122
DRAWS = 9_999
SETS = 9
"""Data sets in a row of the table; numbers are medians over them."""
PEOPLE = {"signed rank": (6, 10, 20, 50, 100, 200), "Mann–Whitney": (8, 12, 20, 40, 60, 100, 160)}


def sums(random: np.random.Generator, n: int, mean: float) -> np.ndarray:
    """Return skewed whole scores, as many people have few symptoms."""
    return random.poisson(random.gamma(1.5, mean / 1.5, n))


def sets(test: str, n: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield two samples with an exact p between .005 and .2; of pairs, the second is zero."""
    random = np.random.default_rng([SEED, n])
    found = 0
    while found < SETS:
        shift = 2.2 * 5 / np.sqrt(n) * (1 if test == "signed rank" else 2)
        size = n if test == "signed rank" else n // 2
        a, b = sums(random, size, 4 + shift), sums(random, size, 4)
        if test == "signed rank":
            a, b = a - b, np.zeros_like(a)
        if 0.005 <= EXACT[test](a, b) <= 0.2:
            found += 1
            yield a, b


def exact_pairs(a: np.ndarray, b: np.ndarray) -> float:
    """Return the exact p of a signed-rank test."""
    return of_pairs.signed_rank(a - b, intervals=False).p


def exact_groups(a: np.ndarray, b: np.ndarray) -> float:
    """Return the exact p of a Mann–Whitney test."""
    return of_groups.mann_whitney(a, b, intervals=False).p


def normal_pairs(a: np.ndarray, b: np.ndarray) -> float:
    """Return the asymptotic p of a signed-rank test."""
    return of_pairs.signed_rank(a - b, p_value="asymptotic", intervals=False).p


def normal_groups(a: np.ndarray, b: np.ndarray) -> float:
    """Return the asymptotic p of a Mann–Whitney test."""
    return of_groups.mann_whitney(a, b, p_value="asymptotic", intervals=False).p


def drawn_pairs(a: np.ndarray, b: np.ndarray) -> float:
    """Return p of random signs; the observed ones count as one draw (Phipson & Smyth 2010)."""
    d = a - b
    ranks = doubled_midranks(np.abs(d)) * (d != 0)
    observed = abs(int(ranks @ np.sign(d)))
    signs = np.random.default_rng(SEED).choice((-1, 1), size=(DRAWS, d.size))
    return (1 + int((np.abs(signs @ ranks) >= observed).sum())) / (DRAWS + 1)


def drawn_groups(a: np.ndarray, b: np.ndarray) -> float:
    """Return p of random groups; the observed ones count as one draw."""
    ranks = doubled_midranks(np.concatenate([a, b]))
    expected = a.size * (ranks.size + 1)
    observed = abs(int(ranks[: a.size].sum()) - expected)
    shuffled = np.random.default_rng(SEED).permuted(np.tile(ranks, (DRAWS, 1)), axis=1)
    far = np.abs(shuffled[:, : a.size].sum(axis=1) - expected) >= observed
    return (1 + int(far.sum())) / (DRAWS + 1)


Test = Callable[[np.ndarray, np.ndarray], float]
EXACT: dict[str, Test] = {"signed rank": exact_pairs, "Mann–Whitney": exact_groups}
DRAWN: dict[str, Test] = {"signed rank": drawn_pairs, "Mann–Whitney": drawn_groups}
NORMAL: dict[str, Test] = {"signed rank": normal_pairs, "Mann–Whitney": normal_groups}


def timed(test: Test, a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Return p, and its milliseconds of CPU."""
    start = time.process_time()
    p = test(a, b)
    return p, 1000 * (time.process_time() - start)


def row(test: str, n: int) -> str:
    """Return a line of the table."""
    found = []
    for a, b in sets(test, n):
        exact, cost = timed(EXACT[test], a, b)
        drawn, drawn_cost = timed(DRAWN[test], a, b)
        normal, normal_cost = timed(NORMAL[test], a, b)
        found.append((cost, drawn_cost, normal_cost,
                      abs(drawn / exact - 1), abs(normal / exact - 1)))  # fmt: skip
    costs = np.median(found, axis=0)
    worst = np.max(found, axis=0)
    return (
        f"| {test} | {n} | {costs[0]:.1f} | {costs[1]:.1f} | {costs[2]:.2f} "
        f"| {100 * costs[3]:.1f} ({100 * worst[3]:.1f}) | {100 * costs[4]:.1f} "
        f"({100 * worst[4]:.1f}) |"
    )


def main() -> None:
    """Print the table, with the exact test for every n."""
    argparse.ArgumentParser(prog="python -m bench.p_values", description=__doc__).parse_args()
    of_pairs.EXACT_UP_TO = of_groups.EXACT_UP_TO = 10_000
    print(
        "| test | people | exact, ms of CPU | Monte Carlo, ms | asymptotic, ms "
        "| Monte Carlo off by, % | asymptotic off by, % |"
    )
    print("|---|---|---|---|---|---|---|")
    for test, numbers in PEOPLE.items():
        for n in numbers:
            print(row(test, n), flush=True)


if __name__ == "__main__":
    main()
