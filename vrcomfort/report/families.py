"""Decisions of tests, alone or in a family, and the intervals and words that say the same.

One rule for whatever a report says of a test. The p that decides is the adjusted one where there is
a family. The intervals beside it are those of the level at which Holm's method decides on the test,
so that they hold no difference exactly where none was shown.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

from vrcomfort.report.words import number, p_equals, p_value
from vrcomfort.stats.multiplicity import holm_levels
from vrcomfort.stats.ranks import level_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vrcomfort.report.descriptives import Description

Verdict = Literal["higher", "lower", "not_shown", "not_possible"]
"""Of the first side; `not_possible`: so few people cannot give a p at which a difference is shown,
whatever they answer."""
Intervals = TypeVar("Intervals")


@dataclass(frozen=True)
class Decision(Generic[Intervals]):
    """The decision of a test, made once all are; all is None where there is no test.

    Parameters
    ----------
    level
        At which the test decides among those of its family.
    smallest_p
        That so many people can give, whatever they answer.
    higher
        Whether the first side is.
    simultaneous
        The intervals at `level`, where that is smaller than the plan's.
    """

    family: str | None = None
    p_holm: float | None = None
    level: float | None = None
    verdict: Verdict | None = None
    smallest_p: float | None = None
    higher: bool | None = None
    simultaneous: Intervals | None = None


def decided(
    p: float, smallest_p: float, level: float, p_values: Sequence[float | None], place: int, *,
    higher: bool,
) -> tuple[float | None, Verdict]:  # fmt: skip
    """Return the level at which a test decides among others, and its verdict."""
    own_level = holm_levels(list(p_values), level)[place]
    if own_level is not None and p <= own_level:
        return own_level, "higher" if higher else "lower"
    best = [*p_values]
    best[place] = smallest_p
    reachable = holm_levels(best, level)[place]
    possible = reachable is not None and smallest_p <= reachable
    return own_level, "not_shown" if possible else "not_possible"


def verdict_alone(
    p: float | None, smallest_p: float, confidence: float, *, higher: bool
) -> Verdict | None:
    """Return the verdict of a test that is in no family; None where there is no p."""
    if p is None:
        return None
    return decided(p, smallest_p, level_of(confidence), [p], 0, higher=higher)[1]


def is_shown(verdict: Verdict | None) -> bool:
    """Return whether a test has shown a difference."""
    return verdict not in {None, "not_shown", "not_possible"}


def disagreement(verdict: Verdict | None, found: Any, null: float = 0.0) -> str:
    """Say that an interval and the verdict of its test differ about the null value; or nothing.

    Those of the default methods do not, but for rank-biserials and correlations, whose intervals
    are not inversions of the printed test; nor is that of a plan that asks for order statistics.
    """
    if found is None or (found.low is None and found.high is None):
        return ""
    if holds(found, null) != is_shown(verdict):
        return ""
    value = f"{null:g}".removeprefix("0") or "0"
    if is_shown(verdict):
        return f" (which includes {value}, though the test rejects it)"
    return f" (which excludes {value}, though the test does not reject it)"


def holds(found: Any, value: float) -> bool:
    """Return whether a value is in an interval; ends may be open or missing."""
    low, high = found.low, found.high
    if getattr(found, "holds_rejected_zero", False) and value == 0:
        return False
    above = low is None or low < value or (low == value and getattr(found, "low_closed", True))
    below = high is None or high > value or (high == value and getattr(found, "high_closed", True))
    return bool(above and below)


def difference_in_words(decision: Decision[Any], a: str, b: str, within: str, few: str) -> str:
    """Return the decision on two sides in words; `few` names the shortage of data."""
    if decision.verdict == "not_possible":
        return f"with {few}, no difference could be shown between {a} and {b}"
    if not is_shown(decision.verdict):
        return f"no difference was shown between {a} and {b}"
    return f"{decision.verdict} {within} {a} than {within} {b}"


def too_few_in_words(decision: Decision[Any], confidence: float, zeros: int | None = None) -> str:
    """Return the shortage of data that keeps a test from showing a difference."""
    if decision.smallest_p is not None and decision.smallest_p <= level_of(confidence):
        return "so few people for so many tests"
    return "so few people whose scores differ" if zeros else "so few people"


def interval_title(decision: Decision[Any], confidence: float) -> str:
    """Return the name of the interval beside a verdict: its level is that of the verdict."""
    percent = f"{100 * confidence:g}\u00a0% CI"
    return f"Holm-adjusted {percent}" if decision.simultaneous else percent


def _is_adjusted(p: float | None, decision: Decision[Any]) -> bool:
    """Return whether the family of a test changes its p; one of a single test does not."""
    return decision.p_holm is not None and decision.p_holm != p


def deciding_p(p: float | None, decision: Decision[Any]) -> str:
    """Return the p by which a test decides: the adjusted one in a family."""
    if _is_adjusted(p, decision):
        return f"Holm-adjusted {p_equals(decision.p_holm)}"
    return p_equals(p)


def p_in_words(p: float | None, decision: Decision[Any]) -> str:
    """Return the unadjusted p, and its least possible value where no difference could be shown."""
    unadjusted = "unadjusted " if _is_adjusted(p, decision) else ""
    least = ""
    if decision.verdict == "not_possible":
        least = f" (with so few people, at least {p_value(decision.smallest_p)})"
    return f"{unadjusted}{p_equals(p)}{least}"


def means_in_words(a: str, of_a: Description, b: str, of_b: Description) -> str:
    """Return the means of two sides, their difference beside them, and standard deviations."""
    sides = f"{_mean_and_sd(a, of_a)}, {_mean_and_sd(b, of_b)}"
    return f"Means: {sides}; mean difference {number(of_a.mean - of_b.mean)}."


def _mean_and_sd(label: str, found: Description) -> str:
    return f"{label} {number(found.mean)} (SD\u00a0=\u00a0{number(found.sd)})"
