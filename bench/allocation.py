"""Print how far apart groups are after simulated enrolments, by way of allocation.

`python -m bench.allocation`: 200 people in two groups, of sex, age (three bands) and
susceptibility (three levels), 100 seeds for each way; the table of docs/design.md.
"""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np

from vrcomfort.design.groups import GroupAllocation, Person

BANDS = {
    "sex": ("female", "male"),
    "age": ("<30", "30 to <50", "50+"),
    "susceptibility": ("low", "middle", "high"),
}
WAYS: dict[str, tuple[str, float]] = {
    "simple": ("simple", 0.9),
    "permuted_blocks, rounds = [2]": ("permuted_blocks", 0.9),
    "minimisation, p_best = 0.8": ("minimisation", 0.8),
    "minimisation, p_best = 0.9": ("minimisation", 0.9),
    "minimisation, p_best = 0.95": ("minimisation", 0.95),
    "minimisation, p_best = 1": ("minimisation", 1.0),
}


def widest(way: tuple[str, float], people: int, seed: int) -> tuple[int, int]:
    """Return the greatest difference of two groups at a level of a covariate, and of all people."""
    method, p_best = way
    groups = GroupAllocation(method, {"a": 1, "b": 1}, BANDS, (2,), p_best, seed)
    rng = np.random.default_rng(seed)
    there: list[Person] = []
    for _ in range(people):
        bands = {name: str(rng.choice(levels)) for name, levels in BANDS.items()}
        there.append(Person(groups.assign(there, bands), bands))
    margin: Counter[tuple[str, str]] = Counter()
    for each in there:
        for name in each.bands.items():
            margin[name] += 1 if each.group == "a" else -1
    total = sum(1 if each.group == "a" else -1 for each in there)
    return max(map(abs, margin.values())), abs(total)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=200)
    parser.add_argument("--seeds", type=int, default=100)
    asked = parser.parse_args()
    print("| method | median | 95 % | largest | group sizes differ by, median | at most 4 |")
    print("|---|---|---|---|---|---|")
    for name, way in WAYS.items():
        found = np.array([widest(way, asked.people, seed) for seed in range(asked.seeds)])
        margins, totals = found.T
        print(
            f"| `{name}` | {np.median(margins):.0f} | {np.percentile(margins, 95):.0f} | "
            f"{margins.max()} | {np.median(totals):.0f} | {(margins <= 4).mean():.0%} |"
        )


if __name__ == "__main__":
    main()
