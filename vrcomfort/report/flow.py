"""From enrolment to analysis: how many people reached what, and why the others did not."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

from vrcomfort.report.withdrawals import AFTER, everybody, screened_out

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.pairs import Tested
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData
    from vrcomfort.report.withdrawals import Withdrawal

Row = dict[str, Any]

EXCLUDED = "excluded by the experimenter"
SCREENED = "screened out by the experimenter"
UNFINISHED = "sessions not finished"
NO_EXPOSURE = "no exposure on record"
MISSING = "not every planned exposure has a score"


def participant_flow(
    study: StudyData,
    scored: Exposures,
    plan: Plan,
    found: list[Withdrawal],
    tests: Sequence[Tested],
    analysed: list[str],
) -> list[Row]:
    """Return the stages: name, n, and the reasons of those who did not reach the next one.

    Somebody who withdrew is analysed all the same in a test whose exposures they had finished;
    `again` counts them.
    """
    enrolled = everybody(study)
    met = {t["participant"] for t in study.trials}
    met |= {s.participant for s in study.sheets if s.timepoint == plan.exposure_timepoint}
    met |= {*scored.table["participant"], *analysed}
    status = {p["participant"]: p["status"] for p in study.participants}
    left = {w.participant: _how(w) for w in found}
    left |= dict.fromkeys(screened_out(study), SCREENED)
    for name, state in status.items():
        if state == "excluded":
            left[name] = EXCLUDED
        elif state == "enrolled" and name in met:
            left.setdefault(name, UNFINISHED)
    exposed = [name for name in enrolled if name in met]
    completed = [name for name in exposed if name not in left]
    tested = set(analysed)
    why = _reasons(scored)
    every = set(analysed).intersection(*(t.participants for t in tests if t.participants))
    absent = {p: left.get(p, NO_EXPOSURE) for p in enrolled if p not in met}
    return [
        _stage("Enrolled", enrolled, absent),
        _stage("Exposed", exposed, {p: left[p] for p in exposed if p in left}),
        _stage("Completed", completed,
               {p: why.get(p, MISSING) for p in completed if p not in tested}),
        {**_stage("Analysed", analysed, {}), "again": sum(p in left for p in analysed),
         "in_every_test": len(every) if tests else len(analysed)},
    ]  # fmt: skip


def _stage(name: str, people: list[str], gone: dict[str, str]) -> Row:
    reasons = [{"reason": why, "n": n} for why, n in Counter(gone.values()).most_common()]
    return {"stage": name, "n": len(people), "left": reasons}


def _how(withdrawal: Withdrawal) -> str:
    if not withdrawal.condition:
        return "withdrew before the first exposure"
    return "withdrew after an exposure" if withdrawal.how == AFTER else _DURING[withdrawal.how]


_DURING = {"withdrew": "withdrew during an exposure", "stop rule": "stopped by the stop rule"}


def _reasons(scored: Exposures) -> dict[str, str]:
    """Return participant → the first reason why a questionnaire of theirs was not scored."""
    found: dict[str, str] = {}
    for row in scored.excluded:
        found.setdefault(row["participant"], row["reason"].partition(":")[0])
    return found
