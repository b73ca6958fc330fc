"""What the participants of a study have really met, from its files."""

from __future__ import annotations

from pathlib import Path

from vrcomfort.csv_table import CsvTable
from vrcomfort.design.audit import Met
from vrcomfort.protocol import Sequence, Trial
from vrcomfort.records.exposure_rows import TrialRow
from vrcomfort.records.recorder import session_folder
from vrcomfort.records.session_rows import ParticipantRow
from vrcomfort.records.study import enrolment_of, read_participants, recorded_sessions


def what_was_met(study: Path) -> list[Met]:
    """Return what everybody who was enrolled has met: exposures that were shown whole, in order.

    Raises
    ------
    InputError
        If a file is damaged.
    """
    return [_met(study, row) for row in read_participants(study)]


def _met(study: Path, row: ParticipantRow) -> Met:
    sessions = tuple(
        _session(session_folder(study, row.participant, number) / TrialRow.FILE)
        for number in recorded_sessions(study, row.participant)
    )
    run = Sequence.model_construct(name=row.sequence, group=row.group, sessions=sessions)
    return Met(row.participant, enrolment_of(row), run)


def _session(file: Path) -> tuple[Trial, ...]:
    if not file.exists():
        return ()
    table = CsvTable.read(file, appended=True)
    table.require(("condition", "scene", "status"))
    whole = [row for row in table.dicts() if row["status"] == "completed"]
    return tuple(
        Trial(scene=row["scene"], condition=row["condition"], part=row.get("part") or None)
        for row in whole
    )
