"""Cost of exact, Monte-Carlo and asymptotic p, and the error of the last two, by n.

`OPENBLAS_NUM_THREADS=1 python -m bench.p_values`: a row per test and number of people. Scores are
like raw sums of the SSQ, with ties, and differ so that p lies between .005 and .2. The limits of
the exact tests (`EXACT_UP_TO` in `vrcomfort.stats.signed_rank`, `mann_whitney` and
`kruskal_wallis`) are read off this table. `--test` makes the rows of one.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator

import numpy as np

from vrcomfort.stats import mann_whitney as of_groups
from vrcomfort.stats import rank_anova as of_several
from vrcomfort.stats import signed_rank as of_pairs
from vrcomfort.stats.ranks import doubled_midranks

SEED = 20261122
DRAWS = 9_999
SETS = 9
"""Data sets in a row of the table; numbers are medians over them."""
PEOPLE = {
    "signed rank": (6, 10, 20, 50, 100, 200),
    "Mann–Whitney": (8, 12, 20, 40, 60, 100, 160),
    "Kruskal–Wallis, 3 groups": (9, 12, 18, 24, 30),
    "Kruskal–Wallis, 4 groups": (8, 12, 16),
}
Samples = tuple[np.ndarray, ...]
UNEVEN = {3: (0.2, 0.35, 0.45), 4: (0.15, 0.2, 0.3, 0.35)}
"""Shares of the groups of a Kruskal–Wallis test: groups of one size would cost less."""


def sums(random: np.random.Generator, n: int, mean: float) -> np.ndarray:
    """Return skewed whole scores, as many people have few symptoms."""
    return random.poisson(random.gamma(1.5, mean / 1.5, n))


def samples(test: str, n: int, random: np.random.Generator) -> Samples:
    """Return two samples, the second of pairs zero, or several groups."""
    if test.startswith("Kruskal"):
        shares = UNEVEN[int(test.split()[1])]
        ends = np.rint(n * np.cumsum(shares)).astype(int)
        shifts = np.linspace(0, 22 / np.sqrt(n), len(ends))
        return tuple(
            sums(random, size, 4 + shift)
            for size, shift in zip(np.diff(ends, prepend=0), shifts, strict=True)
        )
    shift = 2.2 * 5 / np.sqrt(n) * (1 if test == "signed rank" else 2)
    size = n if test == "signed rank" else n // 2
    a, b = sums(random, size, 4 + shift), sums(random, size, 4)
    return (a - b, np.zeros_like(a)) if test == "signed rank" else (a, b)


def sets(test: str, n: int) -> Iterator[Samples]:
    """Yield samples with an exact p between .005 and .2."""
    random = np.random.default_rng([SEED, n])
    found = 0
    while found < SETS:
        drawn = samples(test, n, random)
        if 0.005 <= TESTS[test][0](*drawn) <= 0.2:
            found += 1
            yield drawn


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


def exact_several(*groups: np.ndarray) -> float:
    """Return the exact p of a Kruskal–Wallis test."""
    return of_several.kruskal_wallis(groups).p


def normal_several(*groups: np.ndarray) -> float:
    """Return the asymptotic p of a Kruskal–Wallis test."""
    return of_several.kruskal_wallis(groups, p_value="asymptotic").p


def drawn_several(*groups: np.ndarray) -> float:
    """Return p of random groups; the observed ones count as one draw."""
    ranks = doubled_midranks(np.concatenate(groups))
    sizes = [group.size for group in groups]
    starts = np.cumsum([0, *sizes[:-1]])

    def between(rows: np.ndarray) -> np.ndarray:
        return (np.add.reduceat(rows, starts, axis=-1) ** 2 / sizes).sum(axis=-1)

    shuffled = np.random.default_rng(SEED).permuted(np.tile(ranks, (DRAWS, 1)), axis=1)
    far = between(shuffled) >= between(ranks) * (1 - 1e-12)
    return (1 + int(far.sum())) / (DRAWS + 1)


Test = Callable[..., float]
OF_SEVERAL = (exact_several, drawn_several, normal_several)
TESTS: dict[str, tuple[Test, Test, Test]] = {
    "signed rank": (exact_pairs, drawn_pairs, normal_pairs),
    "Mann–Whitney": (exact_groups, drawn_groups, normal_groups),
    "Kruskal–Wallis, 3 groups": OF_SEVERAL,
    "Kruskal–Wallis, 4 groups": OF_SEVERAL,
}
"""Exact, Monte-Carlo and asymptotic p."""


def timed(test: Test, drawn: Samples) -> tuple[float, float]:
    """Return p, and its milliseconds of CPU."""
    start = time.process_time()
    p = test(*drawn)
    return p, 1000 * (time.process_time() - start)


def row(test: str, n: int) -> str:
    """Return a line of the table."""
    found = []
    for given in sets(test, n):
        (exact, cost), (drawn, drawn_cost), (normal, normal_cost) = (
            timed(each, given) for each in TESTS[test]
        )
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
    parser = argparse.ArgumentParser(prog="python -m bench.p_values", description=__doc__)
    parser.add_argument("--test", default="", help="how the names of the tests begin")
    wanted = parser.parse_args().test
    of_pairs.EXACT_UP_TO = of_groups.EXACT_UP_TO = 10_000
    of_several.EXACT_UP_TO = dict.fromkeys(of_several.EXACT_UP_TO, 10_000)
    print(
        "| test | people | exact, ms of CPU | Monte Carlo, ms | asymptotic, ms "
        "| Monte Carlo off by, % | asymptotic off by, % |"
    )
    print("|---|---|---|---|---|---|---|")
    for test, numbers in PEOPLE.items():
        if not test.startswith(wanted):
            continue
        for n in numbers:
            print(row(test, n), flush=True)


if __name__ == "__main__":
    main()
