"""What ours says of published data sets (tests/data/published) and of NIST's."""

import csv
import re
from functools import cache

import numpy as np
import pandas as pd

from tests.support.places import ROOT
from vrcomfort.stats.anova import Anova, anova
from vrcomfort.stats.ranks import as_integers
from vrcomfort.stats.signed_rank import signed_rank
from vrcomfort.stats.t_tests import paired_t

DATA = ROOT / "tests/data"
Values = dict[str, float | None]

NIST_TOLERANCES = {
    "SiRstv": 1e-12,
    "SmLs03": 1e-12,
    "SmLs06": 1e-9,
    # Steps between doubles are 1e-4 there, where values differ by 0.1: digits are lost in reading.
    "SmLs09": 2e-4,
}
QUANTITIES = ("df_effect", "sum_of_squares", "f", "df_error", "error_sum_of_squares", "r_squared")


def r_output() -> list[dict[str, str]]:
    with (DATA / "published" / "r_output.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


@cache
def published(name: str) -> pd.DataFrame:
    file = {"obk.long": "obk_long"}.get(name, name)
    return pd.read_csv(DATA / "published" / f"{file}.csv")


def ours(row: dict[str, str]) -> float:
    """Return our value of a line of r_output.csv."""
    whose = {"sleep": _sleep, "ToothGrowth": _teeth, "obk.long": _obk}[row["dataset"]]
    return whose()[row["convention"]][row["quantity"]]


@cache
def _sleep() -> dict[str, Values]:
    table = published("sleep")
    one, two = (table[table["group"] == g]["extra"].to_numpy() for g in (1, 2))
    steps = as_integers(one, 0.1) - as_integers(two, 0.1)
    t = paired_t(steps, 0.1)
    found: dict[str, Values] = {
        "paired t, two-sided": {
            **{name: getattr(t, name) for name in ("t", "df", "p", "low", "high")},
            "cohen_dz": t.cohen_d,
        }
    }
    for zeros, name in (("pratt", "Pratt zeros"), ("wilcox", "Wilcoxon zeros")):
        test = signed_rank(steps, zeros=zeros)
        found[name] = {"z": test.z, "p_exact": test.p_exact}
    found["Wilcoxon, zeros dropped, exact"] = {"p": signed_rank(steps, zeros="wilcox").p}
    return found


@cache
def _teeth() -> dict[str, Values]:
    table = published("ToothGrowth").assign(animal=np.arange(60).astype(str))
    found: dict[str, Values] = {}
    for kind in ("II", "III"):
        result = anova(
            table, value="len", participant="animal", between=["supp", "dose"], sums_of_squares=kind
        )
        found |= _by_effect(f"between, type {kind}", result)
    return found


OBK = {
    "treatment (between) and phase": (["phase"], ["treatment"]),
    "treatment and gender (between) and phase": (["phase"], ["treatment", "gender"]),
    "phase and hour": (["phase", "hour"], []),
}


@cache
def _obk() -> dict[str, Values]:
    found: dict[str, Values] = {}
    for design, (within, between) in OBK.items():
        cells = published("obk.long").groupby(["id", *within, *between])["value"].mean()
        for kind in ("II", "III"):
            result = anova(
                cells.reset_index(), value="value", participant="id", within=within,
                between=between, sums_of_squares=kind,
            )  # fmt: skip
            found |= _by_effect(f"{design}, type {kind}", result)
    return found


def _by_effect(design: str, result: Anova) -> dict[str, Values]:
    found: dict[str, Values] = {}
    for effect in result.effects:
        values: Values = {
            "f": effect.f,
            "p": effect.p,
            "ges": effect.generalised_eta_squared,
            "p_gg": effect.p_greenhouse_geisser,
            "p_hf": effect.p_huynh_feldt,
        }
        for name in ("mauchly_w", "mauchly_p", "greenhouse_geisser", "huynh_feldt"):
            values[name] = getattr(effect.sphericity, name, None)
        found[f"{design}, {effect.effect}"] = values
    return found


# --- NIST -----------------------------------------------------------------------------------------


@cache
def certified(name: str) -> dict[str, float]:
    lines = (DATA / "oracles" / "nist" / f"{name}.dat").read_text("ascii").splitlines()
    numbers = [re.findall(r"(?<= )\d\S*", line) for line in lines[40:47]]
    between, within, r_squared, _residual_sd = (found for found in numbers if found)
    values = (between[0], between[1], between[3], within[0], within[1], r_squared[0])
    return dict(zip(QUANTITIES, map(float, values), strict=True))


@cache
def nist_data(name: str) -> pd.DataFrame:
    lines = (DATA / "oracles" / "nist" / f"{name}.dat").read_text("ascii").splitlines()[60:]
    rows = [(group, float(y)) for group, y in map(str.split, lines)]
    table = pd.DataFrame(rows, columns=["group", "y"])
    return table.assign(person=[f"P{i:05d}" for i in range(len(table))])


@cache
def ours_of_nist(name: str) -> dict[str, float]:
    effect = anova(nist_data(name), value="y", participant="person", between="group").effects[0]
    total = effect.sum_of_squares + effect.error_sum_of_squares
    return {
        **{name: getattr(effect, name) for name in QUANTITIES[:-1]},
        "r_squared": effect.sum_of_squares / total,
    }
