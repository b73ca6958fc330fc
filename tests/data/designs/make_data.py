"""Writes data.csv and crossed.csv: small sets of numbers for the tests of designs. Run it here."""

import csv
from pathlib import Path

import numpy as np

RNG = np.random.default_rng(20261122)


def rows() -> list[tuple[str, str, str, int]]:
    found: list[tuple[str, str, str, int]] = []

    def add(dataset: str, group: str, values: list[int]) -> None:
        found.extend((dataset, group, f"P{i:02d}", int(v)) for i, v in enumerate(values, start=1))

    distinct = RNG.permutation(40)[:15].tolist()
    add("distinct", "a", [2 * value + 17 for value in distinct[:7]])
    add("distinct", "b", [2 * value for value in distinct[7:]])
    add("tied", "a", RNG.poisson(4, 12).tolist())
    add("tied", "b", RNG.poisson(2.5, 9).tolist())
    add("uneven", "a", RNG.poisson(6, 5).tolist())
    add("uneven", "b", RNG.poisson(3, 16).tolist())
    add("separate", "a", [9, 8, 8, 10, 11])
    add("separate", "b", [1, 2, 2, 3])
    add("large", "a", RNG.poisson(5, 70).tolist())
    add("large", "b", RNG.poisson(4, 60).tolist())
    for group, mean in (("a", 3), ("b", 4), ("c", 6)):
        add("three", group, RNG.poisson(mean, 8).tolist())
    level = RNG.integers(0, 12, 20)
    add("pairs", "a", (level + RNG.poisson(3, 20)).tolist())
    add("pairs", "b", (level + RNG.poisson(2, 20)).tolist())
    add("few_pairs", "a", [3, 5, 2, 8, 6, 7])
    add("few_pairs", "b", [2, 4, 4, 6, 6, 9])
    level = RNG.integers(0, 10, 9)
    for group in ("x1", "x2", "x3", "x4"):
        add("repeated", group, (level + RNG.integers(0, 6, 9)).tolist())
    return found


def crossed() -> list[tuple[str, str, str, str, str, str, int]]:
    """Return two factors between people and two within them, balanced and not."""
    random = np.random.default_rng(20261123)
    found = []
    for dataset, sizes in (("balanced", (3, 3, 3, 3)), ("unbalanced", (5, 3, 2, 4))):
        groups = [(g, s) for g in ("early", "late") for s in ("f", "m")]
        people = [each for each, n in zip(groups, sizes, strict=True) for _ in range(n)]
        for place, (group, sex) in enumerate(people, start=1):
            level = random.normal(20, 4) + (group == "late")
            for view in ("mono", "stereo"):
                for dose, more in (("high", 5), ("low", 0), ("mid", 2)):
                    value = level + more * (view == "stereo") + random.normal(0, 3)
                    found.append((dataset, f"P{place:02d}", group, sex, view, dose, round(value)))
    return found


if __name__ == "__main__":
    with Path(__file__).with_name("crossed.csv").open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("dataset", "participant", "group", "sex", "view", "dose", "value"))
        writer.writerows(crossed())
    with Path(__file__).with_name("data.csv").open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("dataset", "group", "participant", "value"))
        writer.writerows(rows())
