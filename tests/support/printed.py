"""The papers' printed statistics, and what follows from what else is printed.

`python -m tests.support.printed` writes docs/statistics_checks.md; `stats/test_printed_numbers.py`
makes a test of each line. The data of none of these studies are published, so a number can at most
be computed again from other printed numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

from scipy.stats import binomtest, f, norm

from tests.support.reference_table import in_page
from vrcomfort.questionnaire import shipped_instruments
from vrcomfort.stats.effects import partial_eta_squared
from vrcomfort.stats.multiplicity import holm
from vrcomfort.stats.proportions import fisher_exact

BEGIN, END = "<!-- printed: begin -->", "<!-- printed: end -->"
CARNEGIE, HILLAIRE = "Carnegie & Rhee 2015", "Hillaire et al. 2008"
MANTIUK, CHAPMAN = "Mantiuk et al. 2011", "Chapman 2020"


@dataclass(frozen=True)
class Printed:
    """One printed statement.

    Parameters
    ----------
    printed
        As it is printed; `value` is its number.
    ours
        The same number from others that are printed; None where they do not give it.
    holds
        Whether ours, rounded as printed, is what is printed; None where nothing can be said.
    more
        What ours adds.
    """

    paper: str
    printed: str
    value: float | None
    ours: Callable[[], float] | None
    holds: bool | None
    how: str
    more: Callable[[], str] = lambda: ""
    span: Callable[[], tuple[float, float]] | None = None
    """The least and the largest that ours can be where what it comes from is rounded."""


Z_OF = {"total": -2.0684, "nausea": -1.8833, "oculomotor": -1.3915, "disorientation": -2.103}
P_OF = {"total": 0.01923, "nausea": 0.03005, "oculomotor": 0.08226, "disorientation": 0.01786}
MEANS = {"without": ((8.00, 5.64, 8.83), 21.46), "with": ((4.98, 3.74, 4.60), 13.58)}


def _by_table(score: str) -> Callable[[], float]:
    return lambda: float(norm.cdf(round(Z_OF[score], 2)))


def _unrounded(score: str) -> str:
    p = float(norm.cdf(Z_OF[score]))
    return f"from Z unrounded {p:.5f} on one side, {2 * p:.4f} on both"


def _total_of_parts(blur: str) -> float:
    """Return the SSQ total of three subscale scores: 3.74 times their raw sums."""
    units = {scale.name: scale.weight for scale in shipped_instruments()["ssq"].scales}
    parts = zip(MEANS[blur][0], "NOD", strict=True)
    return units["T"] * sum(score / units[name] for score, name in parts)


def _sizes_of(z: float) -> list[int]:
    """Return the n at which a Z of four digits can be without ties and zeros."""
    found = []
    for n in range(5, 21):
        sd = sqrt(n * (n + 1) * (2 * n + 1) / 6)
        total = n * (n + 1) // 2
        reached = {round(step / sd, 4) for step in range(-total, total + 1, 2)}
        if z in reached:
            found.append(n)
    return found


def _tied() -> str:
    sizes = _sizes_of(Z_OF["total"])
    where = f"only with n = {', '.join(map(str, sizes))}" if sizes else "with no n from 5 to 20"
    return f"the answers are not printed; without ties and zeros this Z can come {where}"


def _eta(f_value: float, df1: int, df2: int) -> str:
    found = partial_eta_squared(f_value, df1, df2)
    return f"partial η² {found.estimate:.3f}, 90 % interval [{found.low:.3f}, {found.high:.3f}]"


def _of_f(statement: str, df1: int, df2: int, f_value: float, p: float, *, holds: bool) -> Printed:
    """Return the p of a printed F, which has been rounded."""
    step = 10.0 ** -len(f"{f_value:g}".partition(".")[2]) / 2

    def span() -> tuple[float, float]:
        return float(f.sf(f_value + step, df1, df2)), float(f.sf(f_value - step, df1, df2))

    low, high = span()
    return Printed(
        HILLAIRE,
        f"{statement}: F({df1}, {df2}) = {f_value:g}, p {statement_of(p)}",
        p,
        lambda: float(f.sf(f_value, df1, df2)),
        holds=holds,
        how=f"upper tail of F; as F is rounded, {low:.3g} to {high:.3g}",
        more=lambda: _eta(f_value, df1, df2),
        span=span,
    )


def statement_of(p: float) -> str:
    return "< 0.0001" if p == 0.0001 else f"= {p:g}"


def _signs(one: int, two: int) -> str:
    return f"sign test p = {binomtest(one, one + two).pvalue:.2f}"


def _adjusted() -> float:
    return min(p for p in holm(list(P_OF.values())) if p is not None)


ROWS = (
    *(
        Printed(CARNEGIE, f"{score}: Z = {z}, p = {P_OF[score]}".replace("-", "−"), P_OF[score],
                _by_table(score), holds=True, how="Φ of Z rounded to two decimals, one-sided",
                more=lambda score=score: _unrounded(score))
        for score, z in Z_OF.items()
    ),
    Printed(CARNEGIE, "Z of the four tests", None, None, holds=None, how=_tied()),
    Printed(CARNEGIE, "three of four p below .05", 0.05, _adjusted, holds=False,
            how="the smallest of the four after Holm"),
    Printed(CARNEGIE, "mean total without blur 21.46", 21.46, lambda: _total_of_parts("without"),
            holds=False, how="3.74 · (8.00/9.54 + 5.64/7.58 + 8.83/13.92)"),
    Printed(CARNEGIE, "mean total with blur 13.58", 13.58, lambda: _total_of_parts("with"),
            holds=False, how="3.74 · (4.98/9.54 + 3.74/7.58 + 4.60/13.92)"),
    Printed(CARNEGIE, "six of twenty withdrew, 30 percent", 30, lambda: 100 * 6 / 20, holds=True,
            how="6 / 20",
            more=lambda: f"6 of 10, 0 of 10: Fisher p = {fisher_exact([[6, 4], [0, 10]]):.4f}"),
    _of_f("frags", 1, 29, 8.1, 0.008, holds=True),
    _of_f("deaths", 1, 29, 5.7, 0.023, holds=True),
    _of_f("precision", 1, 29, 17.3, 0.0001, holds=False),
    _of_f("experience × effect", 2, 27, 4.02, 0.03, holds=True),
    Printed(HILLAIRE, "frags fell by about 7 percent", 7, lambda: 100 * (15.4 - 14) / 15.4,
            holds=False, how="15.4 to 14"),
    Printed(HILLAIRE, "precision with blur 25.2", 25.2,
            lambda: (9 * 28.7 + 11 * 23.3 + 10 * 24) / 30, holds=True,
            how="its groups: 28.7, 23.3 and “around 24” of 9, 11 and 10"),
    Printed(HILLAIRE, "83 percent did not change strategy", 83, lambda: 100 * 25 / 30, holds=True,
            how="25 / 30"),
    Printed(HILLAIRE, "no trend: 11 for blur, 13 against (realism)", None, None, holds=None,
            how="no test is printed", more=lambda: _signs(11, 13)),
    Printed(HILLAIRE, "no trend: 10 for, 14 against (depth)", None, None, holds=None,
            how="no test is printed", more=lambda: _signs(10, 14)),
    Printed(HILLAIRE, "order and group: no significant effect", None, None, holds=None,
            how="neither F nor p is printed"),
    Printed(MANTIUK, "z-scores −0.78, 0.54, 0.11, 0.15", 0.0,
            lambda: (-0.78 + 0.54 + 0.11 + 0.15) / 4, holds=True,
            how="their mean: z-scores of each observer have mean 0"),
    Printed(MANTIUK, "ANOVA of scenes, p = 0.48", None, None, holds=None,
            how="neither F nor its degrees of freedom are printed"),
    Printed(MANTIUK, "ANOVA of observers, p = 0.99", None, None, holds=None,
            how="not printed; z-scores of each observer have mean 0, so nothing could come out"),
    Printed(CHAPMAN, "(no study, no number)", None, None, holds=None, how="a claim to be tested"),
)  # fmt: skip


def decimals(row: Printed) -> int:
    """Return to how many decimals a number is printed."""
    text = f"{row.value:g}"
    return len(text.partition(".")[2])


def markdown() -> str:
    """Return the table."""
    lines = [
        "| paper | printed | from what else is printed | ours | does it follow | ours adds |",
        "|---|---|---|---|---|---|",
    ]
    words = {True: "yes", False: "no", None: "cannot be known"}
    for row in ROWS:
        ours = "–" if row.ours is None else f"{row.ours():.4g}"
        lines.append(
            f"| {row.paper} | {row.printed} | {row.how} | {ours} | {words[row.holds]} | "
            f"{row.more()} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    in_page(markdown(), BEGIN, END)
