"""Participant flow from enrolment to analysis: the stages, and the reasons of losses."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from vrcomfort.report.rows import INLINE
from vrcomfort.report.withdrawals import AFTER, everybody, screened_out

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.report.withdrawals import Withdrawal

EXCLUDED = "excluded by the experimenter"
SCREENED = "screened out by the experimenter"
UNFINISHED = "sessions not finished"
NO_EXPOSURE = "no exposure on record"
MISSING = "not every planned exposure has a score"


@dataclass(frozen=True)
class FlowLoss:
    """The number of people lost before the next stage, for one reason."""

    reason: str
    n: int


@dataclass(frozen=True)
class AnalysedCounts:
    """Counts among the analysed: withdrawn people, and people in every test."""

    again: int
    in_every_test: int


@dataclass(frozen=True)
class FlowStage:
    """A stage of the flow chart, and the losses on the way to the next one."""

    stage: str
    n: int
    left: list[FlowLoss]
    analysed: AnalysedCounts | None = field(default=None, metadata=INLINE)


def participant_flow(
    study: StudyData,
    scored: Exposures,
    plan: Plan,
    found: Sequence[Withdrawal],
    analysed: Sequence[str],
    in_every_test: int,
) -> list[FlowStage]:
    """Return the stages of the flow chart.

    People who withdrew are analysed all the same in a test whose exposures they had finished;
    `again` counts them.
    """
    enrolled = everybody(study)
    recorded = {t["participant"] for t in study.trials}
    met = recorded | {*scored.table["participant"], *analysed}
    met |= {s.participant for s in study.sheets if s.timepoint == plan.exposure_timepoint}
    status = {p["participant"]: p["status"] for p in study.participants}
    left = {w.participant: _how(w) for w in found}
    left |= dict.fromkeys(screened_out(study), SCREENED)
    for name, state in status.items():
        if state == "excluded":
            left[name] = EXCLUDED
        elif state == "enrolled" and name in recorded:  # of an import, nothing says more
            left.setdefault(name, UNFINISHED)
    exposed = [name for name in enrolled if name in met]
    completed = [name for name in exposed if name not in left]
    tested = set(analysed)
    why = _reasons(scored)
    absent = {p: left.get(p, NO_EXPOSURE) for p in enrolled if p not in met}
    return [
        _stage("Enrolled", enrolled, absent),
        _stage("Exposed", exposed, {p: left[p] for p in exposed if p in left}),
        _stage("Completed", completed,
               {p: why.get(p, MISSING) for p in completed if p not in tested}),
        FlowStage("Analysed", len(analysed), [], AnalysedCounts(
            sum(p in left for p in analysed), in_every_test
        )),
    ]  # fmt: skip


def _stage(name: str, people: list[str], gone: dict[str, str]) -> FlowStage:
    losses = [FlowLoss(reason, n) for reason, n in Counter(gone.values()).most_common()]
    return FlowStage(name, len(people), losses)


def _how(withdrawal: Withdrawal) -> str:
    if not withdrawal.condition:
        return "withdrew before the first exposure"
    return "withdrew after an exposure" if withdrawal.how == AFTER else _DURING[withdrawal.how]


_DURING = {"withdrew": "withdrew during an exposure", "stop rule": "stopped by the stop rule"}


def _reasons(scored: Exposures) -> dict[str, str]:
    """Return participant → the first reason for which a questionnaire was not scored."""
    found: dict[str, str] = {}
    for row in scored.excluded:
        found.setdefault(row.participant, row.reason.partition(":")[0])
    return found
