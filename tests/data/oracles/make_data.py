"""Makes the data sets that R was run on. Same seed, same bytes: `python make_data.py`.

Nothing here is anybody's answer. Scores are like those of the Simulator Sickness Questionnaire:
sums of ratings from 0 to 3, with many zeros, many ties and a long tail.
"""

import numpy as np
import pandas as pd

from tests.support.places import ROOT

HERE = ROOT / "tests"
SEED = 20150323
UNITS = {"N": 9.54, "O": 7.58, "D": 13.92, "T": 3.74}
"""Points per raw sum (Kennedy et al. 1993)."""
SCALES = {
    "N": [0, 5, 6, 7, 8, 14, 15],
    "O": [0, 1, 2, 3, 4, 8, 10],
    "D": [4, 7, 9, 10, 11, 12, 13],
}
"""Items of each scale, counted from 0."""


def people(n: int) -> list[str]:
    return [f"P{i:02d}" for i in range(1, n + 1)]


def ssq_sums(random: np.random.Generator, n: int, sickness: float) -> dict[str, np.ndarray]:
    """Raw sums of two conditions, b milder than a: scale to integers of shape (n, 2)."""
    person = random.normal(0, 0.8, size=(n, 1, 1))
    item = random.normal(-0.4, 0.5, size=(1, 1, 16))
    condition = np.array([sickness, 0.0]).reshape(1, 2, 1)
    felt = person + item + condition + random.normal(0, 0.6, size=(n, 2, 16))
    answers = np.clip(np.floor(felt + 0.5), 0, 3).astype(int)
    sums = {scale: answers[:, :, items].sum(axis=2) for scale, items in SCALES.items()}
    return {**sums, "T": sum(sums.values())}


def pairs(random: np.random.Generator) -> pd.DataFrame:
    """Pairs of raw sums, some without the other half."""
    tables = []

    def add(dataset: str, a: object, b: object, unit: float = 1.0) -> None:
        a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
        tables.append(
            pd.DataFrame({"dataset": dataset, "unit": unit, "participant": people(a.size)}).assign(
                a=pd.array(a, dtype="Int64"), b=pd.array(b, dtype="Int64")
            )
        )

    for scale, both in ssq_sums(random, 18, 0.35).items():
        add(f"ssq_{scale}", *both.T, UNITS[scale])
    for scale, both in ssq_sums(random, 26, 0.3).items():
        halves = both.astype(float)
        halves[random.choice(26, 4, replace=False), [0, 1, 1, 1]] = np.nan
        add(f"ssq_missing_{scale}", *halves.T, UNITS[scale])
    add("large", *ssq_sums(random, 120, 0.15)["T"].T, UNITS["T"])
    sizes = random.permutation(np.arange(1, 16)) * random.choice([-1, 1, 1], 15)
    add("no_ties", 40 + sizes, np.full(15, 40))
    add("no_ties_but_zeros", 40 + np.append(sizes, [0, 0, 0]), np.full(18, 40))
    for n in range(1, 6):
        add(f"n{n}", *random.integers(0, 4, size=(2, n)))
    add("n6", [3, 5, 2, 6, 9, 4], [1, 0, 1, 2, 3, 1])
    add("all_zero", [4, 0, 2, 7, 1, 0], [4, 0, 2, 7, 1, 0])
    add("all_tied", np.arange(2, 12), np.arange(10))
    add("tied_both_ways", [2, 2, 2, 2, 2, 2, 2, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 2, 2, 2])
    add("mostly_zero", [3, 0, 0, 0, 0, 2, 0, 0, 1, 0], [0, 0, 0, 0, 0, 0, 0, 0, 2, 0])
    return pd.concat(tables, ignore_index=True)


def crossovers(random: np.random.Generator) -> pd.DataFrame:
    """AB/BA crossovers in points of the SSQ total, long."""
    rows = []
    for dataset, n_ab, n_ba, lost in (
        ("balanced", 9, 9, 0),
        ("unbalanced", 11, 6, 0),
        ("missing", 10, 9, 4),
        ("smallest", 2, 1, 0),
    ):
        n = n_ab + n_ba
        person = random.normal(12, 6, size=n)
        gone = random.choice(n, lost, replace=False)
        for i, name in enumerate(people(n)):
            sequence = "ab" if i < n_ab else "ba"
            for period, condition in enumerate(sequence):
                mean = person[i] + 3 * (condition == "a") - 1 * period
                score = 3.74 * max(0, round(mean + random.normal(0, 2.5)))
                missing = i in gone and period == i % 2
                rows.append(
                    (dataset, name, sequence, str(period + 1), condition,
                     None if missing else round(score, 2))
                )  # fmt: skip
    return pd.DataFrame(
        rows, columns=["dataset", "participant", "sequence", "period", "condition", "score"]
    )


def covariance(random: np.random.Generator, k: int, spread: float) -> np.ndarray:
    """A covariance whose variances grow with the cell, so that sphericity does not hold."""
    loadings = random.normal(0, 0.6, size=(k, 2))
    return loadings @ loadings.T + 1.5 + np.diag(np.linspace(0.3, spread, k))


def factorial(
    random: np.random.Generator,
    dataset: str,
    *,
    groups: dict[str, int],
    conditions: int,
    scenes: int = 1,
    spread: float = 4,
    offset: float = 10.0,
    whole: bool = False,
    lost: int = 0,
) -> pd.DataFrame:
    """A group × condition × scene design; blank columns where a factor is not there."""
    cells, n = conditions * scenes, sum(groups.values())
    means = random.normal(0, 0.8, size=(len(groups), cells))
    root = np.linalg.cholesky(covariance(random, cells, spread))
    noise = random.normal(size=(n, cells)) @ root.T
    group = np.repeat(np.arange(len(groups)), list(groups.values()))
    scores = np.round(offset + means[group] + noise, 0 if whole else 3)
    scores = np.maximum(scores, 0)
    scores[random.choice(n, lost, replace=False), random.integers(0, cells, lost)] = np.nan
    rows = [
        {
            "dataset": dataset,
            "participant": name,
            "group": list(groups)[group[i]] if len(groups) > 1 else "",
            "condition": "abcd"[cell // scenes] if conditions > 1 else "",
            "scene": ("near", "far", "dark")[cell % scenes] if scenes > 1 else "",
            "score": scores[i, cell],
        }
        for i, name in enumerate(people(n))
        for cell in range(cells)
    ]
    return pd.DataFrame(rows)


def designs(random: np.random.Generator) -> pd.DataFrame:
    """Within, between and mixed designs for the ANOVA, long."""
    one = {"all": 14}
    three = {"novice": 9, "player": 6, "pilot": 5}
    return pd.concat(
        [
            factorial(random, "within", groups=one, conditions=4),
            factorial(random, "within_spherical", groups=one, conditions=3, spread=0.3),
            factorial(random, "within_two_levels", groups=one, conditions=2),
            factorial(random, "within_missing", groups={"all": 17}, conditions=4, lost=3),
            factorial(random, "within_whole", groups=one, conditions=4, offset=1, whole=True),
            factorial(random, "within_offset", groups=one, conditions=4, offset=1e6),
            factorial(random, "within_few_people", groups={"all": 3}, conditions=4),
            factorial(random, "within_two_factors", groups=one, conditions=3, scenes=3),
            factorial(random, "within_2x3", groups={"all": 10}, conditions=2, scenes=3, lost=1),
            factorial(random, "between", groups=three, conditions=1),
            factorial(random, "between_two_groups", groups={"a": 7, "b": 12}, conditions=1),
            factorial(random, "mixed", groups={"ab": 8, "ba": 8}, conditions=3),
            factorial(random, "mixed_unbalanced", groups=three, conditions=4),
            factorial(random, "mixed_missing", groups=three, conditions=3, lost=4),
            factorial(random, "mixed_two_factors", groups=three, conditions=2, scenes=3),
        ],
        ignore_index=True,
    )


def blocks(random: np.random.Generator) -> pd.DataFrame:
    """Raw sums under three conditions and more, for Friedman's test, long."""
    sets = {
        "ties": random.integers(0, 4, size=(15, 4)),
        "no_ties": np.array([random.permutation(5) for _ in range(9)]),
        "mostly_zero": np.maximum(0, random.integers(-5, 3, size=(20, 3))),
        "missing": random.integers(0, 6, size=(16, 3)) + np.array([2, 0, 0]),
        "two_people": np.array([[0, 1, 3], [0, 2, 2]]),
        "two_conditions": random.integers(0, 4, size=(12, 2)),
        "all_tied": np.repeat([[0], [2], [1], [3]], 3, axis=1),
    }
    rows = []
    for dataset, scores in sets.items():
        n, k = scores.shape
        gone = random.choice(n, 3, replace=False) if dataset == "missing" else []
        for i, name in enumerate(people(n)):
            for j in range(k):
                missing = i in gone and j == i % k
                rows.append((dataset, name, "abcde"[j], None if missing else scores[i, j]))
    table = pd.DataFrame(rows, columns=["dataset", "participant", "condition", "score"])
    return table.astype({"score": "Int64"})


def exposures(random: np.random.Generator) -> pd.DataFrame:
    """Every exposure that was scored, with missing cells, for the mixed model, long."""
    rows = []
    for dataset, n, lost, person_sd in (
        ("complete", 16, 0, 6.0),
        ("complete_periods", 12, 0, 5.0),
        ("little_between_people", 24, 0, 1.5),
        ("missing_few", 16, 5, 6.0),
        ("missing_many", 14, 22, 6.0),
    ):
        person = random.normal(20, person_sd, size=n)
        gone = set(random.choice(n * 4, lost, replace=False).tolist())
        for i, name in enumerate(people(n)):
            for period in range(4):
                condition = (period + i) % 4
                mean = person[i] + (3, 0, -2, 1)[condition] + (0, 1, 1.5, 2)[period]
                score = round(mean + random.normal(0, 3), 2)
                if i * 4 + period not in gone:
                    rows.append((dataset, name, "abcd"[condition], str(period + 1), score))
    by_hand = {
        "few": "P1a0 P1b9 P2a4 P2b7 P3a22 P3b30 P4b11 P5a15 P6b3",
        "people_alike": "P1a5 P1b4 P1c9 P2a7 P2b2 P2c8 P3a6 P3b3 P3c9 P4a4 P4c9 P5b5 P5c7",
    }
    rows += [
        (dataset, cell[:2], cell[2], "1", float(cell[3:]))
        for dataset, cells in by_hand.items()
        for cell in cells.split()
    ]
    return pd.DataFrame(rows, columns=["dataset", "participant", "condition", "period", "score"])


def p_values(random: np.random.Generator) -> pd.DataFrame:
    """Families of p values; blank where a test could not be made."""
    families = {
        "one": [0.03],
        "ties": [0.01, 0.04, 0.01, 0.2, 0.04],
        "missing": [0.002, None, 0.6, 0.021, None, 0.013],
        "extremes": [0.0, 1.0, 1e-300, 0.5],
        "twelve": random.beta(0.4, 2, size=12).tolist(),
    }
    rows = [(name, i, p) for name, family in families.items() for i, p in enumerate(family)]
    return pd.DataFrame(rows, columns=["dataset", "test", "p"])


def counts(random: np.random.Generator) -> pd.DataFrame:
    """Withdrawals under two conditions: who stayed and who went."""
    tables = {"none": [0, 12, 0, 12], "all": [9, 0, 0, 9], "one": [1, 11, 0, 12]}
    tables |= {f"random_{i}": random.integers(0, 15, 4).tolist() for i in range(4)}
    rows = [(name, *table) for name, table in tables.items()]
    return pd.DataFrame(rows, columns=["dataset", "went_a", "stayed_a", "went_b", "stayed_b"])


def two_groupings(random: np.random.Generator) -> pd.DataFrame:
    """People grouped twice, in cells of unequal size, each under three conditions."""
    sizes = {("mono", "novice"): 5, ("mono", "expert"): 3, ("stereo", "novice"): 4,
             ("stereo", "expert"): 7}  # fmt: skip
    whose = [cell for cell, size in sizes.items() for _ in range(size)]
    rows = []
    for name, (view, skill) in zip(people(len(whose)), whose, strict=True):
        level = random.normal(10 + 2 * (view == "mono") - 3 * (skill == "expert"), 3)
        for k, condition in enumerate("abc"):
            score = level + k * (1 + (view == "stereo")) + random.normal(0, 2)
            rows.append(("unequal", name, view, skill, condition, round(score, 3)))
    return pd.DataFrame(
        rows, columns=["dataset", "participant", "view", "skill", "condition", "score"]
    )


def main() -> None:
    makers = [pairs, crossovers, designs, blocks, exposures, p_values, counts, two_groupings]
    seeds = np.random.SeedSequence(SEED).spawn(len(makers))
    for make, seed in zip(makers, seeds, strict=True):
        table = make(np.random.default_rng(seed))
        table.to_csv(HERE / f"{make.__name__}.csv", index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
