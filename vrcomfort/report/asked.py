"""Which questionnaires count: of whom, at which timepoints, complete, and asked last."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vrcomfort.report.baselines import Values, moment_of
from vrcomfort.report.outcomes import Outcome, outcomes_in

if TYPE_CHECKING:
    from fractions import Fraction

    from vrcomfort.questionnaire import Sheet
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


def kept_by_the_experimenter(study: StudyData) -> list[Sheet]:
    """Leave out those whom participants.csv calls excluded; `why_not` gives the reason."""
    gone = {p["participant"] for p in study.participants if p["status"] == "excluded"}
    return [sheet for sheet in study.sheets if sheet.participant not in gone]


def check_timepoints(sheets: list[Sheet], plan: Plan) -> None:
    """Raise InputError if no questionnaire is from the plan's moment after exposure."""
    found = sorted({sheet.timepoint for sheet in sheets})
    if found and plan.exposure_timepoint not in found:
        raise plan.fault(
            f"no questionnaire has the timepoint `{plan.exposure_timepoint}` that the analysis "
            f"plan {plan.name} calls exposure_timepoint; the data have {', '.join(found)}",
            "exposure_timepoint",
        )


def unused_timepoints(study: StudyData, plan: Plan) -> list[str]:
    """Say which questionnaires the plan does not use: one of its timepoints may be misspelt."""
    counts = Counter(sheet.timepoint for sheet in study.sheets)
    known = timepoints_of(plan)
    *first, last = known
    return [
        f"{counts[name]} questionnaires at `{name}` are not used: the analysis plan names "
        f"{', '.join(first)} and {last}"
        for name in sorted(counts.keys() - set(known))
    ]


def timepoints_of(plan: Plan) -> tuple[str, ...]:
    """Return every timepoint that a plan names, in its order."""
    named = [plan.baseline_timepoint, plan.exposure_timepoint, plan.recovery_timepoint]
    named += [name for each in plan.contrasts for name in (each.a_timepoint, each.b_timepoint)]
    named += [rule.timepoint for rule in plan.exclusions]
    return tuple(dict.fromkeys(name for name in named if name))


def last_runs(sheets: list[Sheet], plan: Plan, excluded: list[dict[str, str]]) -> list[Sheet]:
    """Leave out what was asked again later; but each run of a session needs its baseline."""
    last: dict[tuple[str, ...], int] = {}
    for sheet in sheets:
        moment = (*moment_of(sheet), sheet.timepoint)
        last[moment] = max(sheet.run, last.get(moment, 0))

    def counts(sheet: Sheet) -> bool:
        is_last = sheet.run == last[*moment_of(sheet), sheet.timepoint]
        return is_last or sheet.timepoint == plan.baseline_timepoint

    reason = "asked again after the session was resumed"
    excluded += [left_out(sheet, reason) for sheet in sheets if not counts(sheet)]
    return [sheet for sheet in sheets if counts(sheet)]


def left_out(sheet: Sheet, reason: str) -> dict[str, str]:
    """Return the row that says why a questionnaire is not scored."""
    what = {"participant": sheet.participant, "questionnaire": sheet.name, "reason": reason}
    return {**what, "place": sheet.place}


@dataclass(frozen=True)
class Scorer:
    """Scores the questionnaires of one instrument as a plan has it."""

    outcomes: tuple[Outcome, ...]
    items: tuple[str, ...]
    """That scores are made of, of the instrument; all of them are needed, or most."""
    prorate: bool
    fewest: float
    """Share of the items that must be answered to prorate."""

    @classmethod
    def of(cls, instrument: str, outcomes: tuple[Outcome, ...], plan: Plan) -> Scorer:
        """Return the scorer of an instrument's outcomes."""
        loaded = [item for each in outcomes_in([instrument]) for item in each.loadings]
        return cls(
            tuple(each for each in outcomes if each.instrument == instrument),
            tuple(dict.fromkeys(loaded)),
            plan.missing_items == "prorate",
            plan.min_answered,
        )

    def values(self, sheet: Sheet) -> Values | None:
        """Return raw scores and answers; None of a questionnaire with too few answers."""
        answers = sheet.answers
        absent = self.absent(sheet)
        if absent and not self._enough(len(absent)):
            return None
        found: Values = {item: answers.get(item) for item in self.items}
        for outcome in self.outcomes:
            found[outcome.name] = self._score(outcome, sheet)
        return None if any(found[each.name] is None for each in self.outcomes) else found

    def _score(self, outcome: Outcome, sheet: Sheet) -> int | Fraction | None:
        whole = outcome.raw(sheet.answers)
        return outcome.prorated(sheet.answers) if whole is None and self.prorate else whole

    def absent(self, sheet: Sheet) -> list[str]:
        """Return the items without an answer."""
        return [item for item in self.items if sheet.answers.get(item) is None]

    def _enough(self, absent: int) -> bool:
        return self.prorate and len(self.items) - absent >= self.fewest * len(self.items)

    def refusal(self, sheet: Sheet) -> str:
        """Say why a questionnaire is not scored."""
        absent = self.absent(sheet)
        names = ", ".join(absent[:3]) + (f" and {len(absent) - 3} more" if absent[3:] else "")
        return f"incomplete: no answer to {names}"
