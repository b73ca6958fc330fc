"""The answers: one plain sentence for each question that a plan asks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.further_answers import (
    comparison_answer,
    decisive_p,
    further_answers,
    line_of,
    mean_and_sd,
)
from vrcomfort.report.orders import in_words
from vrcomfort.report.words import NONE, fraction, interval, number, p_equals
from vrcomfort.stats.ranks import fewest_for_interval

if TYPE_CHECKING:
    from vrcomfort.report.vocabulary import Vocabulary

Test = dict[str, Any]

MOST_ANSWERS = 8


def answers(results: dict[str, Any], words: Vocabulary) -> list[dict[str, Any]]:
    """Return the sentences by score, in the plan's order: its name, sentences, and whether main.

    Of many questions those of other scores than the first are in the tables alone.
    """
    tests, order = [*results["tests"], *results["comparisons"]], list(words.outcomes)
    shown = order if len(tests) <= MOST_ANSWERS else order[:1]
    groups = [
        {
            "outcome": outcome,
            "name": words.outcome(outcome),
            "primary": outcome == order[0],
            "lines": [answer(t, words) for t in tests if t["outcome"] == outcome],
        }
        for outcome in shown
        if any(t["outcome"] == outcome for t in tests)
    ]
    others = further_answers(results, words)
    alone = {"outcome": "", "name": "", "primary": not groups, "lines": others}
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
    if test["effect"] is None:
        return f"{name}: nobody’s score differed between {a} and {b} (n = {test['n']})."
    size = test["descriptives"]
    of_a, of_b = f"{a} ({mean_and_sd(size[test['a']])})", f"{b} ({mean_and_sd(size[test['b']])})"
    if decisive_p(test) > 1 - test["effect"]["confidence"]:
        said = f"no difference was shown between {of_a} and {of_b}"
    else:
        said = f"{'higher' if _higher(test) else 'lower'} under {of_a} than under {of_b}"
    return f"{name}: {said}; difference {_shift(test, words)}, n\u00a0=\u00a0{test['n']}."


def _higher(test: Test) -> bool:
    """Return whether ranks say more under a; the shift may be 0 where most differences are."""
    return bool(test["w_plus"] > test["w_minus"])


def _evidence(test: Test, words: Vocabulary) -> str:
    if test["not_tested"] or test["effect"] is None:
        return ""
    holm = "" if test["p_holm"] is None else f", Holm-adjusted {p_equals(test['p_holm'])}"
    return (
        f"{test['method'].capitalize()} {p_equals(test['p'])}{holm}; Z\u00a0=\u00a0"
        f"{number(test['z'])}, r\u00a0=\u00a0{_rank_biserial(test, words)}.{_order_of(test, words)}"
    )


def _order_of(test: Test, words: Vocabulary) -> str:
    """Return what makes the result of a test one of the order as well."""
    if not test["confounded"]:
        return ""
    return f" But {in_words(test['confounded'], words.condition)}."


def _shift(test: Test, words: Vocabulary) -> str:
    shift = test["shift"]
    percent = f"{100 * test['effect']['confidence']:g}\u00a0% CI"
    found = interval(shift)
    of = f"{number(shift['estimate'])} {words.unit(test['outcome'])}".rstrip()
    return (
        f"{of} (no {percent}: too few differences)" if found == NONE else f"{of}, {percent} {found}"
    )


def _rank_biserial(test: Test, words: Vocabulary) -> str:
    effect = test["effect"]
    r = fraction(effect["estimate"])
    if effect["low"] is not None:
        return f"{r} {interval(effect, bounded=True)}"
    few = test["n"] - test["zeros"] < fewest_for_interval(effect["confidence"])
    a = words.condition(test["a"])
    reason = "too few differences other than 0" if few else f"{a} has no score but 0"
    return f"{r} (no {100 * effect['confidence']:g}\u00a0% CI: {reason})"
