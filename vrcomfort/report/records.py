"""What a report says beside its tests: who took part, how they answered, what they met and felt."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vrcomfort.report.answering import answering
from vrcomfort.report.counterbalancing import counterbalancing
from vrcomfort.report.flow import participant_flow
from vrcomfort.report.stimulus_time import frame_rows, movement, stimulus_time
from vrcomfort.report.symptoms import recovery_rows, symptom_rows
from vrcomfort.report.withdrawals import find_withdrawals

if TYPE_CHECKING:
    from vrcomfort.report.exposures import Exposures
    from vrcomfort.report.plan import Plan
    from vrcomfort.report.study_data import StudyData


def records(
    study: StudyData, scored: Exposures, plan: Plan, results: dict[str, Any]
) -> dict[str, Any]:
    """Return the parts of results.json that are counted, not tested."""
    names = [condition["name"] for condition in results["conditions"]]
    analysed, tests = results["participants"]["analysed"], results["tests"]
    withdrawn = find_withdrawals(study)
    return {
        "flow": participant_flow(study, scored, plan, withdrawn, tests, analysed),
        "symptoms": symptom_rows(scored, names, tests, study.instruments),
        "recovery_course": recovery_rows(scored),
        "counterbalancing": counterbalancing(scored.table, names, analysed),
        "answering": answering(study),
        "stimulus_time": stimulus_time(study, names),
        "movement": movement(study, names),
        "frame_measures": frame_rows(study),
    }
