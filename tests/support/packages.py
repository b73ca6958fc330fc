"""What packages say of data whose answer is known: done by them where right, by us where not.

`python -m tests.support.packages` writes docs/statistics_checks.md; `stats/test_packages.py`
makes a test of each line.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

from tests.support import oracles, published
from tests.support.reference_table import in_page
from vrcomfort.stats.packages import pingouin

BEGIN, END = "<!-- packages: begin -->", "<!-- packages: end -->"


@dataclass(frozen=True)
class Case:
    """One function and one number.

    Parameters
    ----------
    expected
        The number, by `source`.
    says
        What the function returns for it; None where it returns none.
    used
        Whether we use it; else `instead` says what, and `reason` why.
    """

    function: str
    quantity: str
    source: str
    expected: float
    says: Callable[[], float | None]
    used: bool
    reason: str = ""
    instead: str = ""


def _r(analysis: str, dataset: str, quantity: str) -> float:
    return next(
        float(row["value"])
        for row in oracles.r_output()
        if (row["analysis"], row["dataset"], row["quantity"]) == (analysis, dataset, quantity)
    )


def _published(dataset: str, convention: str, quantity: str) -> float:
    return next(
        float(row["value"])
        for row in published.r_output()
        if (row["dataset"], row["convention"], row["quantity"]) == (dataset, convention, quantity)
    )


def _drugs() -> tuple[np.ndarray, np.ndarray]:
    table = published.published("sleep")
    one, two = (table[table["group"] == g]["extra"].to_numpy() for g in (1, 2))
    return one, two


def _sleep() -> np.ndarray:
    one, two = _drugs()
    return one - two


def _obk() -> pd.DataFrame:
    cells = published.published("obk.long").groupby(["id", "treatment", "phase"])["value"].mean()
    return cells.reset_index()


@cache
def _mixed_of_pingouin() -> dict[str, Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        table = pingouin().mixed_anova(
            _obk(), dv="value", within="phase", between="treatment", subject="id"
        )
    return dict(table.set_index("Source").loc["phase"])


def _friedman(name: str) -> float:
    table = oracles.data_set("blocks.csv", name)
    wide = table.pivot_table(index="participant", columns="condition", values="score").dropna()
    return float(pingouin().friedman(wide)["Q"].iloc[0])


def _refusing(name: str) -> float | None:
    try:
        return _friedman(name)
    except AssertionError:
        return None


def _statsmodels_error() -> float:
    """The standard error of x − y by MixedLM, whose cells are incomplete."""
    from statsmodels.regression.mixed_linear_model import MixedLM

    cells = "axB0 ayB9 bxB4 byB7 cxB22 cyB30 dyB11 exB15 fyB3"
    rows = [(cell[0], cell[1], float(cell[3:])) for cell in cells.split()]
    table = pd.DataFrame(rows, columns=["who", "condition", "score"])
    design = np.column_stack([np.ones(9), table["condition"] == "y"]).astype(float)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fit = MixedLM(table["score"].to_numpy(), design, table["who"]).fit(reml=True)
    return float(fit.bse_fe[1])


def _weighted_ranks() -> float:
    """scipy's sum of ranks on SSQ totals in points, where floating point breaks a tie."""
    pre, post = np.array([1, 5, 9, 4, 2]), np.array([4, 8, 6, 1, 7])
    found = stats.wilcoxon(3.74 * post - 3.74 * pre, method="asymptotic", correction=False)
    return float(found.statistic)


def _whole_ranks() -> float:
    pre, post = np.array([1, 5, 9, 4, 2]), np.array([4, 8, 6, 1, 7])
    return float(stats.wilcoxon(post - pre, method="asymptotic", correction=False).statistic)


PAIRED = "paired t, two-sided"
OBK = "treatment (between) and phase, type III, phase"


def _bayes_factor_by_trapezoids(t: float, n: int) -> float:
    """Return the integral of Rouder et al. (2009), equation 1, with r = √½."""
    g = np.exp(np.linspace(-8, 60, 200_001))
    spread = 1 + n * g / 2
    density = spread**-0.5 * (1 + t**2 / (spread * (n - 1))) ** (-n / 2)
    prior = (2 * np.pi) ** -0.5 * g**-1.5 * np.exp(-1 / (2 * g))
    return float(np.trapezoid(density * prior * g, np.log(g)) / (1 + t**2 / (n - 1)) ** (-n / 2))


def _quietly(function: Callable[..., Any], *values: float, **options: Any) -> float:
    """Return a number of a function that warns of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return float(function(*values, **options))


CASES = (
    Case("pingouin.multicomp (Holm)", "adjusted p, of twelve", "R, p.adjust",
         _r("holm", "twelve", "2"),
         lambda: float(pingouin().multicomp(
             oracles.data_set("p_values.csv", "twelve")["p"].to_numpy(), method="holm")[1][2]),
         used=True),
    Case("scipy.stats.t", "p of sleep", "R, t.test", _published("sleep", PAIRED, "p"),
         lambda: float(2 * stats.t.sf(abs(_published("sleep", PAIRED, "t")), 9)), used=True),
    Case("pingouin.bayesfactor_ttest, r = √½", "BF₁₀ of t = 1214, four differences",
         "trapezoids over log g", _bayes_factor_by_trapezoids(1214, 4),
         lambda: _quietly(pingouin().bayesfactor_ttest, 1214, 4, paired=True, r=2**-0.5),
         used=False, reason="its integral over g loses the peak at a large t",
         instead="ours, over log g"),
    Case("scipy.stats.fisher_exact", "p", "R, fisher.test", _r("fisher_exact", "random_2", "p"),
         lambda: oracles.ours_fisher_exact("random_2")["p"], used=True),
    Case("pingouin.ttest", "lower end of the interval of sleep", "R, t.test",
         _published("sleep", PAIRED, "low"),
         lambda: float(pingouin().ttest(_sleep(), 0.0)["CI95"].iloc[0][0]), used=False,
         reason="rounded to two decimals", instead="ours, the same formula"),
    Case("pingouin.ttest", "BF₁₀ of sleep", "R, BayesFactor", 17.25888,
         lambda: float(pingouin().ttest(_sleep(), 0.0)["BF10"].iloc[0]), used=False,
         reason="a rounded text, of the prior scale .707 and not √½",
         instead="ours"),
    Case("pingouin.compute_effsize (paired)", "Cohen's d of sleep", "R, mean / sd",
         _published("sleep", PAIRED, "cohen_dz"),
         lambda: float(pingouin().compute_effsize(
             *_drugs(), paired=True, eftype="cohen")), used=False,
         reason="another quantity (d_av) under that name", instead="ours: d_z"),
    Case("pingouin.wilcoxon", "exact p with ties and zeros", "R, coin",
         _r("signed_rank", "ssq_N", "wilcox p_exact two-sided"),
         lambda: float(pingouin().wilcoxon(
             oracles.paired("ssq_N")[1].astype(float))["p_val"].iloc[0]), used=False,
         reason="no exact p with ties, a continuity correction, no Z, no shift, no interval",
         instead="ours: exact with ties"),
    Case("scipy.stats.wilcoxon (Pratt)", "exact p with ties and zeros", "R, coin",
         _r("signed_rank", "ssq_N", "pratt p_exact two-sided"),
         lambda: float(stats.wilcoxon(
             oracles.paired("ssq_N")[1], zero_method="pratt").pvalue), used=False,
         reason="asymptotic with ties above 13 pairs", instead="ours: exact with ties"),
    Case("scipy.stats.wilcoxon on scores in points", "rank sum", "the same on whole numbers",
         _whole_ranks(), _weighted_ranks, used=False,
         reason="3.74 · 8 − 3.74 · 5 and 3.74 · 4 − 3.74 · 1 tie, but not in floating point",
         instead="ours: ranks of whole raw sums"),
    Case("pingouin.friedman", "χ² of two people", "R, friedman.test",
         _r("friedman", "two_people", "chi_square"), lambda: _refusing("two_people"), used=False,
         reason="refuses two people; NaN and a warning where all tie (right otherwise)",
         instead="ours"),
    Case("pingouin.mixed_anova", "F within, groups of unequal size", "R, car, type III",
         _published("obk.long", OBK, "f"), lambda: float(_mixed_of_pingouin()["F"]), used=False,
         reason="type II without saying so; one factor of each kind only",
         instead="ours: II or III"),
    Case("pingouin.mixed_anova", "Huynh–Feldt p", "R, car, type III",
         _published("obk.long", OBK, "p_hf"), lambda: _mixed_of_pingouin().get("p_HF_corr"),
         used=False, reason="it has none", instead="ours"),
    Case("statsmodels MixedLM, bse_fe", "standard error, cells missing", "R, lme4 and nlme",
         1.8317, _statsmodels_error, used=False,
         reason="not the error of its own variance components", instead="ours: see Mixed model"),
)  # fmt: skip


def difference(case: Case) -> float | None:
    """Return the relative difference of what the function says; None if it says nothing."""
    found = case.says()
    return None if found is None else abs(found - case.expected) / abs(case.expected)


def markdown() -> str:
    """Return the table."""
    lines = [
        "| function | number | expected by | expected | it says | relative difference | used |",
        "|---|---|---|---|---|---|---|",
    ]
    for case in CASES:
        found, off = case.says(), difference(case)
        says = "none" if found is None else f"{found:.7g}"
        how = "yes" if case.used else f"no: {case.reason}. Instead {case.instead}"
        lines.append(
            f"| {case.function} | {case.quantity} | {case.source} | {case.expected:.7g} | {says} | "
            f"{'–' if off is None else f'{off:.0e}'} | {how} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    in_page(markdown(), BEGIN, END)
