"""Deviations of a report from its plan, one sentence each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from vrcomfort.records.names import natural
from vrcomfort.report.analyses.anova import ANOVA
from vrcomfort.report.analyses.comparisons import COMPARISONS
from vrcomfort.report.analyses.equivalence import EQUIVALENCE
from vrcomfort.report.analyses.mixed import MIXED_MODELS
from vrcomfort.report.analyses.signed_rank import TESTS
from vrcomfort.report.plausibility import some_of
from vrcomfort.report.study_data import short_forms
from vrcomfort.report.withdrawals import everybody
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.signed_rank import EXACT_UP_TO

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from vrcomfort.report.analyses import AnalysisData, Rows
    from vrcomfort.report.analyses.comparisons import ComparisonRow
    from vrcomfort.report.analyses.contract import Analysis
    from vrcomfort.report.analyses.equivalence import EquivalenceRow
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData

    Compared: TypeAlias = SignedRankRow | ComparisonRow | EquivalenceRow


@dataclass(frozen=True)
class Deviation:
    """A departure from the plan: a sentence without full stop, and the participants concerned."""

    kind: str
    text: str
    participants: tuple[str, ...]


def deviations(data: AnalysisData, rows: Rows, labels: Mapping[str, str]) -> list[Deviation]:
    """Return every deviation; `labels` are those of the sides of contrasts."""
    study, scored, plan = data.study, data.scored, data.plan

    def in_words(test: Compared) -> str:
        a, b = (labels.get(side, side) for side in (test.a, test.b))
        return f"{scored.titles[test.outcome]}, {a} minus {b}"

    return [
        *_numbers(study, plan),
        *_excluded_without_a_rule(study, plan),
        *_named_and_absent(study, plan),
        *_outcomes(study, scored),
        *_timepoints(study, plan),
        *_baseline(scored, plan),
        *_not_compared((*COMPARISONS.of(rows), *EQUIVALENCE.of(rows)), in_words),
        *_not_compared(TESTS.of(rows), in_words),
        *_other_method(TESTS.of(rows), plan, in_words),
        *_models(rows, scored, plan),
    ]


def _deviation(kind: str, text: str, participants: list[str] | None = None) -> Deviation:
    return Deviation(kind, text, tuple(participants or ()))


def _numbers(study: StudyData, plan: Plan) -> Iterator[Deviation]:
    there = len(everybody(study))
    if plan.participants is not None and there != plan.participants:
        kind = "fewer_participants" if there < plan.participants else "more_participants"
        were = "was" if there == 1 else "were"
        yield _deviation(
            kind, f"{plan.participants} participants were planned; {there} {were} there"
        )


def _excluded_without_a_rule(study: StudyData, plan: Plan) -> Iterator[Deviation]:
    named = {who for rule in plan.exclusions for who in rule.participants}
    gone = [p["participant"] for p in study.participants if p["status"] == "excluded"]
    gone = sorted(set(gone) - named, key=natural)
    if gone:
        were = "was" if len(gone) == 1 else "were"
        text = (
            f"{some_of(gone)} {were} excluded by the experimenter, which no rule of the plan names"
        )
        yield _deviation("excluded_without_rule", text, gone)


def _named_and_absent(study: StudyData, plan: Plan) -> Iterator[Deviation]:
    there = set(everybody(study))
    for rule in plan.exclusions:
        absent = [who for who in rule.participants if who not in there]
        if absent:
            text = f"rule {rule.name} excludes {some_of(absent)}, of whom there are no data"
            yield _deviation("exclusion_not_found", text, absent)


def _outcomes(study: StudyData, scored: Exposures) -> Iterator[Deviation]:
    for name, why in scored.absent.items():
        yield _deviation("outcome_not_found", f"outcome {name} is not in the data: {why}")
    for instrument in short_forms(study):
        titles = [each.title for each in scored.outcomes if each.instrument == instrument.name]
        if titles:
            lost = ", ".join(instrument.not_asked)
            text = f"{', '.join(titles)}: the {instrument.short} was asked without {lost}"
            yield _deviation("short_form", text)


def _timepoints(study: StudyData, plan: Plan) -> Iterator[Deviation]:
    there = {sheet.timepoint for sheet in study.sheets}
    named = [name for each in plan.contrasts for name in (each.a_timepoint, each.b_timepoint)]
    named += [rule.timepoint for rule in plan.exclusions]
    for name in dict.fromkeys(name for name in named if name and name not in there):
        hint = did_you_mean(name, there)
        yield _deviation("timepoint_not_found", f"no questionnaire is of `{name}` ({hint})")


def _baseline(scored: Exposures, plan: Plan) -> Iterator[Deviation]:
    raw = [scored.titles[name] for name, basis in scored.bases.items() if basis == "raw_post"]
    if plan.scores == "difference_from_baseline" and raw:
        text = (
            f"there is no baseline to subtract from {', '.join(raw)}: raw scores after exposure "
            "are compared"
        )
        yield _deviation("no_baseline", text)


def _not_compared(
    tests: Sequence[Compared], in_words: Callable[[Compared], str]
) -> Iterator[Deviation]:
    """Yield why comparisons could not be made."""
    untested = [row for row in tests if row.not_tested]
    for reason in dict.fromkeys(row.not_tested for row in untested):
        which = [in_words(row) for row in untested if row.not_tested == reason]
        yield _deviation("not_tested", f"no test of {'; '.join(which)}: {reason}")


def _other_method(
    tests: Sequence[SignedRankRow], plan: Plan, in_words: Callable[[Compared], str]
) -> Iterator[Deviation]:
    """Yield of which tests p is not the planned one."""
    fallen = [(test, test.found.method) for test in tests if test.found]
    fallen = [(test, method) for test, method in fallen if method != plan.p_value]
    if fallen:
        what = "; ".join(in_words(test) for test, _ in fallen)
        text = f"p is {fallen[0][1]} with more than {EXACT_UP_TO} pairs: {what}"
        yield _deviation("other_method", text)


def _models(rows: Rows, scored: Exposures, plan: Plan) -> Iterator[Deviation]:
    models: tuple[tuple[Analysis[Any], str], ...] = (
        (ANOVA, "ANOVA"), (MIXED_MODELS, "mixed model")
    )  # fmt: skip
    for analysis, name in models:
        untested = [row for row in analysis.of(rows) if row.not_tested]
        for reason in dict.fromkeys(row.not_tested for row in untested):
            whose = [scored.titles[row.outcome] for row in untested if row.not_tested == reason]
            yield _deviation("not_tested", f"no {name} of {', '.join(whose)}: {reason}")
    wanted = {factor.name for factor in plan.anova}
    made = [set(row.fit.factors) for row in ANOVA.of(rows) if row.fit]
    if made and (absent := sorted(wanted.difference(*made))):
        text = f"{', '.join(absent)} has one level in the data and is not in the ANOVA"
        yield _deviation("factor_left_out", text)
    left = {name for row in MIXED_MODELS.of(rows) if row.fit for name in row.fit.left_out}
    if left:
        text = (
            f"{', '.join(sorted(left))} cannot be told apart from the other effects and "
            f"{'is' if len(left) == 1 else 'are'} not in the mixed model"
        )
        yield _deviation("effect_left_out", text)
