"""The answers: one plain sentence for each question that a plan asks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.analyses import Sentence, sentences
from vrcomfort.report.families import disagreement, is_shown, reported
from vrcomfort.report.orders import in_words
from vrcomfort.report.words import NONE, fraction, interval, number, p_equals, p_value
from vrcomfort.stats.ranks import fewest_for_interval

if TYPE_CHECKING:
    from vrcomfort.report.vocabulary import Vocabulary

Test = dict[str, Any]

TESTS = {
    "mann_whitney": "Mann–Whitney test",
    "welch_t": "Welch’s t test",
    "student_t": "Student’s t test",
    "paired_t": "Paired t test",
    "sign": "Sign test",
    "signed_rank": "Signed-rank test",
}
DIGITS = {"U": 1, "positive": 0, "t": 2}
MOST_ANSWERS = 8


def answers(results: dict[str, Any], words: Vocabulary) -> list[dict[str, Any]]:
    """Return the sentences by score, in the plan's order: its name, sentences, and whether main.

    Of many questions those of other scores than the first are in the tables alone. None is main
    where the planned primary outcome is not in the data.
    """
    tests, order = [*results["tests"], *results["comparisons"]], list(words.outcomes)
    shown = order if len(tests) <= MOST_ANSWERS else order[:1]
    groups = [
        {
            "outcome": outcome,
            "name": words.outcome(outcome),
            "primary": outcome == order[0] and not results["without_primary"],
            "lines": [answer(t, words) for t in tests if t["outcome"] == outcome],
        }
        for outcome in shown
        if any(t["outcome"] == outcome for t in tests)
    ]
    others = sentences(results, words)
    alone = {
        "outcome": "",
        "name": "",
        "primary": not (groups or results["without_primary"]),
        "lines": others,
    }
    return [*groups, alone] if others else groups


def answer(test: Test, words: Vocabulary) -> Sentence:
    """Return the answer of one test."""
    if "design" in test:
        return _comparison_answer(test, words)
    return Sentence(_claim(test, words), _evidence(test, words))


def _claim(test: Test, words: Vocabulary) -> str:
    a, b = words.condition(test["a"]), words.condition(test["b"])
    name = words.outcome(test["outcome"])
    if test["not_tested"]:
        return f"{name}: {a} and {b} could not be compared ({test['not_tested']})."
    if test["effect"] is None and not test["ranked_worst"]:
        return f"{name}: nobody’s score differed between {a} and {b} (n = {test['n']})."
    size = test["descriptives"]
    of_a, of_b = f"{a} ({mean_and_sd(size[test['a']])})", f"{b} ({mean_and_sd(size[test['b']])})"
    said = difference_in_words(test, of_a, of_b, "under", too_few(test))
    return f"{name}: {said}; {_shift(test, words)}, n\u00a0=\u00a0{test['n']}."


def _evidence(test: Test, words: Vocabulary) -> str:
    if test["not_tested"] or (test["effect"] is None and not test["ranked_worst"]):
        return ""
    return (
        f"{test['method'].capitalize()} {p_in_words(test)}; Z\u00a0=\u00a0"
        f"{number(test['z'])}, r\u00a0=\u00a0{_rank_biserial(test, words)}.{_order_of(test, words)}"
    )


def _order_of(test: Test, words: Vocabulary) -> str:
    """Return what makes the result of a test one of the order as well."""
    if not test["confounded"]:
        return ""
    return f" But {in_words(test['confounded'], words.condition)}."


def _shift(test: Test, words: Vocabulary) -> str:
    shift = reported(test, "shift")
    whose = ""
    if test["ranked_worst"]:
        stayed = test["n"] - len(test["ranked_worst"])
        whose = f" of the {stayed} who stayed (the test ranks those who left as worst)"
    percent, found = interval_title(test), interval(shift)
    of = f"difference{whose} {number(shift['estimate'])} {words.unit(test['outcome'])}".rstrip()
    if found == NONE:
        return f"{of} (no {percent}: too few differences)"
    return f"{of}, {percent} {found}{disagreement(test, shift)}"


def _rank_biserial(test: Test, words: Vocabulary) -> str:
    effect = reported(test, "effect")
    if effect is None:
        return f"{NONE} (nobody’s score differed)"
    r = fraction(effect["estimate"])
    if effect["low"] is not None:
        return f"{r} {interval(effect, bounded=True)}{disagreement(test, effect)}"
    few = test["n"] - test["zeros"] < fewest_for_interval(effect["confidence"])
    a = words.condition(test["a"])
    reason = "too few differences other than 0" if few else f"{a} has no score but 0"
    return f"{r} (no {interval_title(test)}: {reason})"


def difference_in_words(test: Test, of_a: str, of_b: str, within: str, few: str) -> str:
    """Say what a test decides on two sides; `few`: of whom or what there are too few to show it."""
    if test["verdict"] == "not_possible":
        return f"with {few}, no difference could be shown between {of_a} and {of_b}"
    if not is_shown(test):
        return f"no difference was shown between {of_a} and {of_b}"
    return f"{test['verdict']} {within} {of_a} than {within} {of_b}"


def too_few(test: Test) -> str:
    """Return of what a test has too few, where so few cannot show a difference."""
    if test["smallest_p"] <= 1 - confidence_of(test):
        return "so few people for so many tests"
    return "so few people whose scores differ" if test.get("zeros") else "so few people"


def interval_title(test: Test) -> str:
    """Return what the interval beside a verdict is called: its level is that of the verdict."""
    percent = f"{100 * confidence_of(test):g}\u00a0% CI"
    return f"Holm-adjusted {percent}" if test["simultaneous"] else percent


def confidence_of(test: Test) -> float:
    """Return the confidence that the plan asks for."""
    return float((test.get("shift") or test["difference"])["confidence"])


def p_in_words(test: Test) -> str:
    """Return p, adjusted p, and how small p can be where no difference could be shown."""
    holm = "" if test["p_holm"] is None else f", Holm-adjusted {p_equals(test['p_holm'])}"
    least = ""
    if test["verdict"] == "not_possible":
        least = f" (of so few at least {p_value(test['smallest_p'])})"
    return f"{p_equals(test['p'])}{least}{holm}"


def mean_and_sd(found: dict[str, float | None]) -> str:
    """Return mean and standard deviation as a sentence has them."""
    return f"M\u00a0=\u00a0{number(found['mean'])}, SD\u00a0=\u00a0{number(found['sd'])}"


def _comparison_answer(row: Test, words: Vocabulary) -> Sentence:
    """Say what a comparison by another test than the signed-rank test says."""
    a, b = words.condition(row["a"]), words.condition(row["b"])
    name = words.outcome(row["outcome"])
    if row["not_tested"]:
        return Sentence(f"{name}: {a} and {b} could not be compared ({row['not_tested']}).")
    of_a, of_b = (
        f"{label} ({mean_and_sd(row['descriptives'][side])})"
        for side, label in (("a", a), ("b", b))
    )
    within = "under" if row["design"] == "paired" else "in"
    said = difference_in_words(row, of_a, of_b, within, too_few(row))
    difference = reported(row, "difference")
    n = row["n_a"] if row["design"] == "paired" else f"{row['n_a']} and {row['n_b']}"
    of = f"{number(difference['estimate'])} {words.unit(row['outcome'])}".rstrip()
    claim = (
        f"{name}: {said}; {difference['what']} {of}{_difference_interval(row)}, n\u00a0=\u00a0{n}."
    )
    return Sentence(claim, _evidence_of_comparison(row))


def _difference_interval(row: Test) -> str:
    found = reported(row, "difference")
    percent, ends = interval_title(row), interval(found)
    if ends == NONE:
        return f" (no {percent}: too few)"
    return f", {percent} {ends}{disagreement(row, found)}"


def _evidence_of_comparison(row: Test) -> str:
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
