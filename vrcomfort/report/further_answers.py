"""What comparisons of groups, correlations, equivalence and preferences say, in one sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.families import disagreement, is_shown, reported
from vrcomfort.report.ordinal import ordinal_lines
from vrcomfort.report.words import NONE, fraction, interval, number, p_equals, p_value

if TYPE_CHECKING:
    from vrcomfort.report.vocabulary import Vocabulary

Row = dict[str, Any]
Line = dict[str, str]
TESTS = {
    "mann_whitney": "Mann–Whitney test",
    "welch_t": "Welch’s t test",
    "student_t": "Student’s t test",
    "paired_t": "Paired t test",
    "sign": "Sign test",
    "signed_rank": "Signed-rank test",
}
DIGITS = {"U": 1, "positive": 0, "t": 2}
METHODS = {
    "pearson": ("Pearson’s r", "r"),
    "spearman": ("Spearman’s ρ", "ρ"),
    "kendall": ("Kendall’s τ", "τ"),
    "repeated_measures": ("Repeated-measures correlation", "r"),
}


def line_of(claim: str, evidence: str) -> Line:
    """Return an answer in two parts, and as one text."""
    text = f"{claim} {evidence}" if evidence else claim
    return {"claim": claim, "evidence": evidence, "text": text}


def further_answers(results: Row, words: Vocabulary) -> list[Line]:
    """Return a sentence for each equivalence, preference, correlation and odds ratio."""
    return [
        *(equivalence_answer(row, words) for row in results["equivalence"]),
        *(preference_answer(row) for row in results["preferences"]),
        *(correlation_answer(row, words) for row in results["correlations"]),
        *(line_of(*said) for row in results["ordinal"] for said in ordinal_lines(row, words)),
    ]


def difference_in_words(test: Row, of_a: str, of_b: str, within: str, few: str) -> str:
    """Say what a test decides on two sides; `few`: of whom or what there are too few to show it."""
    if test["verdict"] == "not_possible":
        return f"with {few}, no difference could be shown between {of_a} and {of_b}"
    if not is_shown(test):
        return f"no difference was shown between {of_a} and {of_b}"
    return f"{test['verdict']} {within} {of_a} than {within} {of_b}"


def too_few(test: Row) -> str:
    """Return of what a test has too few, where so few cannot show a difference."""
    if test["smallest_p"] <= 1 - confidence_of(test):
        return "so few people for so many tests"
    return "so few people whose scores differ" if test.get("zeros") else "so few people"


def interval_title(test: Row) -> str:
    """Return what the interval beside a verdict is called: its level is that of the verdict."""
    percent = f"{100 * confidence_of(test):g}\u00a0% CI"
    return f"Holm-adjusted {percent}" if test["simultaneous"] else percent


def confidence_of(test: Row) -> float:
    """Return the confidence that the plan asks for."""
    return float((test.get("shift") or test["difference"])["confidence"])


def p_in_words(test: Row) -> str:
    """Return p, adjusted p, and how small p can be where no difference could be shown."""
    holm = "" if test["p_holm"] is None else f", Holm-adjusted {p_equals(test['p_holm'])}"
    least = ""
    if test["verdict"] == "not_possible":
        least = f" (of so few at least {p_value(test['smallest_p'])})"
    return f"{p_equals(test['p'])}{least}{holm}"


def mean_and_sd(found: dict[str, float | None]) -> str:
    """Return mean and standard deviation as a sentence has them."""
    return f"M\u00a0=\u00a0{number(found['mean'])}, SD\u00a0=\u00a0{number(found['sd'])}"


def comparison_answer(row: Row, words: Vocabulary) -> Line:
    """Say what a comparison by another test than the signed-rank test says."""
    a, b = words.condition(row["a"]), words.condition(row["b"])
    name = words.outcome(row["outcome"])
    if row["not_tested"]:
        return line_of(f"{name}: {a} and {b} could not be compared ({row['not_tested']}).", "")
    of_a, of_b = (
        f"{label} ({mean_and_sd(row['descriptives'][side])})"
        for side, label in (("a", a), ("b", b))
    )
    within = "under" if row["design"] == "paired" else "in"
    said = difference_in_words(row, of_a, of_b, within, too_few(row))
    difference = reported(row, "difference")
    n = row["n_a"] if row["design"] == "paired" else f"{row['n_a']} and {row['n_b']}"
    of = f"{number(difference['estimate'])} {words.unit(row['outcome'])}".rstrip()
    claim = f"{name}: {said}; {difference['what']} {of}{_interval(row)}, n\u00a0=\u00a0{n}."
    return line_of(claim, _evidence(row))


def _interval(row: Row) -> str:
    found = reported(row, "difference")
    percent, ends = interval_title(row), interval(found)
    if ends == NONE:
        return f" (no {percent}: too few)"
    return f", {percent} {ends}{disagreement(row, found)}"


def _evidence(row: Row) -> str:
    exact = f" ({row['method']})" if row["method"] != "t" else ""
    df = f"({number(row['df'], 0 if float(row['df']).is_integer() else 2)})" if row["df"] else ""
    statistic = (
        f"{row['statistic']}{df}\u00a0=\u00a0{number(row['value'], DIGITS[row['statistic']])}"
    )
    text = f"{TESTS[row['test']]}{exact}: {statistic}, {p_in_words(row)}"
    effect = reported(row, "effect")
    if effect:
        bounded = "g" not in effect["what"].split()[-1]
        write = fraction if bounded else number
        text += f"; {effect['what']}\u00a0=\u00a0{write(effect['estimate'])}"
        if interval(effect) != NONE:
            null = 0.5 if effect["what"] == "share above" else 0.0
            text += f" {interval(effect, bounded=bounded, null=null)}"
            text += disagreement(row, effect, null)
    return f"{text}."


def equivalence_answer(row: Row, words: Vocabulary) -> Line:
    """Say whether a difference was shown to lie within the bounds of the plan."""
    a, b, name = words.condition(row["a"]), words.condition(row["b"]), words.outcome(row["outcome"])
    low, high = (number(bound) for bound in row["bounds"])
    if row["not_tested"]:
        return line_of(f"{name}: equivalence could not be tested ({row['not_tested']}).", "")
    shown = "lies" if row["equivalent"] else "was not shown to lie"
    unit = words.unit(row["outcome"])
    claim = (
        f"{name}: the difference of {a} and {b}, {number(row['mean'])} {unit}".rstrip()
        + f", {shown} within {low} and {high}, n\u00a0=\u00a0{row['n']}."
    )
    percent = f"{100 * row['confidence']:g}\u00a0% CI"
    return line_of(
        claim, f"Two one-sided t tests: {p_equals(row['p'])}; {percent} {interval(row)}."
    )


def preference_answer(row: Row) -> Line:
    """Say how many preferred what."""
    a, b = row["of_a"], row["of_b"]
    counts = f"{a} {row['a']}, {b} {row['b']}, no preference {row['none']} of {row['n']}"
    if row["not_tested"]:
        return line_of(f"{row['label']}: nobody preferred either ({counts}).", "")
    if row["verdict"] == "not_possible":
        said = f"with so few who preferred either, no preference for {a} or {b} could be shown"
    elif not is_shown(row):
        said = f"no preference for {a} or {b} was shown"
    else:
        said = f"more preferred {a if row['verdict'] == 'higher' else b}"
    share = row["share_of_a"]
    percent = f"{100 * row['confidence']:g}\u00a0% CI"
    return line_of(
        f"{row['label']}: {said} ({counts}).",
        f"Sign test without those who had none: {p_equals(row['p'])}; share of {a}\u00a0=\u00a0"
        f"{fraction(share['estimate'])}, {percent} {interval(share, bounded=True, null=0.5)}"
        f"{disagreement(row, share, 0.5)}.",
    )


def correlation_answer(row: Row, words: Vocabulary) -> Line:
    """Say whether two outcomes go together."""
    x, y = words.outcome(row["x"]), words.outcome(row["y"])
    if row["not_tested"]:
        return line_of(f"{x} and {y} could not be correlated ({row['not_tested']}).", "")
    title, symbol = METHODS[row["method"]]
    if row["verdict"] == "not_possible":
        said = "with so few values, no correlation could be shown"
    elif not is_shown(row):
        said = "no correlation was shown"
    else:
        more = "more" if row["verdict"] == "higher" else "less"
        said = f"more of one went with {more} of the other"
    percent = f"{100 * row['confidence']:g}\u00a0% CI"
    ends = f", {percent} {interval(row, bounded=True)}{disagreement(row, row)}"
    ends = "" if row["low"] is None else ends
    n = f"n\u00a0=\u00a0{row['n']}"
    if row["method"] == "repeated_measures":
        n = f"{row['n']} exposures of {row['people']} people"
    return line_of(
        f"{x} and {y}: {said}; {symbol}\u00a0=\u00a0{fraction(row['estimate'])}{ends}, {n}.",
        f"{title}: {p_equals(row['p'])}.",
    )
