"""Against R and NIST: data sets of our own that R was run on once (tests/data/oracles).

One test is one quantity of one data set. Nothing here needs R.
"""

import csv
import hashlib
import re
from fractions import Fraction
from functools import cache
from math import isnan
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from vrcomfort.stats.anova import anova
from vrcomfort.stats.crossover import crossover
from vrcomfort.stats.effects import rank_biserial
from vrcomfort.stats.friedman import friedman
from vrcomfort.stats.mixed import mixed_model
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.ranks import as_integers
from vrcomfort.stats.shift import hodges_lehmann
from vrcomfort.stats.signed_rank import signed_rank
from vrcomfort.stats.withdrawal import fisher_exact, worst_rank

DATA = Path(__file__).parent / "data" / "oracles"
SECOND_AUTHORITY = re.compile(r"[ _]of_(lmer|anova\.mlm|wilcox\.test|exactRankTests)")
"""Ours is one number; R has it from more than one function."""

Values = dict[str, float | None]


def data_set(file: str, name: str) -> pd.DataFrame:
    table = pd.read_csv(DATA / file)
    return table[table["dataset"] == name]


def prefixed(prefix: str, values: Values) -> Values:
    return {f"{prefix}{name}": value for name, value in values.items()}


def chosen(result: object, *names: str) -> Values:
    return {name: getattr(result, name) for name in names}


# --- What ours says, by the names that reference.R gives ---------------------------------------


def paired(name: str) -> tuple[pd.DataFrame, np.ndarray, float]:
    """Return all rows, the integer differences of the complete ones, and points per step.

    The scores go through points and back, as those of a questionnaire do.
    """
    rows = data_set("pairs.csv", name)
    unit = float(rows["unit"].iloc[0])
    whole = rows.dropna()
    a, b = (as_integers(whole[side].to_numpy() * unit, unit) for side in ("a", "b"))
    return rows, a - b, unit


def ours_signed_rank(name: str) -> Values:
    _, differences, unit = paired(name)
    found = chosen(signed_rank(differences, unit), "n", "zeros")
    for zeros in ("pratt", "wilcox"):
        for side in ("two-sided", "greater", "less"):
            test = signed_rank(differences, unit, zeros=zeros, alternative=side)
            found |= prefixed(f"{zeros} ", chosen(test, "w_plus", "w_minus", "z"))
            for p in ("p_exact", "p_asymptotic"):
                found[f"{zeros} {p} {side}"] = getattr(test, p)
    return found


def ours_shift(name: str) -> Values:
    _, differences, unit = paired(name)
    found = {}
    for zeros in ("pratt", "wilcox"):
        for confidence in (0.95, 0.9):
            shift = hodges_lehmann(
                differences, unit, zeros_included=zeros == "pratt", confidence=confidence
            )
            if shift:
                values = chosen(shift, "estimate", "low", "high", "coverage")
                found |= prefixed(f"{zeros} {confidence:g} ", values)
    return found


def ours_rank_biserial(name: str) -> Values:
    rows, differences, _ = paired(name)
    first = int(np.count_nonzero(rows.dropna()["a"]))
    plain = rank_biserial(differences, interval="fisher_z")
    paired_n = rank_biserial(differences, interval="fisher_z", interval_n=first)
    found = chosen(plain, "estimate", "low", "high")
    return found | prefixed("paired ", chosen(paired_n, "low", "high"))


def ours_worst_rank(name: str) -> Values:
    rows, differences, _ = paired(name)
    lost = (rows["a"].isna().astype(int) - rows["b"].isna()).to_numpy()
    found = {}
    for side in ("two-sided", "greater", "less"):
        test = worst_rank(differences, lost[lost != 0], alternative=side)
        found["z"] = test.z
        found |= {f"{p} {side}": getattr(test, p) for p in ("p_exact", "p_asymptotic")}
    return found


ESTIMATE = ("estimate", "standard_error", "df", "t", "p", "low", "high")


def ours_crossover(name: str) -> Values:
    wide = data_set("crossovers.csv", name).pivot_table(
        index=["participant", "sequence"], columns="period", values="score"
    ).dropna().reset_index()  # fmt: skip
    result = crossover(wide[1], wide[2], wide["sequence"] == "ab")
    found = chosen(result, "n_ab", "n_ba")
    for term in ("condition", "period", "sequence"):
        found |= prefixed(f"{term} ", chosen(getattr(result, term), *ESTIMATE))
    return found


def ours_anova(name: str) -> Values:
    table = data_set("designs.csv", name)
    result = anova(
        table, value="score", participant="participant",
        within=[factor for factor in ("condition", "scene") if table[factor].notna().all()],
        between="group" if table["group"].notna().all() else (),
    )  # fmt: skip
    found = {
        "n": result.n,
        "excluded": len(result.excluded),
        "residual_squares": float(np.sum(result.residuals**2)),
        "residual_largest": float(np.max(np.abs(result.residuals))),
    }
    for effect in result.effects:
        values = chosen(
            effect, "f", "p", "p_greenhouse_geisser", "p_huynh_feldt", "generalised_eta_squared"
        )
        values |= {
            "ss": effect.sum_of_squares,
            "df": effect.df_effect,
            "error_ss": effect.error_sum_of_squares,
            "df_error": effect.df_error,
            "partial_eta_squared": effect.partial_eta_squared.estimate,
            "partial_eta_squared_low": effect.partial_eta_squared.low,
            "partial_eta_squared_high": effect.partial_eta_squared.high,
        }
        if effect.sphericity:
            values |= chosen(
                effect.sphericity, "mauchly_w", "mauchly_p", "greenhouse_geisser", "huynh_feldt"
            )
        found |= prefixed(f"{effect.effect}: ", values)
    return found


def ours_friedman(name: str) -> Values:
    table = data_set("blocks.csv", name)
    wide = table.pivot_table(index="participant", columns="condition", values="score").dropna()
    return chosen(friedman(wide), "n", "chi_square", "df", "p", "kendall_w")


def ours_mixed_model(name: str) -> Values:
    found, table = {}, data_set("exposures.csv", name)
    for factors in (["condition"], ["condition", "period"])[: table["period"].nunique()]:
        model = mixed_model(table, value="score", participant="participant", factors=factors)
        values = chosen(model, "n_participants", "n_values", "participant_sd", "residual_sd")
        for term, estimate in model.terms.items():
            values |= prefixed(f"{term} ", chosen(estimate, *ESTIMATE))
        for factor, test in model.omnibus.items():
            values |= prefixed(f"{factor}: ", chosen(test, "f", "df_effect", "df_error", "p"))
        found |= prefixed(f"{' + '.join(factors)}; ", values)
    return found


def ours_holm(name: str) -> Values:
    family = [None if isnan(p) else p for p in data_set("p_values.csv", name)["p"]]
    return {str(i): p for i, p in enumerate(holm(family))}


def ours_fisher_exact(name: str) -> Values:
    counts = data_set("counts.csv", name).iloc[0, 1:].to_numpy(dtype=int).reshape(2, 2)
    return {"p": fisher_exact(counts)}


OURS = {
    name.removeprefix("ours_"): cache(function)
    for name, function in list(globals().items())
    if name.startswith("ours_")
}


# --- R -------------------------------------------------------------------------------------------


def r_output() -> list[dict[str, str]]:
    with (DATA / "r_output.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def closeness(row: dict[str, str]) -> dict[str, float]:
    quantity = row["quantity"].rpartition(" ")[2]
    if quantity.startswith("partial_eta_squared_"):
        return {"rel": 1e-6, "abs": 1e-9}  # R's noncentral beta stops adding at 1e-9
    return {"rel": 1e-6, "abs": 0}


@pytest.mark.parametrize(
    "row",
    [pytest.param(r, id="-".join(list(r.values())[:3])) for r in r_output()],
)
def test_our_value_is_that_of_r(row):
    expected = float(row["value"]) if row["value"] else None
    quantity = SECOND_AUTHORITY.sub("", row["quantity"])
    found = OURS[row["analysis"]](row["dataset"])[quantity]
    if expected is None:
        assert found is None
        return
    if quantity.endswith(": huynh_feldt"):
        expected = min(expected, 1.0)  # R prints what it then takes for 1
    assert found == pytest.approx(expected, **closeness(row))


def test_r_was_run_on_the_data_that_are_here():
    session = (DATA / "r_session.txt").read_text(encoding="utf-8")
    read = dict(line.split()[::-1] for line in session.partition("MD5 sums")[2].splitlines()[1:])
    here = {path.name: path for path in DATA.glob("*.csv") if path.name != "r_output.csv"}
    assert read == {
        name: hashlib.md5(path.read_bytes(), usedforsecurity=False).hexdigest()
        for name, path in here.items()
    }


def test_no_pairs_give_no_test():
    """R refuses to test nothing; ours says that there is nothing."""
    test = signed_rank([])
    assert (test.n, test.z, test.p, test.shift, test.effect) == (0, None, 1.0, None, None)


# --- NIST ----------------------------------------------------------------------------------------

NIST_TOLERANCES = {
    "SiRstv": 1e-12,
    "SmLs03": 1e-12,
    "SmLs06": 1e-9,
    # Steps between doubles are 1e-4 there, where values differ by 0.1: digits are lost in reading.
    "SmLs09": 2e-4,
}
QUANTITIES = ("df_effect", "sum_of_squares", "f", "df_error", "error_sum_of_squares", "r_squared")


@cache
def certified(name: str) -> dict[str, float]:
    lines = (DATA / "nist" / f"{name}.dat").read_text("ascii").splitlines()
    numbers = [re.findall(r"(?<= )\d\S*", line) for line in lines[40:47]]
    between, within, r_squared, _residual_sd = (found for found in numbers if found)
    values = (between[0], between[1], between[3], within[0], within[1], r_squared[0])
    return dict(zip(QUANTITIES, map(float, values), strict=True))


@cache
def nist_data(name: str) -> pd.DataFrame:
    lines = (DATA / "nist" / f"{name}.dat").read_text("ascii").splitlines()[60:]
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


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("name", NIST_TOLERANCES)
def test_one_way_anova_gives_what_nist_certifies(name, quantity):
    expected = certified(name)[quantity]
    assert ours_of_nist(name)[quantity] == pytest.approx(expected, rel=NIST_TOLERANCES[name])


@pytest.mark.parametrize("name", NIST_TOLERANCES)
def test_f_is_exact_for_the_numbers_that_were_read(name):
    """Fractions lose nothing: what they give is all that is left of the digits of the file."""
    groups = [[Fraction(y) for y in values] for _, values in nist_data(name).groupby("group")["y"]]
    n, means = sum(map(len, groups)), [sum(g) / len(g) for g in groups]
    grand = sum(map(sum, groups)) / n
    between = sum(len(g) * (m - grand) ** 2 for g, m in zip(groups, means, strict=True))
    within = sum((y - m) ** 2 for g, m in zip(groups, means, strict=True) for y in g)
    f = (between / (len(groups) - 1)) / (within / (n - len(groups)))
    assert ours_of_nist(name)["f"] == pytest.approx(float(f), rel=1e-12)
