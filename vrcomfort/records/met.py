"""What the participants of a study have really met, from its files."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.design.audit import Met
from vrcomfort.protocol import Sequence, Trial
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.reader import Session, Study
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import enrolment_of


def what_was_met(study: Path) -> list[Met]:
    """Return what everybody who was enrolled has met: exposures that were shown whole, in order.

    Raises
    ------
    InputError
        If a file is damaged.
    """
    read = Study(study)
    return [_met(read, row) for row in read.enrolled]


def _met(study: Study, row: ParticipantRow) -> Met:
    sessions = tuple(_trials(session) for session in study.sessions_of(row.participant))
    run = Sequence.model_construct(name=row.sequence, group=row.group, sessions=sessions)
    return Met(row.participant, enrolment_of(row), run)


def _trials(session: Session) -> tuple[Trial, ...]:
    if not session.has(TrialRow):
        return ()
    table = session.table(TrialRow)
    table.require(("condition", "scene", "status"))
    whole = [row for row in table.dicts() if row["status"] == "completed"]
    return tuple(
        Trial(scene=row["scene"], condition=row["condition"], part=row.get("part") or None)
        for row in whole
    )
