"""What ours says of the data sets in tests/data/oracles, by the names that R's script gives."""

import csv
import re
from functools import cache
from math import isnan

import numpy as np
import pandas as pd

from tests.support.places import ROOT
from vrcomfort.stats.anova import anova
from vrcomfort.stats.effects import rank_biserial
from vrcomfort.stats.mixed import crossover, mixed_model
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.proportions import fisher_exact
from vrcomfort.stats.rank_anova import friedman
from vrcomfort.stats.ranks import as_integers
from vrcomfort.stats.shift import hodges_lehmann
from vrcomfort.stats.signed_rank import signed_rank, worst_rank
from vrcomfort.stats.t_tests import paired_t

DATA = ROOT / "tests/data/oracles"
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
        model = mixed_model(
            table, value="score", participant="participant", factors=factors, errors="model"
        )
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


def ours_paired_t(name: str) -> Values:
    _, differences, unit = paired(name)
    sides = {
        side: paired_t(differences, unit, alternative=side)
        for side in ("two-sided", "greater", "less")
    }
    found = chosen(sides["two-sided"], "n", "mean", "standard_error", "df", "t", "low", "high")
    found["cohen_dz"] = sides["two-sided"].cohen_d
    found |= {f"p {side}": test.p for side, test in sides.items()}
    return found | {"greater_low": sides["greater"].low}


def ours_anova_type_ii(name: str) -> Values:
    table = data_set("designs.csv", name)
    result = anova(
        table, value="score", participant="participant", between="group",
        within=[factor for factor in ("condition", "scene") if table[factor].notna().all()],
        sums_of_squares="II",
    )  # fmt: skip
    return by_effect(result.effects)


def ours_two_groupings(name: str) -> Values:
    found: Values = {}
    for kind in ("II", "III"):
        result = anova(
            data_set("two_groupings.csv", name), value="score", participant="participant",
            within=["condition"], between=["view", "skill"], sums_of_squares=kind,
        )  # fmt: skip
        found |= prefixed(f"{kind} ", by_effect(result.effects))
    return found


def by_effect(effects) -> Values:
    found: Values = {}
    for effect in effects:
        values = chosen(effect, "f", "p")
        values |= {
            "ss": effect.sum_of_squares,
            "df": effect.df_effect,
            "error_ss": effect.error_sum_of_squares,
            "df_error": effect.df_error,
        }
        found |= prefixed(f"{effect.effect}: ", values)
    return found


OURS = {
    name.removeprefix("ours_"): cache(function)
    for name, function in list(globals().items())
    if name.startswith("ours_")
}


def r_output() -> list[dict[str, str]]:
    with (DATA / "r_output.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))
