"""The answers: one plain sentence for each question that a plan asks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.families import disagreement, reported
from vrcomfort.report.further_answers import (
    comparison_answer,
    difference_in_words,
    further_answers,
    interval_title,
    line_of,
    mean_and_sd,
    p_in_words,
    too_few,
)
from vrcomfort.report.orders import in_words
from vrcomfort.report.words import NONE, fraction, interval, number
from vrcomfort.stats.ranks import fewest_for_interval

if TYPE_CHECKING:
    from vrcomfort.report.vocabulary import Vocabulary

Test = dict[str, Any]

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
    others = further_answers(results, words)
    alone = {
        "outcome": "",
        "name": "",
        "primary": not (groups or results["without_primary"]),
        "lines": others,
    }
    return [*groups, alone] if others else groups


def answer(test: Test, words: Vocabulary) -> dict[str, str]:
    """Return what one test says: `claim` in plain words, `evidence`, and both as `text`."""
    if "design" in test:
        return comparison_answer(test, words)
    claim, evidence = _claim(test, words), _evidence(test, words)
    return line_of(claim, evidence)


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
