"""The answers: one plain sentence for each question that a plan asks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.report.analyses import Sentence, outcome_sentences, sentences

if TYPE_CHECKING:
    from vrcomfort.report.results import Results
    from vrcomfort.report.vocabulary import Vocabulary

MOST_ANSWERS = 8


@dataclass(frozen=True)
class OutcomeAnswers:
    """The sentences on an outcome, or, with blank names, on what is of no single outcome."""

    outcome: str
    name: str
    primary: bool
    lines: list[Sentence]


def answers(results: Results, words: Vocabulary) -> list[OutcomeAnswers]:
    """Return the sentences by outcome, in the plan's order.

    Of many questions those of other outcomes than the first are in the tables alone. None is
    primary where the planned primary outcome is not in the data.
    """
    said, order = outcome_sentences(results.rows, words), list(words.outcomes)
    shown = order if len(said) <= MOST_ANSWERS else order[:1]
    groups = [
        OutcomeAnswers(
            outcome,
            words.outcome(outcome),
            primary=outcome == order[0] and not results.without_primary,
            lines=[sentence for name, sentence in said if name == outcome],
        )
        for outcome in shown
        if any(name == outcome for name, _ in said)
    ]
    others = sentences(results.rows, words)
    alone = OutcomeAnswers("", "", not (groups or results.without_primary), others)
    return [*groups, alone] if others else groups
