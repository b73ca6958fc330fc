"""The answer of ratings during exposure, in a sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vrcomfort.report.analyses.contract import Sentence
from vrcomfort.report.ratings.time_courses import TITLES
from vrcomfort.report.words import degrees, interval, number, p_equals

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vrcomfort.report.ratings.analysis import RatingTimeCourses, TimeCourseAnalysis
    from vrcomfort.report.ratings.time_courses import SummaryEstimates, SummaryStatistics
    from vrcomfort.report.vocabulary import Vocabulary


def rating_sentences(courses: TimeCourseAnalysis, words: Vocabulary) -> Iterator[Sentence]:
    """Yield the effect of conditions on the plan's first summary of ratings."""
    found = courses.ratings
    if found is None or not found.curves:
        return
    model = found.models[0]
    title = f"{found.short} ratings during exposure, {TITLES[model.summary]}"
    means = _means(found, model.summary, words)
    if len(found.conditions) == 1:
        yield Sentence(f"{title}: {means}.")
    elif model.found is None:
        yield Sentence(f"{title}: conditions could not be compared ({model.not_fitted}).", means)
    else:
        said = _effect(model.found, found.conditions, 1 - courses.confidence, words)
        yield Sentence(f"{title}: {said}.", f"Means: {means}.")


def _effect(found: SummaryEstimates, conditions: list[str], level: float, words: Vocabulary) -> str:
    """Return the estimate of two conditions, or the test of several, as a clause."""
    n = f"n\u00a0=\u00a0{found.n_values} exposures of {found.n_participants} participants"
    if len(found.terms) > 1:
        test = found.omnibus["condition"].test
        shown = test.p is not None and test.p <= level
        said = "the conditions differed" if shown else "no difference of the conditions was shown"
        df = (
            ""
            if test.df_error is None
            else f"({test.df_effect}, {degrees(round(test.df_error, 2))})"
        )
        return f"{said}, F{df}\u00a0=\u00a0{number(test.f)}, {p_equals(test.p)}, {n}"
    (effect,) = found.terms.values()
    a, b = (
        words.condition(name)
        for name in sorted(conditions, key=lambda name: name == found.reference)
    )
    verdict = f"no difference was shown between {a} and {b}"
    if effect.p is not None and effect.p <= level:
        verdict = f"{'higher' if effect.estimate > 0 else 'lower'} under {a} than under {b}"
    t = f"t({degrees(round(effect.df, 2))})\u00a0=\u00a0{number(effect.t)}"
    return (
        f"{verdict}; the mean difference was {number(effect.estimate)} points, "
        f"{100 * (1 - level):g}\u00a0% CI {interval(effect)}, {t}, {p_equals(effect.p)}, {n}"
    )


def _means(found: RatingTimeCourses, summary: str, words: Vocabulary) -> str:
    """Return the mean of a summary under each condition, with its standard deviation."""
    rows = [row for row in found.summaries if row.summary == summary and row.condition is not None]
    return "; ".join(_mean(row, words) for row in rows)


def _mean(row: SummaryStatistics, words: Vocabulary) -> str:
    label = words.condition(row.condition) if row.condition else "mean"
    return f"{label} {number(row.mean)} (SD\u00a0=\u00a0{number(row.sd)}, n\u00a0=\u00a0{row.n})"
