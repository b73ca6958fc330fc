"""What a report had to do otherwise than its plan says: one sentence for each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vrcomfort.records.names import natural
from vrcomfort.report.notices import names
from vrcomfort.report.study_data import short_forms
from vrcomfort.report.withdrawals import everybody
from vrcomfort.settings import did_you_mean
from vrcomfort.stats.signed_rank import EXACT_UP_TO

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vrcomfort.report.analyses.comparisons import ComparisonRow
    from vrcomfort.report.analyses.equivalence import EquivalenceRow
    from vrcomfort.report.analyses.signed_rank import SignedRankRow
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


@dataclass(frozen=True)
class Deviation:
    """A departure from the plan: a sentence without full stop, and the participants concerned."""

    kind: str
    text: str
    participants: tuple[str, ...]


def deviations(
    study: StudyData, scored: Exposures, plan: Plan, results: dict[str, Any]
) -> list[Deviation]:
    """Return every deviation."""
    return [
        *_numbers(study, plan),
        *_excluded_without_a_rule(study, plan),
        *_named_and_absent(study, plan),
        *_outcomes(study, scored),
        *_timepoints(study, plan),
        *_baseline(scored, plan, results),
        *_tests(results, plan),
        *_models(results),
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
        text = f"{names(gone)} {were} excluded by the experimenter, which no rule of the plan names"
        yield _deviation("excluded_without_rule", text, gone)


def _named_and_absent(study: StudyData, plan: Plan) -> Iterator[Deviation]:
    there = set(everybody(study))
    for rule in plan.exclusions:
        absent = [who for who in rule.participants if who not in there]
        if absent:
            text = f"rule {rule.name} excludes {names(absent)}, of whom there are no data"
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


def _baseline(scored: Exposures, plan: Plan, results: dict[str, Any]) -> Iterator[Deviation]:
    titles = _titles(results)
    raw = [titles[name] for name, basis in scored.bases.items() if basis == "raw_post"]
    if plan.scores == "difference_from_baseline" and raw:
        text = (
            f"there is no baseline to subtract from {', '.join(raw)}: raw scores after exposure "
            "are compared"
        )
        yield _deviation("no_baseline", text)


def _titles(results: dict[str, Any]) -> dict[str, str]:
    return {each["name"]: each["title"] for each in results["outcomes"]}


def _tests(results: dict[str, Any], plan: Plan) -> Iterator[Deviation]:
    tests = results["tests"]
    yield from _not_compared(results)
    for reason in dict.fromkeys(test.not_tested for test in tests if test.not_tested):
        untested = [_in_words(t, results) for t in tests if t.not_tested == reason]
        yield _deviation("not_tested", f"no test of {'; '.join(untested)}: {reason}")
    fallen = [t for t in tests if t.found and t.found.method != plan.p_value]
    if fallen:
        what = "; ".join(_in_words(test, results) for test in fallen)
        text = f"p is {fallen[0].found.method} with more than {EXACT_UP_TO} pairs: {what}"
        yield _deviation("other_method", text)


def _not_compared(results: dict[str, Any]) -> Iterator[Deviation]:
    """Yield why a comparison by another test, or an equivalence, could not be made."""
    untested = [row for row in (*results["comparisons"], *results["equivalence"]) if row.not_tested]
    for reason in dict.fromkeys(row.not_tested for row in untested):
        which = [_in_words(row, results) for row in untested if row.not_tested == reason]
        yield _deviation("not_tested", f"no test of {'; '.join(which)}: {reason}")


def _in_words(test: SignedRankRow | ComparisonRow | EquivalenceRow, results: dict[str, Any]) -> str:
    labels, name = results["labels"], _titles(results)[test.outcome]
    a, b = (labels.get(side, side) for side in (test.a, test.b))
    return f"{name}, {a} minus {b}"


def _models(results: dict[str, Any]) -> Iterator[Deviation]:
    for key, name in (("anova", "ANOVA"), ("mixed_models", "mixed model")):
        for reason in dict.fromkeys(row.not_tested for row in results[key] if row.not_tested):
            whose = [
                _titles(results)[row.outcome] for row in results[key] if row.not_tested == reason
            ]
            yield _deviation("not_tested", f"no {name} of {', '.join(whose)}: {reason}")
    wanted = {factor["name"] for factor in results["plan"]["anova"]}
    made = [set(row.fit.factors) for row in results["anova"] if row.fit]
    if made and (absent := sorted(wanted - set.union(*made))):
        text = f"{', '.join(absent)} has one level in the data and is not in the ANOVA"
        yield _deviation("factor_left_out", text)
    left = {name for row in results["mixed_models"] if row.fit for name in row.fit.left_out}
    if left:
        text = (
            f"{', '.join(sorted(left))} cannot be told apart from the other effects and "
            f"{'is' if len(left) == 1 else 'are'} not in the mixed model"
        )
        yield _deviation("effect_left_out", text)
