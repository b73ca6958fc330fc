"""Selection of questionnaires: participants, timepoints, completeness, the last administration."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vrcomfort.plurals import counted
from vrcomfort.questionnaire import score_all
from vrcomfort.report.baselines import Values, moment_of
from vrcomfort.report.outcomes import Outcome, item_column, items_of

if TYPE_CHECKING:
    from vrcomfort.questionnaire import Instrument, Sheet
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


@dataclass(frozen=True)
class Unscored:
    """A questionnaire, or an exposure, without a score, and why."""

    participant: str
    questionnaire: str
    reason: str
    place: str


def kept_by_the_experimenter(study: StudyData) -> list[Sheet]:
    """Drop participants marked as excluded in participants.csv; `why_not` gives the reason."""
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
    chosen = plan.of_choices
    counts = Counter(s.timepoint for s in study.sheets if s.keys["instrument"] not in chosen)
    known = timepoints_of(plan)
    *first, last = known
    return [
        f"{counted(counts[name], 'questionnaires')} at `{name}` not used: the analysis plan names "
        f"{', '.join(first)} and {last}"
        for name in sorted(counts.keys() - set(known))
    ]


def timepoints_of(plan: Plan) -> tuple[str, ...]:
    """Return every timepoint that a plan names, in its order."""
    named = [plan.baseline_timepoint, plan.exposure_timepoint, plan.recovery_timepoint]
    named += [name for each in plan.contrasts for name in (each.a_timepoint, each.b_timepoint)]
    named += [rule.timepoint for rule in plan.exclusions]
    return tuple(dict.fromkeys(name for name in named if name))


def last_runs(sheets: list[Sheet], plan: Plan, excluded: list[Unscored]) -> list[Sheet]:
    """Drop administrations repeated later, but keep the baseline of each run of a session."""
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


def left_out(sheet: Sheet, reason: str) -> Unscored:
    """Return the row that says why a questionnaire is not scored."""
    return Unscored(sheet.participant, sheet.name, reason, sheet.place)


@dataclass(frozen=True)
class Scorer:
    """Scores the questionnaires of one instrument as a plan has it."""

    instrument: Instrument
    outcomes: tuple[Outcome, ...]
    prorate: bool
    fewest: float
    """Share of the items that must be answered to prorate."""

    @classmethod
    def of(cls, instrument: Instrument, outcomes: tuple[Outcome, ...], plan: Plan) -> Scorer:
        """Return the scorer of an instrument's outcomes."""
        return cls(
            instrument,
            tuple(each for each in outcomes if each.instrument == instrument.name),
            plan.missing_items == "prorate",
            plan.min_answered,
        )

    @property
    def items(self) -> tuple[str, ...]:
        """Return the columns of the answers that scores are made of."""
        return tuple(item_column(self.instrument, i) for i in items_of(self.instrument))

    def values_of(self, sheets: list[Sheet]) -> list[Values | None]:
        """Return raw scores and answers; None of a questionnaire with too few answers."""
        found = score_all(self.instrument, [sheet.answers for sheet in sheets])
        needed = {*self.instrument.needed, *(each.scale.name for each in self.outcomes)}
        whole = np.logical_and.reduce([found.known[name] for name in sorted(needed)]).tolist()
        names = [each.name for each in self.outcomes]
        raw = [found.raw[each.scale.name].tolist() for each in self.outcomes]
        columns = list(zip(items_of(self.instrument), self.items, strict=True))
        return [
            {column: sheet.answers.get(item) for item, column in columns}
            | dict(zip(names, scores, strict=True))
            if complete
            else self._prorated(sheet, columns)
            for sheet, complete, scores in zip(sheets, whole, zip(*raw, strict=True), strict=True)
        ]

    def _prorated(self, sheet: Sheet, columns: list[tuple[str, str]]) -> Values | None:
        absent, count = len(self.absent(sheet)), len(self.instrument.asked)
        if not self.prorate or count - absent < self.fewest * count:
            return None
        found: Values = {column: sheet.answers.get(item) for item, column in columns}
        for outcome in self.outcomes:
            found[outcome.name] = outcome.prorated(sheet.answers, self.instrument)
        return None if any(found[each.name] is None for each in self.outcomes) else found

    def absent(self, sheet: Sheet) -> list[str]:
        """Return the asked items without an answer."""
        return [i.name for i in self.instrument.asked if sheet.answers.get(i.name) is None]

    def refusal(self, sheet: Sheet) -> str:
        """Say why a questionnaire is not scored."""
        absent = self.absent(sheet)
        if not absent:
            return "incomplete: no weights are given"
        names = ", ".join(absent[:3]) + (f" and {len(absent) - 3} more" if absent[3:] else "")
        return f"incomplete: no answer to {names}"
