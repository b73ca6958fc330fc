"""Numbers and methods in the words of a paper."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any, Literal

from vrcomfort.stats.means import RESAMPLES, SEED
from vrcomfort.stats.ranks import fewest_for_interval
from vrcomfort.stats.signed_rank import EXACT_UP_TO

MINUS = "−"
NONE = "–"


def number(value: float | None, digits: int = 2) -> str:
    """Write a number with a real minus sign; a dash where there is none."""
    if value is None:
        return NONE
    text = f"{value:.{digits}f}"
    return text.replace("-", MINUS) if float(text) != 0 else text.lstrip("-")


def fraction(value: float | None, digits: int = 2) -> str:
    """Write a number that cannot exceed 1 without its leading zero (APA)."""
    text = number(value, digits)
    return text.replace("0.", ".", 1) if text.lstrip(MINUS).startswith("0.") else text


def p_value(value: float | None) -> str:
    """Write p with three digits after the point."""
    if value is None:
        return NONE
    return "<\u00a0.001" if value < 0.001 else fraction(value, 3)


def p_equals(value: float | None) -> str:
    """Write p in a sentence."""
    text = p_value(value)
    return f"p\u00a0{text}" if text.startswith("<") else f"p\u00a0=\u00a0{text}"


def interval(found: dict[str, Any] | None, digits: int = 2, *, bounded: bool = False) -> str:
    """Write [low, high], with a round bracket where the end itself is not in the interval."""
    if not found or (found.get("low") is None and found.get("high") is None):
        return NONE
    write = fraction if bounded else number
    low, high = found["low"], found["high"]
    first = "−∞" if low is None else write(low, digits)
    last = "∞" if high is None else write(high, digits)
    left = "[" if low is not None and found.get("low_closed", True) else "("
    right = "]" if high is not None and found.get("high_closed", True) else ")"
    hole = " without 0" if found.get("holds_rejected_zero") else ""
    return f"{left}{first},\u00a0{last}{right}{hole}"


def degrees(value: float) -> str:
    """Write degrees of freedom: whole if they are."""
    return str(int(value)) if float(value).is_integer() else number(value, 2)


def methods(results: dict[str, Any]) -> list[str]:
    """Return the methods section, one paragraph per item."""
    plan = results["plan"]
    return [text for text in (
        _scoring(results), _testing(results), _effects(plan), _modelling(results), plan["note"]
    ) if text]  # fmt: skip


def basis_sentence(basis: str) -> str:
    """Say what the scores are."""
    if basis == "difference_from_baseline":
        return (
            "Scores are differences: the questionnaire after an exposure minus the nearest "
            "baseline of the same participant."
        )
    return (
        "The data hold no baseline questionnaire, so scores are raw scores after exposure and "
        "include whatever symptoms participants brought with them."
    )


def _scoring(results: dict[str, Any]) -> str:
    per = results["participants"]["exposures_per_condition"]
    several = any(count > 1 for count in per.values())
    repeated = (
        " Where a condition has several exposures their integer sums are added before testing "
        "and reported as the mean per exposure."
        if several
        else ""
    )
    return (
        f"{' '.join(map(_instrument, results['instruments']))} "
        "Incomplete questionnaires were not scored. "
        f"{basis_sentence(results['score_basis'])}{repeated}"
    )


def titles_of(results: dict[str, Any]) -> dict[str, str]:
    """Return outcome → its title; with the instrument's name where two have the same one."""
    outcomes = results["outcomes"]
    count = Counter(each["title"] for each in outcomes)
    short = {each["name"]: each["short"] for each in results["instruments"]}
    return {
        each["name"]: each["title"]
        if count[each["title"]] == 1
        else f"{short[each['instrument']]} {each['title'].lower()}"
        for each in outcomes
    }


def _instrument(asked: dict[str, Any]) -> str:
    """Say what was asked, after whom it was scored, and how."""
    known = f"{asked['short']}; " if asked["short"] != asked["title"] else ""
    count = len(asked["items"])
    items = f"{count} items, {asked['answers']}" if count > 1 else asked["answers"]
    after = f" after {asked['citation']}" if asked["citation"] else ""
    rule = f": {asked['rule']}" if asked["rule"] else ""
    return f"The {asked['title']} ({known}{items}) was scored{after}{rule}."


def _testing(results: dict[str, Any]) -> str:
    plan = results["plan"]
    zeros = (
        "pairs without a difference were ranked and then dropped (Pratt)"
        if plan["zeros"] == "pratt"
        else "pairs without a difference were dropped before ranking (Wilcoxon)"
    )
    sides = {
        "two-sided": "two-sided",
        "greater": "one-sided (more discomfort under the first condition)",
        "less": "one-sided (less discomfort under the first condition)",
    }[plan["alternative"]]
    return (
        f"Conditions were compared with Wilcoxon signed-rank tests, {sides}, on participants with "
        "every exposure of both conditions. Ranks were taken on integer raw sums, so ties are "
        f"exact; {zeros}; p is {_exactness(results)}; Z is "
        f"tie-corrected, without continuity correction. {_families(plan, titles_of(results))}"
    )


def _families(plan: dict[str, Any], titles: Mapping[str, str]) -> str:
    """Say over what p values were adjusted."""
    holm = [each for each in plan["families"] if each["method"] == "holm"]
    if not holm:
        return "p values are not adjusted."
    named = [
        ", ".join(titles.get(name, name) for name in each["outcomes"])
        + (" and every effect of its ANOVA" if "anova" in each["analyses"] else "")
        for each in holm
    ]
    over = "; and, apart from these, ".join(named)
    return f"p values were adjusted with Holm’s method over {over}; each time over all contrasts."


def _exactness(results: dict[str, Any]) -> str:
    """Say how p was found in the tests that were made."""
    made = {test["method"] for test in results["tests"] if not test["not_tested"]}
    exact = "from the exact permutation distribution given the ties"
    normal = f"from the normal approximation above {EXACT_UP_TO} pairs"
    if made == {"asymptotic"}:
        return normal
    return f"{exact}, {normal}" if "asymptotic" in made else exact


def _effects(plan: dict[str, Any]) -> str:
    zeros = "including" if plan["zeros"] == "pratt" else "excluding"
    return (
        f"The Hodges–Lehmann shift is the median of the Walsh averages, {zeros} pairs without a "
        f"difference. {_shift_interval(plan)} r is the matched-pairs rank-biserial correlation "
        f"over non-zero differences. {_r_interval(plan)} Intervals of means are bootstrap-t "
        f"({RESAMPLES} resamples, seed {SEED}; Efron & Tibshirani, 1993)."
    )


def fewest_for_shift(plan: Mapping[str, Any]) -> int:
    """Return the fewest differences with which a plan's interval of the shift has a bound."""
    return fewest_for_interval(plan["confidence"], _sides(plan))


def _sides(plan: Mapping[str, Any]) -> Literal[1, 2]:
    inverted = plan["shift_interval"] == "inverted_test"
    return 1 if inverted and plan["alternative"] != "two-sided" else 2


def _shift_interval(plan: dict[str, Any]) -> str:
    percent = f"{100 * plan['confidence']:g} %"
    few = (
        f"There is none below {fewest_for_shift(plan)} differences, because no "
        f"fewer can reach such an exact {'two' if _sides(plan) == 2 else 'one'}-sided p."
    )
    if plan["shift_interval"] == "inverted_test":
        return (
            f"Its {percent} interval is the hull of the shifts that the same test, ranked anew "
            "after each shift is taken off, does not reject before adjustment; a round bracket is "
            f"an end that is itself rejected. {few}"
        )
    return (
        f"Its {percent} interval is bounded by the Walsh averages at the critical ranks of the "
        "signed-rank distribution without ties, on the conservative side; with ties it may "
        f"contradict p. {few}"
    )


def _r_interval(plan: dict[str, Any]) -> str:
    percent = f"{100 * plan['confidence']:g} %"
    kind = plan["rank_biserial_interval"]
    if kind == "normal_shift":
        return (
            f"Its {percent} interval holds the values of 2 P(D₁ + D₂ > 0) − 1 under which the "
            "observed r, or one farther out, is not too rare for non-zero differences D from a "
            "normal distribution of any mean. It drops zeros, which the test may rank, so the two "
            "may disagree about 0. Whether there is a difference, p says."
        )
    n = (
        "the number of non-zero scores in the first condition, as R’s effectsize counts"
        if kind == "effectsize"
        else "the number of non-zero differences"
    )
    return (
        f"Its {percent} interval is a Fisher-z interval whose standard error uses {n}. It is "
        "approximate, too narrow where there is an effect, and has no width at ±1. Whether there "
        "is a difference, p says."
    )


def _modelling(results: dict[str, Any]) -> str:
    made = any(not found["not_tested"] for found in results["anova"])
    anova = (
        "The repeated-measures ANOVA uses type III sums of squares and participants with a score "
        "in every cell; ε is Greenhouse–Geisser (GG) and Huynh–Feldt (HF); intervals of partial "
        "η² are 90 %. "
        if made
        else ""
    )
    return (
        f"{anova}The mixed model has a random intercept per participant, is fitted by restricted "
        "maximum likelihood to every scored exposure; its standard errors are those of generalised "
        "least squares at the fitted variances, its degrees of freedom Satterthwaite’s (Kuznetsova "
        "et al., 2017)."
    )


def headline(test: dict[str, Any], results: dict[str, Any]) -> str:
    """Return the result of one test in a sentence that takes no side."""
    labels, name = results["labels"], titles_of(results)[test["outcome"]]
    a, b = labels[test["a"]], labels[test["b"]]
    if test["not_tested"]:
        return f"{name}: {a} and {b} could not be compared ({test['not_tested']})."
    effect = test["effect"]
    if effect is None:
        return f"{name}: nobody’s score differed between {a} and {b} (n = {test['n']})."
    shift, r, n = _estimates(test, a)
    return (
        f"{name}, {a} minus {b}: shift {shift}, Z\u00a0=\u00a0{number(test['z'])}, "
        f"{p_equals(test['p'])} ({test['method']}), {_adjusted(test)}"
        f"r\u00a0=\u00a0{r}, n\u00a0=\u00a0{n}.{_order_of(test)}"
    )


def _adjusted(test: dict[str, Any]) -> str:
    return "" if test["p_holm"] is None else f"Holm-adjusted {p_equals(test['p_holm'])}, "


def _order_of(test: dict[str, Any]) -> str:
    """Return what makes the result of a test one of the order as well."""
    said: str | None = test["confounded"]
    return f" But {said}." if said else ""


def _estimates(test: dict[str, Any], a: str) -> tuple[str, str, str]:
    """Return shift, r and n with the intervals, or with the reason why there is none."""
    shift, effect, n = test["shift"], test["effect"], str(test["n"])
    points, r = f"{number(shift['estimate'])} points", fraction(effect["estimate"])
    percent = f"{100 * effect['confidence']:g}\u00a0%"
    found = interval(shift)
    points += f" (no {percent} interval: too few differences)" if found == NONE else f" {found}"
    if effect["low"] is not None:
        return points, f"{r} {interval(effect, bounded=True)}", n
    few = test["n"] - test["zeros"] < fewest_for_interval(effect["confidence"])
    reason = "too few differences other than 0" if few else f"{a} has no score but 0"
    return points, f"{r} (no {percent} interval: {reason})", n
