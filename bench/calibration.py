"""Count how often the default tests reject and their intervals cover.

`python -m bench.calibration --studies 2000 --out out/calibration` simulates studies and saves what
it counts in ``counts.json`` after every 100 of them, so that it can be stopped and goes on where it
was; `--table` prints what is there. Seeds are fixed: the same studies, whatever the order of runs.

Generators of paired differences D = A − B (of one participant), rounded to whole raw points:

- ``normal``: D ~ N(δ, 4²).
- ``ssq``: A and B are raw totals of like shape as those of the SSQ: many zeros, a long tail; one
  person's level moves both, and δ is added to the level under A.
- ``heavy``: D = δ + 3 t₂.₅.

Estimands are worked out from 2,000,000 draws of the generator: the median of (D₁ + D₂)/2 (shift),
P(D₁ + D₂ > 0) − P(D₁ + D₂ < 0) of non-zero differences (rank-biserial), and the mean.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from vrcomfort.stats.effects import Effect
from vrcomfort.stats.means import mean_interval
from vrcomfort.stats.signed_rank import SignedRank, signed_rank

Draw = Callable[[np.random.Generator, int, float], np.ndarray]
SIZES, EFFECTS, SEED, STEP = (8, 12, 20, 40), (0.0, 0.8), 20150323, 100


def _normal(random: np.random.Generator, n: int, effect: float) -> np.ndarray:
    return np.rint(random.normal(4 * effect, 4, n)).astype(np.int64)


def _ssq(random: np.random.Generator, n: int, effect: float) -> np.ndarray:
    level = random.normal(0.2, 0.9, n)
    sums = [np.floor(np.exp(level + shift + random.normal(0, 0.6, n))) for shift in (effect, 0)]
    return (sums[0] - sums[1]).astype(np.int64)


def _heavy(random: np.random.Generator, n: int, effect: float) -> np.ndarray:
    return np.rint(4 * effect + 3 * random.standard_t(2.5, n)).astype(np.int64)


GENERATORS: dict[str, Draw] = {"normal": _normal, "ssq": _ssq, "heavy": _heavy}


@cache
def estimands(generator: str, effect: float) -> tuple[float, float, float]:
    """Return shift, rank-biserial and mean of the generator."""
    draws = GENERATORS[generator](np.random.default_rng(SEED), 2_000_000, effect)
    sums = draws[::2] + draws[1::2]
    other = draws[draws != 0][: 2 * (np.count_nonzero(draws) // 2)]
    signs = np.sign(other[::2] + other[1::2])
    return float(np.median(sums)) / 2, float(signs.mean()), float(draws.mean())


def _holds(test: SignedRank, shift: float) -> bool:
    found = test.shift
    assert found is not None  # noqa: S101 - Pratt's test has a shift for any n ≥ 1
    above = found.low is None or found.low < shift or (found.low == shift and found.low_closed)
    return above and (
        found.high is None or shift < found.high or (found.high == shift and found.high_closed)
    )


def _covers(effect: Effect | None, value: float) -> bool:
    """Return whether the interval holds a value; without one, every value."""
    if effect is None or effect.low is None or effect.high is None:
        return True
    return effect.low <= value <= effect.high


def _disagrees(test: SignedRank) -> bool:
    return test.effect is not None and (test.p <= 0.05) == _covers(test.effect, 0.0)


def study(generator: str, n: int, effect: float, number: int) -> dict[str, bool]:
    """Simulate one study and say what came out."""
    place = [list(GENERATORS).index(generator), n, int(10 * effect), number]
    values = GENERATORS[generator](np.random.default_rng([SEED, *place]), n, effect)
    shift, biserial, mean = estimands(generator, effect)
    test, interval = signed_rank(values), mean_interval(values)
    low = -np.inf if interval.low is None else interval.low
    high = np.inf if interval.high is None else interval.high
    return {
        "rejected": test.p <= 0.05,
        "shift covered": _holds(test, shift),
        "rank-biserial covered": _covers(test.effect, biserial),
        "mean covered": bool(low <= mean <= high),
        "shift against p": _holds(test, 0) != (test.p > 0.05)
        and not (test.shift is not None and test.shift.holds_rejected_zero),
        "rank-biserial against p": _disagrees(test),
    }


def run(counts: dict[str, dict[str, int]], studies: int, save: Callable[[], None]) -> None:
    """Add studies, in turns of 100 of every kind, until each kind has so many."""
    kinds = [(g, n, e) for g in GENERATORS for n in SIZES for e in EFFECTS]
    for wanted in range(STEP, studies + STEP, STEP):
        for generator, n, effect in kinds:
            mine = counts.setdefault(f"{generator} {n} {effect}", {"studies": 0})
            for number in range(mine["studies"], min(wanted, studies)):
                for what, happened in study(generator, n, effect, number).items():
                    mine[what] = mine.get(what, 0) + happened
                mine["studies"] = number + 1
            save()


def table(counts: dict[str, dict[str, int]]) -> str:
    """Return Markdown: each share with its Monte-Carlo standard error."""
    whats = [what for what in next(iter(counts.values())) if what != "studies"]
    lines = ["| " + " | ".join(["generator", "n", "effect", "studies", *whats]) + " |"]
    lines.append("|---" * (4 + len(whats)) + "|")
    for kind, mine in counts.items():
        total = mine["studies"]
        shares = [mine.get(what, 0) / total for what in whats]
        cells = [f"{s:.3f} ± {np.sqrt(s * (1 - s) / total):.3f}" for s in shares]
        lines.append("| " + " | ".join([*kind.split(), str(total), *cells]) + " |")
    return "\n".join(lines)


def main() -> None:
    """Read the command line, run or print."""
    parser = argparse.ArgumentParser(prog="python -m bench.calibration", description=__doc__)
    parser.add_argument("--studies", type=int, default=2000, help="of each kind")
    parser.add_argument("--out", type=Path, default=Path("out/calibration"))
    parser.add_argument("--table", action="store_true", help="print what there is")
    options = parser.parse_args()
    file = options.out / "counts.json"
    counts = json.loads(file.read_text("utf-8")) if file.is_file() else {}
    if options.table:
        print(table(counts) if counts else "nothing has been counted yet")
        return
    options.out.mkdir(parents=True, exist_ok=True)

    def save() -> None:
        part = file.with_suffix(".part")
        part.write_text(json.dumps(counts, indent=1), encoding="utf-8")
        part.replace(file)

    run(counts, options.studies, save)
    print(table(counts))


if __name__ == "__main__":
    main()
