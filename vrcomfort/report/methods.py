"""The methods section: methods used in this report alone, with their references."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vrcomfort.report.analyses import MethodsParagraph, methods_paragraphs
from vrcomfort.report.descriptives import TIMEPOINT
from vrcomfort.report.references import is_known
from vrcomfort.report.sections import section_paragraphs
from vrcomfort.stats.means import RESAMPLES, SEED

if TYPE_CHECKING:
    from collections.abc import Iterable

    from vrcomfort.report.analyses import ReportContext
    from vrcomfort.report.results import Results
    from vrcomfort.report.sections import Section
    from vrcomfort.report.vocabulary import ReportedInstrument, Vocabulary


def methods(
    results: Results, report: ReportContext, sections: Iterable[Section]
) -> list[MethodsParagraph]:
    """Return the paragraphs on everything that this report holds."""
    plan = results.plan
    return [
        method
        for method in (
            _scoring(results, report.words),
            _people(),
            *methods_paragraphs(results.rows, report, "primary"),
            *methods_paragraphs(results.rows, report, "tests"),
            _describing(),
            *methods_paragraphs(results.rows, report, "sensitivity"),
            *methods_paragraphs(results.rows, report, "models", "order"),
            _withdrawals(results),
            *section_paragraphs(sections),
            _figures(results) if report.drawn else None,
            _answering(results),
            MethodsParagraph("Choices", plan.note) if plan.note else None,
        )
        if method
    ]


def basis_sentence(results: Results) -> str:
    """Describe the basis of the scores; blank where there are only measures."""
    if results.score_basis == "measured":
        return ""
    if results.score_basis == "difference_from_baseline":
        sides = [side.timepoint for test in results.tests for side in test.sides]
        moments = "Comparisons of timepoints are of raw scores. " if any(sides) else ""
        other = "Other scores" if moments else "Scores"
        return (
            f"{moments}{other} are changes from baseline: the score after an exposure minus the "
            "same participant’s nearest baseline."
        )
    why = (
        "as the plan asks"
        if has_baseline(results)
        else "because the data have no baseline questionnaire"
    )
    return (
        f"Scores are raw scores after exposure, {why}. They include symptoms from before the "
        "exposure."
    )


def has_baseline(results: Results) -> bool:
    """Return whether any exposure has scores before it."""
    baseline = results.plan.baseline_timepoint
    return any(row.by == TIMEPOINT and row.level == baseline for row in results.descriptives)


def _scoring(results: Results, words: Vocabulary) -> MethodsParagraph | None:
    several = any(n > 1 for n in results.participants.exposures_per_condition.values())
    repeated = (
        " Where a condition has several exposures their integer sums are added before testing "
        "and reported as the mean per exposure."
        if several
        else ""
    )
    if not results.outcomes:
        return None
    if not words.instruments:
        return MethodsParagraph("Measures", f"{_measures(results)}{repeated}".strip())
    incomplete = (
        "Missing answers count as the mean of the others of their score where enough are given."
        if results.plan.missing_items == "prorate"
        else "Incomplete questionnaires were not scored."
    )
    text = (
        f"{' '.join(map(_instrument, words.instruments))} {incomplete} "
        f"{basis_sentence(results)}{repeated} {_measures(results)}".rstrip()
    )
    cited = [f"instrument_{each.name}" for each in words.instruments]
    return MethodsParagraph("Scores", text, tuple(key for key in cited if is_known(key)))


def _measures(results: Results) -> str:
    """Describe each measure, with the direction that is better."""
    named = [each for each in results.outcomes if each.basis == "measured"]
    return " ".join(
        f"{each.title}{' in ' + each.unit_label if each.unit_label else ''} is "
        f"{each.definition}{'; ' + each.better + ' is better' if each.better else ''}."
        for each in named
    )


def _instrument(asked: ReportedInstrument) -> str:
    """Describe an instrument: items, source and scoring rule."""
    known = f"{asked.short}; " if asked.short != asked.title else ""
    count, scale = len(asked.items), asked.answers
    items = f"{count} items, {scale}" if count > 1 else scale
    after = f" after {asked.citation}" if asked.citation else ""
    rule = f": {asked.rule}" if asked.rule else ""
    return f"The {asked.title} ({known}{items}) was scored{after}{rule}."


def _people() -> MethodsParagraph:
    return MethodsParagraph(
        "Participants",
        "A test includes the participants with a score of every planned exposure to both of its "
        "conditions, between groups to their own. The planned number is the "
        "protocol’s or, without one, the most frequent. The flow chart follows CONSORT (Schulz et "
        "al., 2010).",
        ("schulz_2010",),
    )


def _describing() -> MethodsParagraph:
    return MethodsParagraph(
        "Descriptives",
        "The confidence interval of a condition’s mean is the wider, at each end, of the t and the "
        f"bootstrap-t interval ({RESAMPLES} resamples of n − 1, seed {SEED}; Efron & Tibshirani, "
        "1993; Rao & Wu, 1988), within the range of the score. Standard deviations use n − 1; "
        "quantiles follow definition 7 of Hyndman & Fan (1996).",
        ("efron_1993", "rao_1988", "hyndman_1996"),
    )


def _withdrawals(results: Results) -> MethodsParagraph | None:
    found = results.withdrawals
    if not found.n:
        return None
    fisher = found.by_first_condition.fisher_p is not None
    text, cited = "Withdrawals were counted by condition, scene and position.", []
    if results.sensitivity:
        text += (
            " In the sensitivity analyses each was ranked as worse than every observed difference "
            "(worst-rank analysis; Lachin, 1999)."
        )
        cited.append("lachin_1999")
    if fisher:
        text += " First conditions were compared with Fisher’s (1935) exact test."
        cited.append("fisher_1935")
    return MethodsParagraph("Withdrawals", text, tuple(cited))


def _figures(results: Results) -> MethodsParagraph | None:
    tests, others = results.tests, results.comparisons
    if all(row.not_tested for row in tests) and all(row.not_tested for row in others):
        return None
    return MethodsParagraph(
        "Figures",
        "Estimation plots (Gardner & Altman, 1986; Ho et al., 2019) show every participant, and "
        "the difference with the interval that belongs to its test. Colours are after Okabe & Ito "
        "(2008); each condition has a shape of its own as well.",
        ("gardner_1986", "ho_2019", "okabe_2008"),
    )


def _answering(results: Results) -> MethodsParagraph | None:
    if not results.answering.times:
        return None
    return MethodsParagraph(
        "Answering times",
        "Questionnaires with a median below 2 s per question count as fast (Huang et al., 2012). "
        "None was excluded for it.",
        ("huang_2012",),
    )
