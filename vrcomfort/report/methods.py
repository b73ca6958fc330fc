"""The methods section: what was done in this report, no more, and the literature of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from vrcomfort.report.analyses import MethodsParagraph, methods_paragraphs
from vrcomfort.report.descriptives import TIMEPOINT
from vrcomfort.report.references import is_known
from vrcomfort.report.sections import section_paragraphs
from vrcomfort.stats.means import RESAMPLES, SEED
from vrcomfort.stats.ranks import fewest_for_interval
from vrcomfort.stats.signed_rank import EXACT_UP_TO

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.report.plan import Plan
    from vrcomfort.report.results import Results
    from vrcomfort.report.sections import Section
    from vrcomfort.report.vocabulary import ReportedInstrument, Vocabulary

_SIDES = {
    "two-sided": "two-sided",
    "greater": "one-sided (higher scores under the first condition)",
    "less": "one-sided (lower scores under the first condition)",
}


def methods(
    results: Results, words: Vocabulary, sections: Iterable[Section], *, drawn: bool
) -> list[MethodsParagraph]:
    """Return the paragraphs on everything that this report holds; `drawn`: figures, too."""
    plan = results.plan
    made = any(test.found for test in results.tests)
    return [
        method
        for method in (
            _scoring(results, words),
            _people(results),
            *((_testing(results, words), _shift(plan), _rank_biserial(plan)) if made else ()),
            *methods_paragraphs(results.rows, "tests"),
            _describing(),
            _t_tests(results),
            _anova(results, drawn=drawn),
            *methods_paragraphs(results.rows, "models", "order"),
            _withdrawals(results),
            *section_paragraphs(sections),
            _figures(results) if drawn else None,
            _answering(results),
            MethodsParagraph("Choices", plan.note) if plan.note else None,
        )
        if method
    ]


def basis_sentence(results: Results) -> str:
    """Say what the scores are; nothing where there are only measures."""
    if results.score_basis == "measured":
        return ""
    if results.score_basis == "difference_from_baseline":
        sides = [side.timepoint for test in results.tests for side in test.sides]
        moments = "Comparisons of timepoints are of raw scores. " if any(sides) else ""
        other = "Other scores" if moments else "Scores"
        return (
            f"{moments}{other} are differences: the questionnaire after an exposure minus the "
            "nearest baseline of the same participant."
        )
    why = (
        "as the plan asks"
        if has_baseline(results)
        else "for the data hold no baseline questionnaire"
    )
    return (
        f"Scores are raw scores after exposure, {why}, and include whatever participants already "
        "felt before."
    )


def has_baseline(results: Results) -> bool:
    """Return whether any exposure has scores before it."""
    baseline = results.plan.baseline_timepoint
    return any(row.by == TIMEPOINT and row.level == baseline for row in results.descriptives)


def _scoring(results: Results, words: Vocabulary) -> MethodsParagraph | None:
    several = any(n > 1 for n in results.participants.exposures_per_condition.values())
    repeated = (
        " Where a condition has several exposures their integer sums are added before testing "
        "and reported as the mean per exposure."
        if several
        else ""
    )
    if not results.outcomes:
        return None
    if not words.instruments:
        return MethodsParagraph("Measures", f"{_measures(results)}{repeated}".strip())
    incomplete = (
        "Missing answers count as the mean of the others of their score where enough are given."
        if results.plan.missing_items == "prorate"
        else "Incomplete questionnaires were not scored."
    )
    text = (
        f"{' '.join(map(_instrument, words.instruments))} {incomplete} "
        f"{basis_sentence(results)}{repeated} {_measures(results)}".rstrip()
    )
    cited = [f"instrument_{each.name}" for each in words.instruments]
    return MethodsParagraph("Scores", text, tuple(key for key in cited if is_known(key)))


def _measures(results: Results) -> str:
    """Say what each measure is, and which direction is the good one."""
    named = [each for each in results.outcomes if each.basis == "measured"]
    return " ".join(
        f"{each.title}{' in ' + each.unit_label if each.unit_label else ''} is "
        f"{each.definition}{'; ' + each.better + ' is better' if each.better else ''}."
        for each in named
    )


def _instrument(asked: ReportedInstrument) -> str:
    """Say what was asked, after whom it was scored, and how."""
    known = f"{asked.short}; " if asked.short != asked.title else ""
    count, scale = len(asked.items), asked.answers
    items = f"{count} items, {scale}" if count > 1 else scale
    after = f" after {asked.citation}" if asked.citation else ""
    rule = f": {asked.rule}" if asked.rule else ""
    return f"The {asked.title} ({known}{items}) was scored{after}{rule}."


def _people(results: Results) -> MethodsParagraph:
    return MethodsParagraph(
        "Participants",
        "A participant is in a test with a score of every planned exposure of both its conditions. "
        "How many are planned, the protocol says, or else the most frequent number. "
        f"{results.participants.n} people were enrolled; the flow chart follows CONSORT "
        "(Schulz et al., 2010).",
        ("schulz_2010",),
    )


def _testing(results: Results, words: Vocabulary) -> MethodsParagraph:
    plan = results.plan
    pratt = plan.zeros == "pratt"
    zeros = (
        "pairs without a difference were ranked and then dropped (Pratt, 1959)"
        if pratt
        else "pairs without a difference were dropped before ranking (Wilcoxon, 1945)"
    )
    asked = dict.fromkeys(test.alternative for test in results.tests)
    sides = _SIDES[next(iter(asked))] if len(asked) == 1 else "two-sided or one-sided as marked"
    text = (
        f"Conditions were compared with Wilcoxon signed-rank tests, {sides}. Ranks were taken on "
        f"integer raw sums, so ties are exact; {zeros}; p is {_exactness(results)} (Hollander et "
        f"al., 2014); Z is tie-corrected, without continuity correction. {_families(plan, words)}"
    )
    first = "pratt_1959" if pratt else "wilcoxon_1945"
    holm = ("holm_1979",) if any(each.method == "holm" for each in plan.families) else ()
    return MethodsParagraph("Tests", text, (first, "wilcoxon_1945", "hollander_2014", *holm))


def _families(plan: Plan, words: Vocabulary) -> str:
    """Say over what p values were adjusted."""
    holm = [each for each in plan.families if each.method == "holm"]
    if not holm:
        return "p values are not adjusted."
    named = [
        ", ".join(map(words.outcome, each.outcomes))
        + (" and every effect of its ANOVA" if "anova" in each.analyses else "")
        for each in holm
    ]
    over = "; and, apart from these, ".join(named)
    return (
        f"p values were adjusted with Holm’s (1979) method over {over}; each time over all "
        "comparisons."
    )


def _exactness(results: Results) -> str:
    """Say how p was found in the tests that were made."""
    made = {test.found.method for test in results.tests if test.found}
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


def _shift(plan: Plan) -> MethodsParagraph:
    percent = f"{100 * plan.confidence:g} %"
    zeros = "including" if plan.zeros == "pratt" else "excluding"
    if plan.shift_interval == "inverted_test":
        how = (
            f"Its {percent} interval is the hull of the shifts that the same test, ranked anew "
            "after each shift is taken off, does not reject at its level; a round bracket is an "
            f"end that is itself rejected.{_of_holm(plan)}"
        )
    else:
        how = (
            f"Its {percent} interval is bounded by the Walsh averages at the critical ranks of the "
            "signed-rank distribution without ties, on the conservative side; with ties it may "
            "contradict p."
        )
    text = (
        "The difference in points is the Hodges–Lehmann (1963) shift, the median of the Walsh "
        f"averages, {zeros} pairs without a difference. {how} There is none below "
        f"{fewest_for_shift(plan)} differences, because no fewer can reach such an exact "
        f"{'two' if _sides(plan) == 2 else 'one'}-sided p."
    )
    return MethodsParagraph("Differences", text, ("hodges_1963", "hollander_2014"))


def _of_holm(plan: Plan) -> str:
    """Say of which level intervals are where p values are adjusted."""
    if not any(each.method == "holm" for each in plan.families):
        return ""
    return (
        " In a family of m tests it is of the level at which Holm’s method decides: α/(m − i + 1) "
        "of the i-th smallest p while they are rejected, α over their number of the others."
    )


def _rank_biserial(plan: Plan) -> MethodsParagraph:
    percent = f"{100 * plan.confidence:g} %"
    kind = plan.rank_biserial_interval
    what = (
        "r is the matched-pairs rank-biserial correlation (Kerby, 2014) over non-zero differences."
    )
    if kind == "normal_shift":
        how = (
            f"Its {percent} interval holds the values of 2 P(D₁ + D₂ > 0) − 1 under which the "
            "observed r, or one farther out, is not too rare for non-zero differences D from a "
            "normal distribution of any mean, and what more an interval of arcsin r with the "
            "standard error of its pairs (Sen, 1960) holds, which needs no normal differences. It "
            "drops zeros, which the test may rank, so the two may disagree about 0. Whether there "
            "is a difference, p says."
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
        "at ±1. Whether there is a difference, p says."
    )
    return MethodsParagraph("Effect sizes", f"{what} {how}", ("kerby_2014", "effectsize"))


def _describing() -> MethodsParagraph:
    return MethodsParagraph(
        "Descriptives",
        "An interval of the mean of a condition has at each end the farther of those of t and of "
        f"bootstrap-t ({RESAMPLES} resamples of n − 1, seed {SEED}; Efron & Tibshirani, 1993; Rao "
        "& Wu, 1988), that of a mean difference is of the paired t test. Standard deviations have "
        "n − 1; medians and quartiles are those of "
        "definition 7 of Hyndman & Fan (1996).",
        ("efron_1993", "rao_1988", "hyndman_1996"),
    )


def _t_tests(results: Results) -> MethodsParagraph | None:
    if not any(test.found and test.found.t_test for test in results.tests):
        return None
    return MethodsParagraph(
        "Means",
        "Beside the signed-rank tests stand paired t tests (Student, 1908) of the same pairs, "
        "Cohen’s d_z (Lakens, 2013) and the JZS Bayes factor with a Cauchy prior of scale √2/2 "
        "(Rouder et al., 2009), the latter by pingouin (Vallat, 2018).",
        ("student_1908", "lakens_2013", "rouder_2009", "vallat_2018"),
    )


def _anova(results: Results, *, drawn: bool) -> MethodsParagraph | None:
    if all(found.not_tested for found in results.rows["anova"]):
        return None
    plotted = " and are plotted over normal quantiles at Blom’s (1958) positions" if drawn else ""
    return MethodsParagraph(
        "Analysis of variance",
        f"The ANOVA uses type {results.plan.sums_of_squares} sums of squares (Maxwell et "
        "al., 2018) and participants with every planned score in every cell. Sphericity: Mauchly’s "
        "(1940) test, and ε after Greenhouse & Geisser (1959, GG) and Huynh & Feldt (1976, HF). "
        "Effect sizes: generalised η² (Olejnik & Algina, 2003) and partial η² with its 90 % "
        "interval from the noncentral F distribution (Steiger, 2004). Residuals were tested after "
        f"Shapiro & Wilk (1965){plotted}.",
        ("maxwell_2018", "mauchly_1940", "greenhouse_1959", "huynh_1976", "olejnik_2003",
         "steiger_2004", "shapiro_1965", *(("blom_1958",) if drawn else ())),
    )  # fmt: skip


def _withdrawals(results: Results) -> MethodsParagraph | None:
    found = results.withdrawals
    if not found.n:
        return None
    fisher = found.by_first_condition.fisher_p is not None
    text = (
        "Withdrawals are counted by condition, scene and position. In the sensitivity analyses "
        "each is ranked as worse than every observed difference (worst-rank analysis; Lachin, "
        "1999)."
    )
    also = " First conditions were compared with Fisher’s (1935) exact test." if fisher else ""
    return MethodsParagraph(
        "Withdrawals", text + also, ("lachin_1999", *(("fisher_1935",) if fisher else ()))
    )


def _figures(results: Results) -> MethodsParagraph | None:
    tests, others = results.tests, results.comparisons
    if all(row.not_tested for row in tests) and all(row.not_tested for row in others):
        return None
    return MethodsParagraph(
        "Figures",
        "Estimation plots (Gardner & Altman, 1986; Ho et al., 2019) show every participant, and "
        "the difference with the interval that belongs to its test. Colours are after Okabe & Ito "
        "(2008); each condition has a shape of its own as well.",
        ("gardner_1986", "ho_2019", "okabe_2008"),
    )


def _answering(results: Results) -> MethodsParagraph | None:
    if not results.answering.times:
        return None
    return MethodsParagraph(
        "Answering times",
        "A questionnaire is called fast with a median of less than 2 s per question (Huang et al., "
        "2012). Nothing is excluded for it.",
        ("huang_2012",),
    )
