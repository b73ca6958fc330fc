"""Count how often the default tests reject and their intervals cover.

`python -m bench.calibration --studies 2000 --out out/calibration` simulates studies (generators and
estimands: `calibration_studies`) and saves what it counts in ``counts.json`` after every 100 of
them, so that it can be stopped and goes on where it was; `--table` prints what is there. Seeds are
fixed: the same studies, whatever the order of runs.

Limits, within 2.576 Monte-Carlo standard errors (99 %): without an effect no test rejects in more
than .05 of the studies; intervals cover in at least .93 (those of η², of 90 %, in .88), of heavy
tails in .90 (.85); none contradicts its p.
The log-normal has no limit: its table says what is left of the tests there.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np

from bench import calibration_studies, small_samples
from bench.calibration_studies import GENERATORS

SIZES, EFFECTS, STEP = (8, 12, 20, 40), (0.0, 0.8), 100
SLACK = 2.576
"""Monte-Carlo standard errors that a share may be beyond its limit."""
LEAST = {
    "normal": 0.93,
    "ssq": 0.93,
    "heavy": 0.90,
    "unequal": 0.93,
    "tied": 0.93,
    "few_ssq": 0.93,
    "few_heavy": 0.90,
    "few_tied": 0.93,
    "few_times": 0.93,
}
"""Coverage of 95 % intervals."""
LESS_OF_90 = 0.05
"""By how much 90 % intervals may cover less."""
ASSUMES_SPHERICITY = {"F rejects", "η² covers (90 %)"}
"""Without a limit where there is none."""
Counts = dict[str, dict[str, int]]


FEW_PEOPLE = (*(f"few_{name}" for name in small_samples.SCORES), "few_times")
"""Generators of `small_samples`."""


def kinds(generators: Iterable[str] = (*GENERATORS, *FEW_PEOPLE)) -> list[str]:
    """Return each generator, n and effect, as one word."""
    return [f"{g} {n} {e}" for g in generators for n in SIZES for e in EFFECTS]


def study(generator: str, n: int, effect: float, number: int) -> dict[str, bool]:
    """Simulate one study of either module."""
    if generator in FEW_PEOPLE:
        return small_samples.study(generator.removeprefix("few_"), n, effect, number)
    return calibration_studies.study(generator, n, effect, number)


def run(
    counts: Counts, studies: int, save: Callable[[], None], wanted: list[str] | None = None
) -> None:
    """Add studies, in turns of 100 of every kind, until each kind has `studies`."""
    for enough in range(STEP, studies + STEP, STEP):
        for kind in wanted or kinds():
            generator, n, effect = kind.split()
            mine = counts.setdefault(kind, {"studies": 0})
            for number in range(mine["studies"], min(enough, studies)):
                for what, happened in study(generator, int(n), float(effect), number).items():
                    mine[what] = mine.get(what, 0) + int(happened)
                mine["studies"] = number + 1
            save()


def misses(
    counts: Counts, slack: float = SLACK, *, certain: bool = False
) -> dict[tuple[str, str], float]:
    """Return the shares that are beyond their limits, by kind and count.

    Coverage misses where it may be too small, or, with `certain`, where chance is no explanation.
    """
    return {
        (kind, what): share
        for kind, mine in counts.items()
        for what, share in _shares(mine).items()
        if _missed(kind, what, share, slack * _error(share, mine["studies"]), certain=certain)
    }


def _shares(mine: Mapping[str, int]) -> dict[str, float]:
    return {what: mine[what] / mine["studies"] for what in mine if what != "studies"}


def _error(share: float, studies: int) -> float:
    return float(np.sqrt(share * (1 - share) / studies))


def _missed(kind: str, what: str, share: float, doubt: float, *, certain: bool) -> bool:
    generator, _, effect = kind.split()
    spared = ASSUMES_SPHERICITY if generator == "unequal" else set()
    if generator not in LEAST or what in spared or "has no" in what:
        return False
    if "against" in what:
        return share > 0
    if "rejects" in what:
        return not float(effect) and share - doubt > 0.05
    least = LEAST[generator] - (LESS_OF_90 if "90 %" in what else 0)
    return share + (doubt if certain else -doubt) < least


def table(counts: Counts, generators: Iterable[str], *, three: bool = False) -> str:
    """Return Markdown of the tests of two conditions or of three; missed limits are bold."""
    missed, wanted = misses(counts, certain=True), set(generators)
    found = {
        kind: _of_three(_shares(mine), three)
        for kind, mine in counts.items()
        if kind.split()[0] in wanted
    }
    found = {kind: shares for kind, shares in found.items() if shares}
    whats = list(next(iter(found.values()), {}))
    lines = ["| " + " | ".join(["generator", "n", "δ", *whats]) + " |"]
    lines.append("|---" * (3 + len(whats)) + "|")
    for kind, shares in found.items():
        error = {what: _error(share, counts[kind]["studies"]) for what, share in shares.items()}
        cells = [
            ("**{}**" if (kind, what) in missed else "{}").format(
                f"{share:.3f} ± {error[what]:.3f}"
            )
            for what, share in shares.items()
        ]
        lines.append("| " + " | ".join([*kind.removeprefix("few_").split(), *cells]) + " |")
    return "\n".join(lines)


def _of_three(shares: Mapping[str, float], three: bool) -> dict[str, float]:
    names = ("F ", "GG ", "η²", "Friedman")
    return {what: share for what, share in shares.items() if what.startswith(names) == three}


def _report(counts: Counts) -> str:
    parts = [
        f"At least {min(mine['studies'] for mine in counts.values())} studies of each kind; ± one "
        "Monte-Carlo standard error.",
        table(counts, GENERATORS),
        table(counts, GENERATORS, three=True),
        table(counts, FEW_PEOPLE[:-1]),
        table(counts, FEW_PEOPLE[-1:]),
    ]
    return "\n\n".join(parts)


def main() -> None:
    """Read the command line, run or print."""
    parser = argparse.ArgumentParser(prog="python -m bench.calibration", description=__doc__)
    parser.add_argument("--studies", type=int, default=2000, help="of each kind")
    parser.add_argument("--out", type=Path, default=Path("out/calibration"))
    everything = (*GENERATORS, *FEW_PEOPLE)
    parser.add_argument("--only", nargs="+", choices=everything, default=everything)
    parser.add_argument("--table", action="store_true", help="print what there is")
    options = parser.parse_args()
    file = options.out / "counts.json"
    counts: Counts = json.loads(file.read_text("utf-8")) if file.is_file() else {}
    if options.table:
        print(_report(counts) if counts else "nothing has been counted yet")
        return
    options.out.mkdir(parents=True, exist_ok=True)

    def save() -> None:
        part = file.with_suffix(".part")
        part.write_text(json.dumps(counts, indent=1), encoding="utf-8")
        part.replace(file)

    run(counts, options.studies, save, kinds(options.only))
    print(_report(counts))


if __name__ == "__main__":
    main()
