"""The paragraphs on the signed-rank tests, and on the t tests of the same pairs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Literal

from vrcomfort.report.analyses.contract import (
    MethodsParagraph,
    ReportContext,
)
from vrcomfort.report.analyses.signed_rank.computation import (
    SignedRankRow,
)
from vrcomfort.stats.ranks import fewest_for_interval
from vrcomfort.stats.signed_rank import EXACT_UP_TO

if TYPE_CHECKING:
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.vocabulary import Vocabulary


_SIDES = {
    "two-sided": "two-sided",
    "greater": "one-sided (higher scores under the first condition)",
    "less": "one-sided (lower scores under the first condition)",
}


def methods(rows: Sequence[SignedRankRow], report: ReportContext) -> Iterator[MethodsParagraph]:
    """Yield the paragraphs on the tests, on their estimates, and on the t tests."""
    if any(row.found for row in rows):
        yield from (
            _test_paragraph(rows, report),
            _shift_paragraph(report.plan),
            _effect_paragraph(report.plan),
        )
    if any(row.found and row.found.t_test for row in rows):
        yield _t_test_paragraph()


def _test_paragraph(rows: Sequence[SignedRankRow], report: ReportContext) -> MethodsParagraph:
    plan = report.plan
    pratt = plan.zeros == "pratt"
    zeros = (
        "pairs without a difference were ranked and then dropped (Pratt, 1959)"
        if pratt
        else "pairs without a difference were dropped before ranking (Wilcoxon, 1945)"
    )
    asked = dict.fromkeys(row.alternative for row in rows)
    sides = _SIDES[next(iter(asked))] if len(asked) == 1 else "two-sided or one-sided as marked"
    text = (
        f"Conditions were compared with Wilcoxon signed-rank tests, {sides}. Ranks were taken on "
        f"integer raw sums, so ties are exact; {zeros}. The p value is {_exactness(rows)} "
        "(Hollander et al., 2014); Z is corrected for ties, without continuity correction. "
        f"{_families(plan, report.words)}"
    )
    first = "pratt_1959" if pratt else "wilcoxon_1945"
    holm = ("holm_1979",) if _is_adjusted(plan) else ()
    return MethodsParagraph("Tests", text, (first, "wilcoxon_1945", "hollander_2014", *holm))


def _is_adjusted(plan: Plan) -> bool:
    return any(each.method == "holm" for each in plan.families)


def _families(plan: Plan, words: Vocabulary) -> str:
    """Name the families over which p values were adjusted."""
    holm = [each for each in plan.families if each.method == "holm"]
    if not holm:
        return "p values are not adjusted."
    named = [
        ", ".join(map(words.outcome, each.outcomes))
        + (" and every effect of its ANOVA" if "anova" in each.analyses else "")
        for each in holm
    ]
    over = "; and separately for ".join(named)
    return f"The p values of all comparisons were adjusted with Holm’s (1979) method for {over}."


def _exactness(rows: Sequence[SignedRankRow]) -> str:
    """Say how p was found in the tests that were made."""
    made = {row.found.method for row in rows if row.found}
    exact = "from the exact permutation distribution given the ties"
    normal = f"from the normal approximation above {EXACT_UP_TO} pairs"
    if made == {"asymptotic"}:
        return normal
    return f"{exact}, {normal}" if "asymptotic" in made else exact


def fewest_for_shift(plan: Plan) -> int:
    """Return the fewest differences with which a plan's interval of the shift has a bound."""
    return fewest_for_interval(plan.confidence, _sides(plan))


def _sides(plan: Plan) -> Literal[1, 2]:
    inverted = plan.shift_interval == "inverted_test"
    return 1 if inverted and plan.alternative != "two-sided" else 2


def _shift_paragraph(plan: Plan) -> MethodsParagraph:
    percent = f"{100 * plan.confidence:g} %"
    zeros = "including" if plan.zeros == "pratt" else "excluding"
    if plan.shift_interval == "inverted_test":
        how = (
            f"Its {percent} confidence interval inverts the same test: it spans the shifts that "
            "the test, with ranks taken anew after subtracting the shift, does not reject. A round "
            f"bracket marks an end that is itself rejected.{_of_holm(plan)}"
        )
    else:
        how = (
            f"Its {percent} confidence interval ends at the Walsh averages of the critical ranks "
            "of the signed-rank distribution without ties, on the conservative side. With ties it "
            "may contradict p."
        )
    text = (
        "The median difference is the Hodges–Lehmann (1963) estimate, the median of the Walsh "
        f"averages, {zeros} pairs without a difference. {how} There is none below "
        f"{fewest_for_shift(plan)} differences, because fewer cannot reach such an exact "
        f"{'two' if _sides(plan) == 2 else 'one'}-sided p."
    )
    return MethodsParagraph("Differences", text, ("hodges_1963", "hollander_2014"))


def _of_holm(plan: Plan) -> str:
    """Say of which level intervals are where p values are adjusted."""
    if not _is_adjusted(plan):
        return ""
    return (
        " In a family of m tests its level is that at which Holm’s method decides. For the i-th "
        "smallest p, as long as tests are rejected, that is α/(m − i + 1); for the others, α "
        "divided by their number."
    )


def _effect_paragraph(plan: Plan) -> MethodsParagraph:
    percent = f"{100 * plan.confidence:g} %"
    kind = plan.rank_biserial_interval
    what = (
        "r is the matched-pairs rank-biserial correlation (Kerby, 2014) over non-zero differences."
    )
    if kind == "normal_shift":
        how = (
            f"Its {percent} confidence interval is the union of two. One holds the values of "
            "2 P(D₁ + D₂ > 0) − 1 that the observed r does not reject for normal non-zero "
            "differences D of any mean. The other is that of arcsin r with the standard error of "
            "its pairs (Sen, 1960), which needs no normal differences. Both drop zeros, which the "
            "test may rank; on 0, p decides: the interval is widened to it, or ends before it."
        )
        return MethodsParagraph("Effect sizes", f"{what} {how}", ("kerby_2014", "sen_1960"))
    n = (
        "the number of non-zero scores in the first condition, as R’s effectsize counts"
        if kind == "effectsize"
        else "the number of non-zero differences"
    )
    how = (
        f"Its {percent} interval is a Fisher-z interval (Ben-Shachar et al., 2020) whose standard "
        f"error uses {n}. It is approximate, too narrow where there is an effect, and has no width "
        "at ±1; the p value decides."
    )
    return MethodsParagraph("Effect sizes", f"{what} {how}", ("kerby_2014", "effectsize"))


def _t_test_paragraph() -> MethodsParagraph:
    return MethodsParagraph(
        "Means",
        "The same pairs were also compared with paired t tests (Student, 1908). Their effect size "
        "is Cohen’s d_z (Lakens, 2013). Bayes factors are JZS, with a Cauchy prior of scale √2/2 "
        "(Rouder et al., 2009), from pingouin (Vallat, 2018).",
        ("student_1908", "lakens_2013", "rouder_2009", "vallat_2018"),
        section="sensitivity",
    )
