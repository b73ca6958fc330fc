"""Cost of exact signed-rank tests and intervals, and the error of the asymptotic form.

`python -m bench.signed_rank`: a row per number of pairs; the limit of the exact test
(`vrcomfort.stats.signed_rank.EXACT_UP_TO`) is read off this table.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from vrcomfort.stats import signed_rank as module
from vrcomfort.stats.signed_rank import signed_rank

PAIRS = (10, 20, 50, 100, 200, 300, 500)
SEED = 20150323


def differences(n: int) -> np.ndarray:
    """Differences like those of raw SSQ totals, with p near .05: a shift of two standard errors."""
    random = np.random.default_rng([SEED, n])
    spread = 6.0
    return np.rint(random.normal(2 * spread / np.sqrt(n), spread, n)).astype(np.int64)


def cpu_s(run: Callable[[], object]) -> float:
    """Return the processor time of the quickest of three runs."""
    taken = []
    for _ in range(3):
        start = time.process_time()
        run()
        taken.append(time.process_time() - start)
    return min(taken)


def row(n: int) -> str:
    """Return a line of the table."""
    values = differences(n)
    test = signed_rank(values, intervals=False)
    if test.p_exact is None:
        return f"| {n} | – | – | – |"
    plain = cpu_s(lambda: signed_rank(values, intervals=False))
    whole = cpu_s(lambda: signed_rank(values))
    off = test.p_asymptotic / test.p_exact - 1
    return f"| {n} | {1000 * plain:.1f} | {1000 * whole:.0f} | {100 * off:+.2f} % |"


def main() -> None:
    """Print the table, with the exact test for every n."""
    argparse.ArgumentParser(prog="python -m bench.signed_rank", description=__doc__).parse_args()
    module.EXACT_UP_TO = max(PAIRS)
    print("| pairs | test, ms of CPU | with intervals, ms | asymptotic p off by |")
    print("|---|---|---|---|")
    for n in PAIRS:
        print(row(n))


if __name__ == "__main__":
    main()
