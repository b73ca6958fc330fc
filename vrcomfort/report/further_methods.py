"""Paragraphs of the methods section on comparisons of groups and what else a plan asks for."""

from __future__ import annotations

from typing import Any, NamedTuple

Results = dict[str, Any]


class Method(NamedTuple):
    """One paragraph, and the keys of what it cites (see `references`)."""

    title: str
    text: str
    cited: tuple[str, ...] = ()


def further_methods(results: Results) -> list[Method]:
    """Return the paragraphs on what this report holds of these."""
    return [
        *_comparisons(results),
        *_kruskal_wallis(results),
        *_equivalence(results),
        *_preferences(results),
        *_correlations(results),
        *_agreement(results),
        *_ordinal(results),
        *_z_scores(results),
        *_aligned_ranks(results),
        *_marginal_means(results),
    ]


def _aligned_ranks(results: Results) -> list[Method]:
    if not any(found.get("aligned_ranks") for found in results["anova"]):
        return []
    return [Method(
        "Aligned ranks",
        "For each effect of the ANOVA scores were stripped of all other effects, ranked, and "
        "analysed in the same way (Wobbrock et al., 2011).",
        ("wobbrock_2011",),
    )]  # fmt: skip


def _marginal_means(results: Results) -> list[Method]:
    if not any(found.get("means", {}).get("condition") for found in results["mixed_models"]):
        return []
    return [Method(
        "Marginal means",
        "Estimated marginal means (Searle et al., 1980) of the mixed model are those of a level "
        "with all levels of the other factors weighing alike; their differences, p and intervals "
        "are adjusted by Bonferroni for the number of pairs.",
        ("searle_1980",),
    )]  # fmt: skip


def _comparisons(results: Results) -> list[Method]:
    made = {row["test"] for row in results["comparisons"] if not row["not_tested"]}
    said = []
    if "mann_whitney" in made:
        said.append(Method(
            "Mann–Whitney tests",
            "Groups were compared with the test of Mann & Whitney (1947) on integer sums, exact "
            "given the ties (Streitberg & Röhmel, 1986) where p is not marked; two-sided, p is the "
            "probability of a rank sum at least as far from its expectation. The difference is the "
            "Hodges–Lehmann (1963) shift, the median of all differences between two people of "
            "different groups; its interval is the hull of the shifts that the same test does not "
            "reject. The rank-biserial r is 2 P − 1 with P the probability that somebody of the "
            "first group is higher, its interval that of Newcombe (2006, method 5).",
            ("mann_1947", "streitberg_1986", "hodges_1963", "newcombe_2006"),
        ))  # fmt: skip
    if made & {"welch_t", "student_t", "paired_t"}:
        said.append(Method(
            "Tests of means",
            "Means were compared with t tests"
            + (", without the assumption of equal variances (Welch, 1947)" * ("welch_t" in made))
            + ". Hedges’ (1981) g is the difference over the standard deviation (of the "
            "differences in pairs; the pooled one of groups) without its bias; its interval is "
            "that of the noncentral t distribution. BF₁₀ is the Bayes factor of Rouder et al. "
            "(2009), prior scale √½, two-sided.",
            ("hedges_1981", "rouder_2009", *(("welch_1947",) if "welch_t" in made else ())),
        ))  # fmt: skip
    if "sign" in made:
        said.append(Method(
            "Sign tests",
            "The sign test is exact and leaves out differences of zero; the interval of the share "
            "of positive differences is that of Clopper & Pearson (1934), that of the median lies "
            "between two of the differences (Hollander et al., 2014).",
            ("clopper_1934", "hollander_2014"),
        ))  # fmt: skip
    return said


def _kruskal_wallis(results: Results) -> list[Method]:
    if all(row["not_tested"] for row in results["kruskal_wallis"]):
        return []
    return [Method(
        "More than two groups",
        "More than two groups were compared with the test of Kruskal & Wallis (1952), corrected "
        "for ties, on each person’s mean over exposures; ε² = H / (N − 1) is its effect size. p is "
        "exact given the ties where it is not marked.",
        ("kruskal_1952",),
    )]  # fmt: skip


def _equivalence(results: Results) -> list[Method]:
    if all(row["not_tested"] for row in results["equivalence"]):
        return []
    return [Method(
        "Equivalence",
        "Equivalence was tested with two one-sided t tests (Schuirmann, 1987) against the bounds "
        "of the plan; p is the larger of both. Groups may differ in variance.",
        ("schuirmann_1987",),
    )]  # fmt: skip


def _preferences(results: Results) -> list[Method]:
    if not results["preferences"]:
        return []
    return [Method(
        "Preferences",
        "Preferences were counted in three classes; shares have Wilson’s (1927) intervals. The "
        "sign test and the share among those with a preference (Clopper & Pearson, 1934) leave "
        "out who had none.",
        ("wilson_1927", "clopper_1934"),
    )]  # fmt: skip


_OF_CORRELATIONS = {
    "pearson": ("Pearson’s r has Fisher’s interval.", ()),
    "spearman": (
        "Spearman’s ρ has the interval of Bonett & Wright (2000); its p is exact up to 8 pairs.",
        ("bonett_2000",),
    ),
    "kendall": (
        "Kendall’s τ_b has the interval of Fieller et al. (1957); its p is exact without ties up "
        "to 33 pairs.",
        ("fieller_1957",),
    ),
    "repeated_measures": (
        "Repeated-measures correlations have one slope for all and a level for each person (Bland "
        "& Altman, 1995; Bakdash & Marusich, 2017).",
        ("bland_1995", "bakdash_2017"),
    ),
}


def _correlations(results: Results) -> list[Method]:
    made = dict.fromkeys(r["method"] for r in results["correlations"] if not r["not_tested"])
    if not made:
        return []
    text = " ".join(_OF_CORRELATIONS[name][0] for name in made)
    cited = tuple(key for name in made for key in _OF_CORRELATIONS[name][1])
    return [Method("Correlations", f"{text} p values of correlations are not adjusted.", cited)]


def _agreement(results: Results) -> list[Method]:
    if all(row["not_tested"] for row in results["agreement"]):
        return []
    return [Method(
        "Agreement",
        "Intraclass correlations are those of Shrout & Fleiss (1979), of people with a score on "
        "every occasion: (2,1) counts differences between occasions as error, (3,1) does not.",
        ("shrout_1979",),
    )]  # fmt: skip


def _z_scores(results: Results) -> list[Method]:
    if not results["z_scores"]:
        return []
    return [Method(
        "Standardised scores",
        "z scores are scores minus their person’s mean over all exposures, over that person’s "
        "standard deviation. Standard errors over values, as Mantiuk et al. (2011) print them, "
        "take a person’s scores for independent; those over people do not.",
        ("mantiuk_2011",),
    )]  # fmt: skip


def _ordinal(results: Results) -> list[Method]:
    made = [row for row in results["ordinal"] if not row["not_tested"]]
    if not made:
        return []
    random = any(row["participant_sd"] is not None for row in made)
    repeats = (
        " As people answered more than once, they have a random intercept (Hedeker & Gibbons, "
        "1994), integrated by adaptive Gauss–Hermite quadrature with 25 nodes."
    )
    return [Method(
        "Single items",
        "Single items were analysed by cumulative logit models (McCullagh, 1980), which take the "
        "order of answers alone: an odds ratio above 1 makes every higher answer more likely. p "
        "and interval are Wald’s, factors as a whole have likelihood-ratio tests; nothing is "
        f"adjusted.{repeats * random} That one ratio stands for all cuts between answers was "
        "tested against a model with a ratio for each; where answers were not given under every "
        "level, neighbours were taken together for it.",
        ("mccullagh_1980", *(("hedeker_1994",) if random else ())),
    )]  # fmt: skip
