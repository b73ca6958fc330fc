"""Scores of the Simulator Sickness Questionnaire (Kennedy et al. 1993).

Raw sums stay integers: weighted scores are not exact, and ranks taken on them break ties that the
answers have. Rank the raw sums; multiply by the weight afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from vrcomfort.errors import InputError
from vrcomfort.questionnaire.instruments import SSQ

LOADINGS: Mapping[str, str] = {
    "general_discomfort": "NO",
    "fatigue": "O",
    "headache": "O",
    "eyestrain": "O",
    "difficulty_focusing": "OD",
    "increased_salivation": "N",
    "sweating": "N",
    "nausea": "ND",
    "difficulty_concentrating": "NO",
    "fullness_of_head": "D",
    "blurred_vision": "OD",
    "dizzy_eyes_open": "D",
    "dizzy_eyes_closed": "D",
    "vertigo": "D",
    "stomach_awareness": "N",
    "burping": "N",
}
"""item → the subscales it counts for, each with weight 1 (21 loadings)."""

WEIGHTS: Mapping[str, float] = {"N": 9.54, "O": 7.58, "D": 13.92, "T": 3.74}


def weighted(raw_sum: int, outcome: str) -> float:
    """Return the score of a raw sum: the float64 nearest to the exact product (two decimals)."""
    return raw_sum * round(100 * WEIGHTS[outcome]) / 100


@dataclass(frozen=True)
class SsqScore:
    """Raw sums of one questionnaire and, from them, its scores.

    Parameters
    ----------
    nausea_raw, oculomotor_raw, disorientation_raw
        Sums of the answers that load on each subscale, at most 21.
    """

    nausea_raw: int
    oculomotor_raw: int
    disorientation_raw: int

    @property
    def total_raw(self) -> int:
        """Return the sum of the three raw sums (items with two loadings count twice)."""
        return self.nausea_raw + self.oculomotor_raw + self.disorientation_raw

    @property
    def nausea(self) -> float:
        """Return N, 0 to 200.34."""
        return weighted(self.nausea_raw, "N")

    @property
    def oculomotor(self) -> float:
        """Return O, 0 to 159.18."""
        return weighted(self.oculomotor_raw, "O")

    @property
    def disorientation(self) -> float:
        """Return D, 0 to 292.32."""
        return weighted(self.disorientation_raw, "D")

    @property
    def total(self) -> float:
        """Return the total severity, 0 to 235.62: 3.74 × the raw sums, not × the subscales."""
        return weighted(self.total_raw, "T")


def score(answers: Mapping[str, int | None]) -> SsqScore | None:
    """Score one questionnaire: item name → answer 0–3.

    Returns
    -------
    SsqScore or None
        None where an item is unanswered: a sum without it would be too low.

    Raises
    ------
    InputError
        If an item is unknown or an answer is out of range.
    """
    for item, answer in answers.items():
        if item not in LOADINGS:
            raise InputError(f"`{item}` is not an item of the SSQ")
        if answer is not None and not SSQ.low <= answer <= SSQ.high:
            raise InputError(f"`{item}` is {answer}; SSQ answers are {SSQ.low} to {SSQ.high}")
    if any(answers.get(item) is None for item in LOADINGS):
        return None
    return SsqScore(*(_raw_sum(answers, subscale) for subscale in "NOD"))


def _raw_sum(answers: Mapping[str, int | None], subscale: str) -> int:
    return sum(answers[item] or 0 for item, loads in LOADINGS.items() if subscale in loads)
