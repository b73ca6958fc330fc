"""The answers: one plain sentence for each question that a plan asks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.analyses import outcome_sentences, sentences

if TYPE_CHECKING:
    from vrcomfort.report.vocabulary import Vocabulary

MOST_ANSWERS = 8


def answers(results: dict[str, Any], words: Vocabulary) -> list[dict[str, Any]]:
    """Return the sentences by score, in the plan's order: its name, sentences, and whether main.

    Of many questions those of other scores than the first are in the tables alone. None is main
    where the planned primary outcome is not in the data.
    """
    said, order = outcome_sentences(results, words), list(words.outcomes)
    shown = order if len(said) <= MOST_ANSWERS else order[:1]
    groups = [
        {
            "outcome": outcome,
            "name": words.outcome(outcome),
            "primary": outcome == order[0] and not results["without_primary"],
            "lines": [sentence for name, sentence in said if name == outcome],
        }
        for outcome in shown
        if any(name == outcome for name, _ in said)
    ]
    others = sentences(results, words)
    alone = {
        "outcome": "",
        "name": "",
        "primary": not (groups or results["without_primary"]),
        "lines": others,
    }
    return [*groups, alone] if others else groups
